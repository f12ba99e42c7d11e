//! Materials as BSDFs of Mitsuba.
//!
//! `lambert` is exactly `diffuse`, and a Beckmann metal is `roughconductor`. A GGX metal is nearly that: Mitsuba treats shadowing
//! and masking as independent, this program correlates them by height (Heitz 2014, Eq. 99) and returns the light lost between
//! facets. Materials that transmit light are wrapped in a `mask`. All others become `principled` (Burley 2012) with the same lobe
//! width and color, and Burley's diffuse base.
//!
//! The exact form of `ggx` is the plugin `lapidary_ggx` in `tests/crosscheck`, an independent implementation of the formula.

use super::{textures::TextureFolder, xml};
use anyhow::Result;
use glam::{Vec3, Vec4};
use lapidary_core::{
    brdf::{GgxParameters, Metal, OpenPbrParameters, widths},
    color::luminance,
    material::{BrdfModel, Material},
    texture::TextureSlot,
};
use lapidary_interchange::materialx::stretch::{of_openpbr, to_burley};

/// Which BSDFs represent materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Models {
    /// The nearest ones in Mitsuba.
    Nearest,
    /// The same formulas, where a plugin has them.
    Exact,
}

/// Identifier of a material's BSDF on one or on both sides.
pub fn id(material: u32, two_sided: bool) -> String {
    format!("material-{material}{}", if two_sided { "-both-sides" } else { "" })
}

/// BSDFs of a material for one-sided triangles and for two-sided ones; `wanted` selects them in that order.
///
/// # Errors
/// An unwritable map.
pub fn bsdfs(
    material: &Material,
    index: u32,
    wanted: [bool; 2],
    models: Models,
    textures: &mut TextureFolder,
) -> Result<String> {
    let mut text = String::new();
    let material = &material.own();
    let mut writer = MaterialWriter { material, index, textures };
    let opacity = if lets_through(material) { Some(writer.opacity()?) } else { None };
    for two_sided in [false, true].into_iter().filter(|&both| wanted[usize::from(both)]) {
        let attributes = named(id(index, two_sided));
        let own = if opacity.is_none() { &attributes[..] } else { "" };
        let inner = match two_sided {
            false => writer.bumped(own, models)?,
            true => xml::plugin("bsdf", "twosided", own, &writer.bumped("", models)?),
        };
        text += &opacity
            .as_ref()
            .map_or(inner.clone(), |opacity| xml::plugin("bsdf", "mask", &attributes, &(opacity.clone() + &inner)));
    }
    Ok(text)
}

/// Whether a material may transmit light.
pub fn lets_through(material: &Material) -> bool {
    material.parameters.number("geometry_opacity") < 1.0 || material.maps.get("geometry_opacity").is_some()
}

fn named(id: String) -> String {
    format!(" id=\"{id}\"")
}

/// Writes one material.
struct MaterialWriter<'a, 't> {
    material: &'a Material,
    index: u32,
    textures: &'a mut TextureFolder<'t>,
}

impl MaterialWriter<'_, '_> {
    /// The model inside its normal map inside its bump map; `attributes` belong to the outermost.
    fn bumped(&mut self, attributes: &str, models: Models) -> Result<String> {
        let maps = &self.material.maps;
        let mut wrappers = Vec::new();
        if let Some(slot) = maps.get("normal") {
            // Mitsuba decodes 2 t - 1 and does not turn normals by `to_uv`: the texels hold strength, orientation and turn.
            let encoded = |texel: Vec4| 0.5 * (slot.tangent_normal(texel.truncate()) + 1.0);
            wrappers.push(("normalmap", self.map(Some("normalmap"), "normal", slot, encoded)?));
        }
        if let Some(slot) = maps.get("bump") {
            let height = |texel: Vec4| Vec3::splat(slot.strength * texel[slot.channel as usize]);
            wrappers.push(("bumpmap", self.map(None, "bump", slot, height)?));
        }
        let depth = wrappers.len();
        let outermost = |level: usize| if level == depth { attributes } else { "" };
        let mut bsdf = self.model(outermost(0), models)?;
        for (level, (kind, texture)) in wrappers.into_iter().enumerate() {
            bsdf = xml::plugin("bsdf", kind, outermost(level + 1), &(texture + &bsdf));
        }
        Ok(bsdf)
    }

