//! Writes a material library in MTL, with the PBR keys of Blender and others, which `import::mtl` reads.

use crate::{
    import::mtl::{BUMP_METRES, LARGEST_DIELECTRIC_F0, color_space},
    material_file::{MaterialFile, SlotFile},
    materialx::{stretch, without_file},
};
use glam::Vec3;
use lapidary_core::{
    brdf::{BrdfModel, Value},
    color::luminance,
    material::{BUMP, NORMAL},
    texture::{Channel, ColorSpace, UvSet, Wrap},
};
use std::{collections::BTreeSet, fmt::Write};

/// Quantities with a key.
const HELD: [&str; 15] = [
    "base_weight",
    "base_color",
    "roughness",
    "metalness",
    "specular",
    "ior",
    "anisotropy",
    "coat_weight",
    "coat_roughness",
    "fuzz_weight",
    "emission_color",
    "emission_luminance",
    "geometry_opacity",
    "opacity_cutoff",
    "edge_color",
];

/// Keys of maps by quantity.
const MAPS: [(&str, &str); 10] = [
    ("base_color", "map_Kd"),
    ("roughness", "map_Pr"),
    ("metalness", "map_Pm"),
    ("specular", "map_Ks"),
    ("coat_weight", "map_Pc"),
    ("coat_roughness", "map_Pcr"),
    ("fuzz_weight", "map_Ps"),
    ("emission_color", "map_Ke"),
    ("emission_luminance", "map_Ke"),
    ("geometry_opacity", "map_d"),
];

/// The largest index of refraction that readers accept.
const MOST_IOR: f32 = 4.0;

/// The text of a library; `remarks` gets the features that MTL lacks.
pub fn library(materials: &[MaterialFile], remarks: &mut Vec<String>) -> String {
    let mut text = String::from("# Materials of Lapidary\n");
    let mut names = BTreeSet::new();
    for material in materials {
        if !names.insert(material.name.trim()) {
            remarks.push(format!("two materials are called \"{}\", and readers of MTL take the last", material.name));
        }
        let mut lost = Vec::new();
        let material = &*without_file(material, &mut lost);
        let mut entry = Entry { material, text: String::new(), lost };
        entry.write();
        let Entry { text: written, lost, .. } = entry;
        text += &written;
        remarks.extend(lost.into_iter().map(|lost| format!("material \"{}\": {lost}", material.name)));
    }
    text
}

struct Entry<'a> {
    material: &'a MaterialFile,
    text: String,
    lost: Vec<String>,
}

