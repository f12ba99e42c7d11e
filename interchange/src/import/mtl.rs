//! Materials of a Wavefront MTL file, with the PBR keys that Blender and others add.
//!
//! Parsed here instead of by `tobj`, which panics at a color of fewer than three numbers and drops the whole library at
//! one bad line.

mod lost;
mod statements;

pub(super) use statements::{MtlEntry, parse};

use super::{files::Trouble, textures::TextureLibrary};
use crate::{import::source::Source, names::listed};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{BrdfModel, GgxParameters},
    color::luminance,
    material::Material,
    texture::{Channel, ColorSpace, Texels, Texture, TextureSlot},
};
use lost::Lost;
use statements::MapStatement;
use std::collections::HashMap;

/// Height in meters of a white texel of a bump map with multiplier 1; MTL has no unit for it.
pub(crate) const BUMP_METRES: f32 = 0.01;

/// A specular color up to this is taken as reflectance at normal incidence, a larger one as a Phong weight.
pub(crate) const LARGEST_DIELECTRIC_F0: f32 = 0.2;

/// What the texels of the map of a key are: MTL itself does not say it.
pub(crate) fn color_space(key: &str) -> ColorSpace {
    let is_color = ["map_kd", "map_ke"].iter().any(|color| key.eq_ignore_ascii_case(color));
    if is_color { ColorSpace::Srgb } else { ColorSpace::Linear }
}

/// Adds the materials called `names` to `source`, from the library `entries`, and reports missing and ignored ones.
///
/// # Errors
/// [`Trouble::Memory`].
pub(super) fn add_materials(
    source: &mut Source,
    names: &[String],
    entries: &HashMap<String, MtlEntry>,
    library: &mut TextureLibrary,
) -> Result<(), Trouble> {
    let mut lost = Lost::default();
    for name in names {
        let Some(entry) = entries.get(name) else {
            source.push_uncolored(Material { name: name.clone(), ..Default::default() });
            continue;
        };
        lost.inspect(name, entry);
        let material = material(name, entry, library)?;
        match base_color(entry) {
            Some(_) => source.materials.push(material),
            None => source.push_uncolored(material),
        }
    }
    let missing: Vec<String> = names.iter().filter(|n| !entries.contains_key(*n)).cloned().collect();
    if !missing.is_empty() {
        source.warnings.push(format!(
            "the materials {} are in no material library and show gray; put the .mtl file beside the scene",
            listed(&missing)
        ));
    }
    lost.warn(&mut source.warnings);
    Ok(())
}

fn material(name: &str, entry: &MtlEntry, library: &mut TextureLibrary) -> Result<Material, Trouble> {
    let mut material = Material { name: name.to_owned(), parameters: parameters(entry).into(), ..Default::default() };
    let whole = if entry.map("map_ke").is_some() { Vec3::ONE } else { Vec3::ZERO };
    // Programs leave the color black when a texture replaces it.
    material.set_emission(entry.color("ke").filter(|ke| ke.max_element() > 0.0).unwrap_or(whole));
    let opacity = entry.opacity();
    if opacity < 1.0 {
        material.parameters.set("geometry_opacity", opacity.max(0.0));
    }
    add_maps(&mut material, entry, library)?;
    add_layers(&mut material, entry);
    add_layer_maps(&mut material, entry, library)?;
    Ok(material)
}

/// Coat (`Pc`, of roughness `Pcr`) and sheen (`Ps`): either makes a material OpenPBR.
fn add_layers(material: &mut Material, entry: &MtlEntry) {
    // A map alone has the weight 1.
    let weight = |key, map| entry.number(key).unwrap_or(if entry.map(map).is_some() { 1.0 } else { 0.0 });
    let (coat, sheen) = (weight("pc", "map_pc"), weight("ps", "map_ps"));
    if coat <= 0.0 && sheen <= 0.0 {
        return;
    }
    material.change_model(BrdfModel::OpenPbr);
    let parameters = &mut material.parameters;
    parameters.set("coat_weight", coat);
    parameters.set("coat_roughness", entry.number("pcr").unwrap_or(0.0));
    parameters.set("fuzz_weight", sheen);
}