    /// The share of light that `mask` blocks.
    fn opacity(&mut self) -> Result<String> {
        let parameters = self.material.parameters.clone().sanitized();
        let [opacity, cutoff] = ["geometry_opacity", "opacity_cutoff"].map(|name| parameters.number(name));
        let cut = |x: f32| if cutoff > 0.0 { f32::from(u8::from(x >= cutoff)) } else { x.clamp(0.0, 1.0) };
        let map = self.material.maps.get("geometry_opacity");
        match map {
            None => Ok(xml::value("float", "opacity", cut(opacity))),
            Some(_) => self.number("opacity", "opacity", opacity, map, cut),
        }
    }

    fn model(&mut self, attributes: &str, models: Models) -> Result<String> {
        let (kind, properties) = match (self.material.model, models) {
            (BrdfModel::Lambert | BrdfModel::OrenNayar, _) => ("diffuse", self.color("reflectance", "base_color")?),
            (BrdfModel::Ggx, Models::Exact) => ("lapidary_ggx", self.ggx()?),
            (BrdfModel::Beckmann | BrdfModel::Ggx, _) if self.is_metal() => ("roughconductor", self.conductor()?),
            _ => ("principled", self.principled()? + &self.layers()?),
        };
        Ok(xml::plugin("bsdf", kind, attributes, &properties))
    }

    fn ggx(&mut self) -> Result<String> {
        let maps = &self.material.maps;
        let p = GgxParameters::from(&self.material.parameters.clone().sanitized());
        let unit = |x: f32| x.clamp(0.0, 1.0);
        Ok([
            self.color("base_color", "base_color")?,
            self.color("edge_color", "edge_color")?,
            self.number("roughness", "roughness", p.roughness, maps.get("roughness"), unit)?,
            self.number("metalness", "metalness", p.metalness, maps.get("metalness"), unit)?,
            self.number("anisotropy", "anisotropy", p.anisotropy, maps.get("anisotropy"), |x| x.clamp(-1.0, 1.0))?,
            self.number("specular", "specular", p.specular, maps.get("specular"), unit)?,
            // The index above 1, which is the part that its map multiplies.
            self.number("ior_above_one", "ior", p.ior - 1.0, maps.get("ior"), |x| x.clamp(0.0, 9.0))?,
        ]
        .concat())
    }

    /// Whether it is a metal of uniform color, for which Mitsuba has the same Fresnel factor.
    fn is_metal(&self) -> bool {
        let material = self.material;
        let mapped = ["base_color", "metalness", "edge_color", "roughness", "anisotropy"]
            .into_iter()
            .any(|name| material.maps.get(name).is_some());
        !mapped && material.parameters.number("metalness") >= 1.0
    }

    fn conductor(&mut self) -> Result<String> {
        let parameters = self.material.parameters.clone().sanitized();
        let [eta, k] = Metal::new(parameters.color("base_color"), parameters.color("edge_color")).indices();
        let distribution = if self.material.model == BrdfModel::Beckmann { "beckmann" } else { "ggx" };
        let [x, y] = widths(parameters.number("roughness"), parameters.number("anisotropy"));
        Ok([
            xml::value("string", "distribution", distribution),
            xml::triple("rgb", "eta", eta),
            xml::triple("rgb", "k", k),
            xml::value("float", "alpha_u", x),
            xml::value("float", "alpha_v", y),
        ]
        .concat())
    }