impl Entry<'_> {
    fn value(&self, quantity: &str) -> Option<Value> {
        let parameter = self.material.model.parameter_for(quantity)?;
        Some(parameter.sanitized(self.material.parameters.value(parameter)))
    }

    fn number(&self, quantity: &str, default: f32) -> f32 {
        self.value(quantity).map_or(default, Value::number)
    }

    fn map(&self, quantity: &str) -> Option<&SlotFile> {
        self.material.maps.get(self.material.model.parameter_for(quantity)?.name)
    }

    fn line(&mut self, key: &str, value: impl std::fmt::Display) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{key} {value}");
    }

    fn color(&mut self, key: &str, Vec3 { x, y, z }: Vec3) {
        self.line(key, format_args!("{x} {y} {z}"));
    }

    fn write(&mut self) {
        // A name ends with its line.
        let name: String = self.material.name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        self.text += "\n";
        self.line("newmtl", if name.trim().is_empty() { "material" } else { name.trim() });
        self.line("illum", 2);
        self.write_base();
        self.write_layers();
        self.write_light();
        self.write_maps();
        self.tell_lost();
    }

    fn write_base(&mut self) {
        let base = self.value("base_color").map_or(Vec3::splat(0.8), Value::color) * self.number("base_weight", 1.0);
        let has_highlight = self.value("roughness").is_some();
        let metalness = self.number("metalness", 0.0);
        let [roughness, anisotropy] = self.lobe();
        let ior = self.number("ior", 1.5);
        let weight = if has_highlight { self.number("specular", 1.0) } else { 0.0 };
        self.color("Kd", base);
        if metalness > 0.5 && luminance(base) < 0.05 {
            // Readers take the color of a black metal from here.
            self.color("Ks", base);
        } else {
            self.color("Ks", Vec3::splat(specular_color(weight, ior)));
        }
        self.line("Ns", (2.0 / roughness.max(0.03).powi(4) - 2.0).clamp(0.0, 1000.0));
        self.line("Ni", ior);
        self.line("Pr", roughness);
        self.line("Pm", metalness);
        if anisotropy != 0.0 {
            self.line("aniso", anisotropy.abs());
            self.line("anisor", if anisotropy < 0.0 { 0.25 } else { 0.0 });
        }
        if ior > MOST_IOR {
            self.lost
                .push(format!("its index of refraction is above {MOST_IOR}, which readers of MTL take for a mistake"));
        }
    }

    fn has_layers(&self) -> bool {
        self.number("coat_weight", 0.0) > 0.0 || self.number("fuzz_weight", 0.0) > 0.0
    }

    /// Roughness and anisotropy. A reader converts a material with coat or fuzz to OpenPBR, which has another scale.
    fn lobe(&self) -> [f32; 2] {
        let own = [self.number("roughness", 1.0), self.number("anisotropy", 0.0)];
        if own[1] == 0.0 || self.material.model != BrdfModel::OpenPbr || self.has_layers() {
            return own;
        }
        let [roughness, squeeze] = stretch::to_burley(stretch::of_openpbr(own[0], own[1]));
        [roughness, (squeeze / 0.9).min(1.0)]
    }

    fn write_layers(&mut self) {
        if !self.has_layers() {
            return;
        }
        self.line("Pc", self.number("coat_weight", 0.0));
        self.line("Pcr", self.number("coat_roughness", 0.0));
        self.line("Ps", self.number("fuzz_weight", 0.0));
    }

    fn write_light(&mut self) {
        let luminance = self.number("emission_luminance", 0.0);
        if luminance > 0.0 {
            self.color("Ke", luminance * self.value("emission_color").map_or(Vec3::ONE, Value::color));
        }
        let opacity = self.number("geometry_opacity", 1.0);
        if opacity < 1.0 {
            self.line("d", opacity);
        }
    }

    fn write_maps(&mut self) {
        let mut last = "";
        for (quantity, key) in MAPS {
            let Some(slot) = self.map(quantity).cloned() else { continue };
            // Readers take a picture as emission on its own.
            if key == "map_Ke" && !(self.number("emission_luminance", 0.0) > 0.0) {
                self.lost.push("a map of its emission is left out, as it sends no light".into());
                continue;
            }
            if key == last {
                self.lost.push(format!("one of the two maps of {key} is left out"));
                continue;
            }
            last = key;
            self.write_map(key, &slot, None);
        }
        if let Some(slot) = self.material.maps.get(NORMAL).cloned() {
            if slot.flip_y {
                self.lost.push("MTL cannot say that its normals have their green down".into());
            }
            self.write_map("norm", &slot, Some(slot.strength));
        }
        if let Some(slot) = self.material.maps.get(BUMP).cloned() {
            self.write_map("bump", &slot, Some(slot.strength / BUMP_METRES));
        }
    }

    fn write_map(&mut self, key: &str, slot: &SlotFile, multiplier: Option<f32>) {
        let mut options = String::new();
        if let Some(multiplier) = multiplier.filter(|multiplier| *multiplier != 1.0) {
            let _ = write!(options, "-bm {multiplier} ");
        }
        let channel = match slot.channel {
            Channel::R => "",
            Channel::G => "-imfchan g ",
            Channel::B => "-imfchan b ",
            Channel::A => "-imfchan m ",
        };
        options += channel;
        match slot.wrap {
            [Wrap::Clamp, Wrap::Clamp] => options += "-clamp on ",
            [Wrap::Repeat, Wrap::Repeat] => {}
            _ => self.lost.push(format!("MTL can only repeat or clamp the picture of {key}; it repeats")),
        }
        let assumed = color_space(key);
        if slot.color_space.is_some_and(|space| space != assumed) {
            let taken = if assumed == ColorSpace::Srgb { "colors as its file has them" } else { "values" };
            self.lost.push(format!("MTL has no color spaces, and the picture of {key} is taken for {taken}"));
        }
        if slot.uv_set == UvSet::Second {
            self.lost.push(format!("MTL has one set of texture coordinates, and {key} uses the second"));
        }
        // MTL counts v from the bottom.
        let offset = [slot.offset.x, 1.0 - slot.scale.y - slot.offset.y];
        if offset != [0.0; 2] {
            let _ = write!(options, "-o {} {} 0 ", offset[0], offset[1]);
        }
        if slot.scale.to_array() != [1.0; 2] {
            let _ = write!(options, "-s {} {} 1 ", slot.scale.x, slot.scale.y);
        }
        if slot.rotation_degrees != 0.0 {
            self.lost.push(format!("MTL cannot turn the picture of {key}"));
        }
        self.line(key, format_args!("{options}{}", slot.file));
    }

    fn tell_lost(&mut self) {
        let material = self.material;
        let is_told = |name: &str| material.parameters.get(name).is_some();
        let lost = material.model.parameters().iter().chain(material.stored_parameters()).filter(|p| {
            let mapped =
                material.maps.get(p.name).is_some() && !MAPS.iter().any(|(quantity, _)| *quantity == p.quantity);
            let told = is_told(p.name) && material.parameters.value(p) != p.default && !HELD.contains(&p.quantity);
            mapped || told
        });
        if material.vertex_colors {
            self.lost.push("MTL does not say that the colors of vertices multiply its color".into());
        }
        let names: Vec<String> = lost.map(|p| p.label.to_lowercase()).collect();
        if !names.is_empty() {
            self.lost.push(format!("MTL has no place for its {}", names.join(", ")));
        }
        if self.number("opacity_cutoff", 0.0) > 0.0 {
            self.lost.push("MTL has no opacity below which it is cut out; it is blended".into());
        }
    }
}

/// `Ks`: the reflectance at normal incidence, or the weight for values that readers take as one.
fn specular_color(weight: f32, ior: f32) -> f32 {
    let reflectance = weight * ((ior - 1.0) / (ior + 1.0)).powi(2);
    if reflectance > LARGEST_DIELECTRIC_F0 { weight } else { reflectance }
}