/// Maps of coat and sheen, where the material has them.
fn add_layer_maps(material: &mut Material, entry: &MtlEntry, library: &mut TextureLibrary) -> Result<(), Trouble> {
    for (key, name) in [("map_pc", "coat_weight"), ("map_pcr", "coat_roughness"), ("map_ps", "fuzz_weight")] {
        let Some(map) = entry.map(key).filter(|_| material.model == BrdfModel::OpenPbr) else { continue };
        material.maps.set(name, Some(texture_slot(&map, key, library)?));
    }
    Ok(())
}

/// `aniso`, rotated by `anisor` of a whole turn: snaps to the tangent or across it, whichever is nearer.
fn anisotropy(entry: &MtlEntry) -> f32 {
    let amount = entry.number("aniso").unwrap_or(0.0);
    let from_tangent = (2.0 * entry.number("anisor").unwrap_or(0.0)).rem_euclid(1.0);
    if (from_tangent - 0.5).abs() < 0.25 { -amount } else { amount }
}

/// A highlight of this luminance says metal where it is this many times as bright as any channel of the color below it: programs give
/// plastics highlights up to 1, over a color that may be as bright, and saturated.
const LEAST_METAL: f32 = 0.6;
const METAL_OVER_COLOR: f32 = 1.5;

/// Whether `Ks` says a metal that MTL itself has no word for: hardly anything but a highlight, of something opaque without a picture.
fn is_metal_by_highlight(entry: &MtlEntry) -> bool {
    let is_plain = entry.number("pm").is_none()
        && ["map_kd", "map_pm"].iter().all(|map| entry.map(map).is_none())
        && !entry.is_transparent();
    let outshines = |(color, highlight): (Vec3, Vec3)| {
        let highlight = luminance(highlight);
        highlight > LEAST_METAL && highlight > METAL_OVER_COLOR * color.max_element()
    };
    is_plain && entry.color("kd").zip(entry.color("ks")).is_some_and(outshines)
}

fn metalness(entry: &MtlEntry) -> f32 {
    let default = if entry.map("map_pm").is_some() || is_metal_by_highlight(entry) { 1.0 } else { 0.0 };
    entry.number("pm").unwrap_or(default)
}

/// Whether the color is black, so that a metal has that of its highlight.
fn is_black(entry: &MtlEntry) -> bool {
    entry.color("kd").is_some_and(|kd| luminance(kd) < 0.05)
}

/// The base color, if the material has any.
fn base_color(entry: &MtlEntry) -> Option<Vec3> {
    let has_map = entry.map("map_kd").is_some();
    match (entry.color("kd"), entry.color("ks")) {
        (_, Some(ks)) if is_metal_by_highlight(entry) || metalness(entry) > 0.5 && is_black(entry) => Some(ks),
        // Programs leave the color black when a texture replaces it.
        (Some(kd), _) if !(has_map && kd.max_element() <= 0.0) => Some(kd),
        _ => has_map.then_some(Vec3::ONE),
    }
}

fn parameters(entry: &MtlEntry) -> GgxParameters {
    let has = |map: &str| entry.map(map).is_some();
    let metalness = metalness(entry);
    let base_color = base_color(entry).unwrap_or(GgxParameters::default().base_color);
    let (ior, weight) = dielectric(entry.number("ni"), entry.color("ks"), has("map_ks"));
    let roughness = entry.number("pr").unwrap_or_else(|| match entry.number("ns") {
        _ if has("map_pr") => 1.0,
        // The Blinn-Phong lobe is as wide as alpha = sqrt(2 / (Ns + 2)), and roughness = sqrt(alpha).
        Some(shininess) => (2.0 / (shininess.max(0.0) + 2.0)).powf(0.25),
        None => GgxParameters::default().roughness,
    });
    let anisotropy = anisotropy(entry);
    GgxParameters { base_color, roughness, metalness, anisotropy, ior, specular: weight, ..Default::default() }
}