    /// Coat and fuzz, if the model has them. Fuzz strength is its brightness.
    fn layers(&mut self) -> Result<String> {
        if self.material.model != BrdfModel::OpenPbr {
            return Ok(String::new());
        }
        let maps = &self.material.maps;
        let p = OpenPbrParameters::from(&self.material.parameters.clone().sanitized());
        let unit = |x: f32| x.clamp(0.0, 1.0);
        let fuzz = p.fuzz_weight * luminance(p.fuzz_color);
        let gloss = match maps.get("coat_roughness") {
            None => xml::value("float", "clearcoat_gloss", 1.0 - p.coat_roughness),
            Some(slot) => self.map(Some("clearcoat_gloss"), "coat-gloss", slot, |texel| {
                Vec3::splat(unit(1.0 - p.coat_roughness * texel[slot.channel as usize]))
            })?,
        };
        Ok([
            self.number("clearcoat", "coat-weight", p.coat_weight, maps.get("coat_weight"), unit)?,
            gloss,
            self.number("sheen", "fuzz-weight", fuzz, maps.get("fuzz_weight"), unit)?,
        ]
        .concat())
    }

    fn principled(&mut self) -> Result<String> {
        let mut common = self.material.clone();
        common.change_model(BrdfModel::Ggx);
        if self.material.model == BrdfModel::OpenPbr {
            take_from_openpbr(&mut common);
        } else if self.material.model.has_file() {
            let brdf = self.material.plain_brdf();
            let width = brdf.as_brdf().narrowest_lobe().unwrap_or(1.0);
            common.parameters.set("base_color", brdf.as_brdf().albedo().min(Vec3::ONE));
            common.parameters.set("roughness", width.sqrt());
        }
        MaterialWriter { material: &common, index: self.index, textures: self.textures }.principled_of_ggx()
    }

    fn principled_of_ggx(&mut self) -> Result<String> {
        let maps = &self.material.maps;
        let p = GgxParameters::from(&self.material.parameters.clone().sanitized());
        let unit = |x: f32| x.clamp(0.0, 1.0);
        Ok([
            self.color("base_color", "base_color")?,
            self.number("roughness", "roughness", p.roughness, maps.get("roughness"), unit)?,
            self.number("metallic", "metalness", p.metalness, maps.get("metalness"), unit)?,
            self.number("anisotropic", "stretch", p.anisotropy.abs(), maps.get("anisotropy"), |x| x.abs().min(1.0))?,
            xml::value("float", "eta", equivalent_eta(&p)),
        ]
        .concat())
    }

    /// The color of a parameter, or its map.
    fn color(&mut self, name: &str, parameter: &str) -> Result<String> {
        let color = self.material.parameters.clone().sanitized().color(parameter);
        match self.material.maps.get(parameter) {
            None => Ok(xml::triple("rgb", name, color)),
            Some(slot) => self.map(Some(name), &parameter.replace('_', "-"), slot, |texel| {
                (color * texel.truncate()).clamp(Vec3::ZERO, Vec3::ONE)
            }),
        }
    }

    /// A number in its range, or its map. `quantity` names the map's file.
    fn number(
        &mut self,
        name: &str,
        quantity: &str,
        number: f32,
        slot: Option<&TextureSlot>,
        range: impl Fn(f32) -> f32,
    ) -> Result<String> {
        match slot {
            None => Ok(xml::value("float", name, number)),
            Some(slot) => {
                self.map(Some(name), quantity, slot, |texel| Vec3::splat(range(number * texel[slot.channel as usize])))
            }
        }
    }

    fn map(
        &mut self,
        name: Option<&str>,
        quantity: &str,
        slot: &TextureSlot,
        value: impl Fn(Vec4) -> Vec3,
    ) -> Result<String> {
        self.textures.property(name, &format!("material-{}-{quantity}", self.index), slot, value)
    }
}

/// Gives a GGX material OpenPBR's missing properties: color weight, highlight brightness, and an equally wide lobe.
fn take_from_openpbr(common: &mut Material) {
    let p = OpenPbrParameters::from(&common.parameters.clone().sanitized());
    common.parameters.set("base_color", p.base_weight * p.base_color);
    common.parameters.set("specular", p.specular_weight * luminance(p.specular_color));
    let [roughness, squeeze] = to_burley(of_openpbr(p.specular_roughness, p.specular_roughness_anisotropy));
    common.parameters.set("roughness", roughness);
    common.parameters.set("anisotropy", (squeeze / 0.9).min(1.0));
}