/// Index of refraction and specular weight from `Ni` and `Ks`.
fn dielectric(ni: Option<f32>, ks: Option<Vec3>, has_map: bool) -> (f32, f32) {
    let ior = ni.filter(|n| *n > 1.0 && *n <= 4.0);
    let f0 = |ior: f32| ((ior - 1.0) / (ior + 1.0)).powi(2);
    match ks.map(|ks| luminance(ks).max(0.0)) {
        Some(ks) if ks == 0.0 && has_map => (ior.unwrap_or(1.5), 1.0),
        Some(ks) if ks > LARGEST_DIELECTRIC_F0 || ks == 0.0 => (ior.unwrap_or(1.5), ks.min(1.0)),
        Some(ks) => match ior {
            Some(ior) => (ior, (ks / f0(ior)).min(1.0)),
            None => ((1.0 + ks.sqrt()) / (1.0 - ks.sqrt()), 1.0),
        },
        None => (ior.unwrap_or(1.5), 1.0),
    }
}

fn add_maps(material: &mut Material, entry: &MtlEntry, library: &mut TextureLibrary) -> Result<(), Trouble> {
    // The first of the keys that the entry has.
    let mut slot = |keys: &[&str]| {
        let map = keys.iter().find_map(|key| Some((key, entry.map(key)?)));
        map.map(|(key, m)| texture_slot(&m, key, library).map(|slot| (m.multiplier, slot))).transpose()
    };
    let mut value = |key: &str| slot(&[key]).map(|found| found.map(|(_, slot)| slot));
    let maps = &mut material.maps;
    maps.set("base_color", value("map_kd")?);
    maps.set("roughness", value("map_pr")?);
    maps.set("metalness", value("map_pm")?);
    maps.set("emission_color", value("map_ke")?);
    maps.set("specular", value("map_ks")?);
    maps.set("normal", slot(&["norm", "map_kn"])?.map(with_strength));
    let bump = slot(&["bump", "map_bump"])?;
    match bump {
        // Many exporters use this key for normal maps.
        Some(bump) if looks_like_normals(&library.textures[bump.1.texture as usize]) => {
            let normal = maps.get("normal").cloned().unwrap_or_else(|| with_strength(bump));
            maps.set("normal", Some(normal));
        }
        Some((multiplier, slot)) => maps.set("bump", Some(with_strength((BUMP_METRES * multiplier, slot)))),
        None => {}
    }
    if let Some(map) = entry.map("map_d") {
        let slot = texture_slot(&map, "map_d", library)?;
        // A picture with an alpha channel has the opacity there, whatever its colors.
        let has_alpha = library.textures[slot.texture as usize].least(Channel::A as usize, ColorSpace::Linear) < 1.0;
        let channel = map.channel.unwrap_or(if has_alpha { Channel::A } else { Channel::R });
        maps.set("geometry_opacity", Some(TextureSlot { channel, ..slot }));
    }
    Ok(())
}

fn with_strength((strength, slot): (f32, TextureSlot)) -> TextureSlot {
    TextureSlot { strength, ..slot }
}

/// MTL counts v from the bottom of the picture: `1 - (s (1 - v) + o) = s v + (1 - s - o)`.
fn texture_slot(map: &MapStatement, key: &str, library: &mut TextureLibrary) -> Result<TextureSlot, Trouble> {
    Ok(TextureSlot {
        texture: library.load(&map.file)?,
        color_space: color_space(key),
        channel: map.channel.unwrap_or_default(),
        scale: map.scale,
        offset: Vec2::new(map.offset.x, 1.0 - map.scale.y - map.offset.y),
        wrap: [map.wrap; 2],
        ..Default::default()
    })
}

/// Whether the mean texel is the light blue of tangent-space normals.
fn looks_like_normals(texture: &Texture) -> bool {
    let mean = match &texture.texels {
        Texels::U8(texels) => {
            let sum = texels.iter().fold([0u64; 3], |s, t| [0, 1, 2].map(|c| s[c] + u64::from(t[c])));
            sum.map(|s| s as f32 / (255.0 * texels.len() as f32))
        }
        Texels::U16(texels) => {
            let sum = texels.iter().fold([0u64; 3], |s, t| [0, 1, 2].map(|c| s[c] + u64::from(t[c])));
            sum.map(|s| s as f32 / (65_535.0 * texels.len() as f32))
        }
        Texels::F32(texels) | Texels::Wide { texels, .. } => {
            let sum = texels.iter().fold([0f64; 3], |s, t| [0, 1, 2].map(|c| s[c] + f64::from(t[c])));
            sum.map(|s| s as f32 / texels.len() as f32)
        }
    };
    let [r, g, b] = mean;
    (r - 0.5).abs() < 0.12 && (g - 0.5).abs() < 0.12 && b > 0.75
}

#[cfg(test)]
mod tests {
    use super::{statements::entry, *};

    #[test]
    fn damaged_lines_cost_only_themselves() {
        let m = parameters(&entry("Kd 0.5\nKs spectral file.rfl\nNs\nPr 0.25\nKe 1 nan 0\nd"));
        assert_eq!((m.base_color, m.roughness), (Vec3::splat(0.5), 0.25));
    }

    #[test]
    fn shininess_becomes_roughness_unless_there_is_one() {
        assert!((parameters(&entry("Ns 30")).roughness - 0.5).abs() < 1e-6); // alpha = 1/4
        assert_eq!(parameters(&entry("Ns 30\nPr 0.9")).roughness, 0.9);
    }

    #[test]
    fn specular_colours_become_reflectance_weight_or_metal() {
        let glossy = parameters(&entry("Ks 0.04 0.04 0.04"));
        assert!((glossy.ior - 1.5).abs() < 1e-5 && glossy.specular == 1.0);
        assert_eq!(parameters(&entry("Ks 0 0 0\nNi 1.5")).specular, 0.0);
        assert_eq!(parameters(&entry("Ks 0.5 0.5 0.5\nKd 0.01 0.01 0.01")).metalness, 0.0);
        let mirror = parameters(&entry("Kd 0 0 0\nKs 0.9 0.8 0.7"));
        assert_eq!((mirror.metalness, mirror.base_color), (1.0, Vec3::new(0.9, 0.8, 0.7)));
        let metal = parameters(&entry("Kd 0 0 0\nKs 0.5 0.4 0.3\nPm 1"));
        assert_eq!((metal.metalness, metal.base_color), (1.0, Vec3::new(0.5, 0.4, 0.3)));
    }

    #[test]
    fn a_highlight_that_outshines_its_color_is_a_metal_and_is_told() {
        // The chrome of the OpenGL material tables, and what programs write for plastic, glass and pictures.
        let chrome = "Kd 0.4 0.4 0.4\nKs 0.774597 0.774597 0.774597\nNs 76.8";
        let metal = parameters(&entry(chrome));
        assert_eq!((metal.metalness, metal.base_color), (1.0, Vec3::splat(0.774_597)));
        assert!((metal.roughness - (2.0_f32 / 78.8).powf(0.25)).abs() < 1e-6);
        for other in [
            "Kd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nNs 225",
            "Kd 0.7 0.7 0.7\nKs 1 1 1\nNs 100",
            // Red plastic of those tables, and a blue one.
            "Kd 0.5 0 0\nKs 0.7 0.6 0.6\nNs 32",
            "Kd 0 0 1\nKs 1 1 1\nNs 100",
            "Kd 0 0 0\nKs 0.9 0.9 0.9\nd 0.2",
            "Kd 0 0 0\nKs 0.9 0.9 0.9\nmap_Kd wood.png",
            &format!("{chrome}\nPm 0"),
        ] {
            assert_eq!(parameters(&entry(other)).metalness, 0.0, "{other}");
        }
        let warned = |text: &str| {
            let (mut lost, mut warnings) = (Lost::default(), Vec::new());
            lost.inspect("bumper", &entry(text));
            lost.warn(&mut warnings);
            warnings
        };
        assert!(warned(chrome).iter().any(|warning| warning.contains("\"bumper\" are metals")), "{:?}", warned(chrome));
        assert_eq!(warned("Kd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nNs 225"), Vec::<String>::new());
    }
}