/// The index of refraction with the material's reflectance at normal incidence, including its lobe weight.
fn equivalent_eta(p: &GgxParameters) -> f32 {
    let root = ((p.ior - 1.0) / (p.ior + 1.0)) * p.specular.sqrt();
    // An index of one has no Fresnel factor to compute.
    ((1.0 + root) / (1.0 - root)).max(1.001)
}

/// Differences of a material's nearest BSDFs, beyond the differences by definition.
pub fn remarks(material: &Material) -> Vec<String> {
    let Material { name, model, parameters, maps, .. } = &material.own();
    let diffuse = [BrdfModel::Lambert, BrdfModel::OrenNayar].contains(model);
    let lobe = !diffuse;
    let has_equal = [BrdfModel::Lambert, BrdfModel::Beckmann, BrdfModel::Ggx].contains(model);
    [
        (!has_equal && lobe, "Mitsuba lacks its model: it becomes the principled one of the same width and color"),
        (!has_equal && diffuse, "Mitsuba lacks its model: it becomes a Lambertian one of the same color"),
        (
            lobe && parameters.number("anisotropy") < 0.0,
            "highlights are stretched along the tangent only, not across it",
        ),
        (lobe && maps.get("ior").is_some(), "the map of its index of refraction is left out"),
        (lobe && maps.get("specular").is_some(), "the map of its specular weight is left out"),
        (maps.get("opacity_cutoff").is_some(), "the map of its cutoff is left out"),
        (material.vertex_colors, "the colors of its vertices are left out"),
        (material.reads_second_uvs(), "maps with the second set of texture coordinates have the first"),
        (
            maps.slots().any(|slot| slot.procedural.is_none() && slot.wrap[0] != slot.wrap[1]),
            "maps that repeat, mirror or clamp along one axis do it along both",
        ),
        (
            parameters.number("opacity_cutoff") > 0.0 && maps.get("geometry_opacity").is_some(),
            "cutouts have soft edges within a texel",
        ),
    ]
    .into_iter()
    .chain(remarks_of_layers(material))
    .filter(|(differs, _)| *differs)
    .map(|(_, remark)| format!("material \"{name}\": {remark}"))
    .collect()
}

/// Features of OpenPBR that `principled` lacks.
fn remarks_of_layers(material: &Material) -> Vec<(bool, &'static str)> {
    if material.model != BrdfModel::OpenPbr {
        return Vec::new();
    }
    let maps = &material.maps;
    let p = OpenPbrParameters::from(&material.parameters.clone().sanitized());
    let has = |names: &[&str]| names.iter().any(|name| maps.get(name).is_some());
    let (is_coated, is_fuzzy) = (p.coat_weight > 0.0, p.fuzz_weight > 0.0);
    let is_colored = |color: Vec3| color.max_element() != color.min_element();
    let default = OpenPbrParameters::default();
    let other_coat = p.coat_color != Vec3::ONE
        || p.coat_roughness_anisotropy > 0.0
        || p.coat_darkening > 0.0
        || (p.coat_ior - 1.5).abs() > 1e-3
        || has(&["coat_color", "coat_ior", "coat_darkening", "coat_roughness_anisotropy"]);
    let other_fuzz = is_colored(p.fuzz_color)
        || p.fuzz_roughness != default.fuzz_roughness
        || has(&["fuzz_color", "fuzz_roughness"]);
    vec![
        (has(&["base_weight"]), "the map of its base weight is left out"),
        (
            p.base_diffuse_roughness > 0.0 || has(&["base_diffuse_roughness"]),
            "its diffuse base is Burley's, not a rough one",
        ),
        (is_colored(p.specular_color) || has(&["specular_color"]), "its highlight is as bright, without its color"),
        (has(&["specular_ior"]), "the map of its index of refraction is left out"),
        (has(&["specular_weight"]), "the map of its specular weight is left out"),
        (is_coated && other_coat, "its coat is a clear one of index 1.5 that does not darken"),
        (material.stored().next().is_some(), "what it stores and does not render is left out"),
        (is_fuzzy && other_fuzz, "its fuzz is Burley's sheen of the same brightness, without color and roughness"),
    ]
}
