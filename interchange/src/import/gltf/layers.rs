//! Coat, sheen, anisotropy, transmission and strong emission of glTF materials (`KHR_materials_clearcoat`, `_sheen`,
//! `_anisotropy`, `_transmission`, `_emissive_strength`), read from the JSON itself, because the `gltf` crate lacks them.
//!
//! A material with coat, sheen or specular color becomes OpenPBR. Its coat does not darken the base, as in glTF. Sheen
//! is the same lobe here, with the square of glTF's roughness. Transmission passes straight through a thin surface, as
//! opacity; where that is impossible, the material shows opaque with a remark.

use crate::{
    features::gltf::{ANISOTROPY_MAPS, COAT_NORMALS, TRANSMISSION_MAPS},
    fresnel::{set_specular_color, weigh_dielectric},
    import::fields,
    materialx::stretch,
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::BrdfModel,
    material::Material,
    texture::{Channel, ColorSpace, TextureSlot},
};
use serde::{
    Deserialize,
    de::{DeserializeOwned, IgnoredAny},
};
use serde_json::Value;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

const CLEARCOAT: &str = "KHR_materials_clearcoat";
const SHEEN: &str = "KHR_materials_sheen";
const ANISOTROPY: &str = "KHR_materials_anisotropy";
const TRANSMISSION: &str = "KHR_materials_transmission";
const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
const SPECULAR: &str = "KHR_materials_specular";

/// `KHR_texture_transform`.
#[derive(Clone, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Transform {
    pub offset: Vec2,
    pub rotation: f32,
    pub scale: Vec2,
    pub tex_coord: Option<u32>,
}

impl Transform {
    pub const EXTENSION: &str = "KHR_texture_transform";

    /// The transform in the extensions of a texture; the identity if it has none.
    ///
    /// # Errors
    /// A remark on a field of another kind.
    pub fn of(extensions: &Value) -> Result<Self, String> {
        let value = &extensions[Self::EXTENSION];
        if value.is_null() {
            return Ok(Self::default());
        }
        fields::contents(value).map_err(|reason| left_out(Self::EXTENSION, &reason))
    }
}

impl Default for Transform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation: 0.0, scale: Vec2::ONE, tex_coord: None }
    }
}

impl From<gltf::texture::TextureTransform<'_>> for Transform {
    fn from(t: gltf::texture::TextureTransform) -> Self {
        let (offset, scale) = (Vec2::from_array(t.offset()), Vec2::from_array(t.scale()));
        Self { offset, rotation: t.rotation(), scale, tex_coord: t.tex_coord() }
    }
}

/// A texture and its placement.
#[derive(Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    /// Index of the texture.
    pub index: usize,
    /// Set of coordinates.
    #[serde(default)]
    pub tex_coord: u32,
    #[serde(default)]
    extensions: Value,
}

impl TextureInfo {
    /// Its transform, or a remark why it has none.
    pub fn transform(&self) -> Result<Transform, String> {
        Transform::of(&self.extensions)
    }
}

#[derive(Clone, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Clearcoat {
    clearcoat_factor: f32,
    clearcoat_texture: Option<TextureInfo>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<TextureInfo>,
    clearcoat_normal_texture: Option<IgnoredAny>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Sheen {
    sheen_color_factor: Vec3,
    sheen_color_texture: Option<TextureInfo>,
    sheen_roughness_factor: f32,
    sheen_roughness_texture: Option<TextureInfo>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Anisotropy {
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    anisotropy_texture: Option<IgnoredAny>,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Transmission {
    transmission_factor: f32,
    transmission_texture: Option<IgnoredAny>,
}

#[derive(Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
struct EmissiveStrength {
    #[serde(default = "one")]
    emissive_strength: f32,
}

fn one() -> f32 {
    1.0
}

/// The color of a highlight; the `gltf` crate gives its weight.
#[derive(Clone, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Specular {
    specular_color_factor: Vec3,
    specular_color_texture: Option<TextureInfo>,
}

impl Default for Specular {
    fn default() -> Self {
        Self { specular_color_factor: Vec3::ONE, specular_color_texture: None }
    }
}

impl Specular {
    /// Whether it is a color: a gray is an index of refraction, see [`set_specular_color`]. Black stays black
    /// with a texture.
    fn is_colored(&self) -> bool {
        let color = self.specular_color_factor;
        color.max_element() != color.min_element() || self.specular_color_texture.is_some() && color.max_element() > 0.0
    }
}

/// The extensions of a material.
#[derive(Clone, Default)]
pub(super) struct Layers {
    clearcoat: Option<Clearcoat>,
    sheen: Option<Sheen>,
    anisotropy: Option<Anisotropy>,
    transmission: Option<Transmission>,
    emission: Option<EmissiveStrength>,
    specular: Option<Specular>,
    /// Remarks on extensions that cannot be read.
    wrong: Vec<String>,
}

/// Adds a map to a material.
type AddMap<'f, E> =
    dyn FnMut(&mut Material, &'static str, &Option<TextureInfo>, Channel, ColorSpace) -> Result<(), E> + 'f;

impl Layers {
    /// The extensions of each material of a document.
    pub fn of_all(document: &Value) -> Vec<Self> {
        let of = |material: &Value| {
            let mut wrong = Vec::new();
            let mut layers = Self {
                clearcoat: read(material, CLEARCOAT, &mut wrong),
                sheen: read(material, SHEEN, &mut wrong),
                anisotropy: read(material, ANISOTROPY, &mut wrong),
                transmission: read(material, TRANSMISSION, &mut wrong),
                emission: read(material, EMISSIVE_STRENGTH, &mut wrong),
                specular: read(material, SPECULAR, &mut wrong),
                wrong: Vec::new(),
            };
            layers.wrong = wrong;
            layers
        };
        document["materials"].as_array().map_or_else(Vec::new, |materials| materials.iter().map(of).collect())
    }

    /// Applies the extensions to a GGX material whose roughness texels have this `mean`; `slot` makes the slot of a
    /// texture. Returns remarks on the material.
    ///
    /// # Errors
    /// Errors of `slot`.
    pub fn add_to<E>(
        &self,
        material: &mut Material,
        mean: f32,
        mut slot: impl FnMut(&TextureInfo) -> Result<TextureSlot, E>,
    ) -> Result<Vec<String>, E> {
        let mut map =
            |material: &mut Material, name: &'static str, info: &Option<TextureInfo>, channel, color_space| {
                let made = info.as_ref().map(&mut slot).transpose()?;
                material.maps.set(name, made.map(|slot| TextureSlot { channel, color_space, ..slot }));
                Ok(())
            };
        // A metal's reflection has the color of its base alone.
        let is_metal = material.parameters.number("metalness") >= 1.0 && material.maps.get("metalness").is_none();
        let color = self.specular.as_ref().filter(|specular| specular.is_colored() && !is_metal);
        if self.clearcoat.is_some() || self.sheen.is_some() || color.is_some() {
            material.change_model(BrdfModel::OpenPbr);
        }
        self.add_coat(material, &mut map)?;
        self.add_sheen(material, &mut map)?;
        if let Some(color) = color {
            map(material, "specular_color", &color.specular_color_texture, Channel::R, ColorSpace::Srgb)?;
        }
        let mut told = self.told();
        if let Some(specular) = self.specular.as_ref().filter(|_| !is_metal) {
            let lost = set_specular_color(material, specular.specular_color_factor);
            told.extend(lost.map(|lost| format!("have a {lost}")));
        }
        if !weigh_dielectric(material) {
            told.push(
                "have a map of specular weight below a coat or sheen, which also scales the reflection of their metal"
                    .into(),
            );
        }
        if let Some(anisotropy) = &self.anisotropy {
            told.extend(anisotropy.stretch(material, mean).map(Into::into));
        }
        told.extend(self.transmission.as_ref().and_then(|transmission| transmission.thin_out(material)));
        if let Some(emission) = &self.emission {
            let luminance = material.parameters.number("emission_luminance");
            material.parameters.set("emission_luminance", luminance * emission.emissive_strength);
        }
        Ok(told)
    }

    fn add_coat<E>(&self, material: &mut Material, map: &mut AddMap<E>) -> Result<(), E> {
        let Some(coat) = &self.clearcoat else { return Ok(()) };
        material.parameters.set("coat_weight", coat.clearcoat_factor);
        material.parameters.set("coat_roughness", coat.clearcoat_roughness_factor);
        material.parameters.set("coat_ior", 1.5);
        material.parameters.set("coat_darkening", 0.0);
        map(material, "coat_weight", &coat.clearcoat_texture, Channel::R, ColorSpace::Linear)?;
        map(material, "coat_roughness", &coat.clearcoat_roughness_texture, Channel::G, ColorSpace::Linear)
    }

    fn add_sheen<E>(&self, material: &mut Material, map: &mut AddMap<E>) -> Result<(), E> {
        let Some(sheen) = &self.sheen else { return Ok(()) };
        let is_there = sheen.sheen_color_factor.max_element() > 0.0;
        material.parameters.set("fuzz_weight", if is_there { 1.0 } else { 0.0 });
        material.parameters.set("fuzz_color", sheen.sheen_color_factor);
        material.parameters.set("fuzz_roughness", sheen.sheen_roughness_factor.powi(2));
        map(material, "fuzz_color", &sheen.sheen_color_texture, Channel::R, ColorSpace::Srgb)?;
        map(material, "fuzz_roughness", &sheen.sheen_roughness_texture, Channel::A, ColorSpace::Linear)
    }

    /// Remarks on extensions that are left out.
    fn told(&self) -> Vec<String> {
        let has_normal = self.clearcoat.as_ref().is_some_and(|coat| coat.clearcoat_normal_texture.is_some());
        let has_direction = self.anisotropy.as_ref().is_some_and(|anisotropy| anisotropy.anisotropy_texture.is_some());
        let lost = [(has_normal, COAT_NORMALS), (has_direction, ANISOTROPY_MAPS)]
            .into_iter()
            .filter(|(is_there, _)| *is_there);
        lost.filter_map(|(_, feature)| feature.lost()).chain(self.wrong.iter().cloned()).collect()
    }
}

impl Transmission {
    /// Lowers the opacity by the transmitted share. Returns a remark.
    fn thin_out(&self, material: &mut Material) -> Option<String> {
        const OPACITY: &str = "geometry_opacity";
        const REFLECTED: f32 = 0.08;
        if !(self.transmission_factor > 0.0) {
            return None;
        }
        if self.transmission_texture.is_some() {
            return TRANSMISSION_MAPS.lost();
        }
        if material.parameters.number("opacity_cutoff") > 0.0 {
            return Some("are cut out and transmit light, which is left out".into());
        }
        // Both faces of a sheet of glass reflect some light: it stays visible and selectable.
        let stopped = (1.0 - self.transmission_factor).max(REFLECTED);
        material.parameters.set(OPACITY, material.parameters.number(OPACITY) * stopped);
        Some("transmit light, which passes straight on as through a thin sheet, without refraction or tint".into())
    }
}

/// The extension of a material, if it is present.
///
/// # Errors
/// A field of another kind.
pub(super) fn extension<T: DeserializeOwned>(material: &Value, name: &str) -> Option<Result<T, String>> {
    let value = &material["extensions"][name];
    (!value.is_null()).then(|| fields::contents(value))
}

/// The extension of a material, if it is present and readable; else a remark may be added.
fn read<T: DeserializeOwned>(material: &Value, name: &str, wrong: &mut Vec<String>) -> Option<T> {
    extension(material, name)?.map_err(|reason| wrong.push(left_out(name, &reason))).ok()
}

/// The remark on materials with an extension that cannot be read.
fn left_out(extension: &str, reason: &str) -> String {
    format!("have a {extension} that was left out, because {reason}; export them again")
}

impl Anisotropy {
    /// Sets roughness and stretch to the lobe widths of glTF. A rotation snaps to the tangent or across it, whichever
    /// is nearer. Returns a remark.
    ///
    /// For a roughness with a map, the lobe at its `mean` counts: glTF's stretch depends on the roughness of each
    /// texel, the stretch here does not.
    fn stretch(&self, material: &mut Material, mean: f32) -> Option<&'static str> {
        if !(self.anisotropy_strength > 0.0) {
            return None;
        }
        let is_layered = material.model == BrdfModel::OpenPbr;
        let [name, stretch_name] = if is_layered {
            ["specular_roughness", "specular_roughness_anisotropy"]
        } else {
            ["roughness", "anisotropy"]
        };
        let factor = material.parameters.number(name);
        let at_mean = (factor * mean).clamp(0.01, 1.0);
        let lobe = stretch::of_gltf(at_mean, self.anisotropy_strength);
        let from_tangent = (self.anisotropy_rotation.rem_euclid(2.0 * FRAC_PI_2) - FRAC_PI_2).abs();
        let is_across = from_tangent < FRAC_PI_4;
        let ([roughness, amount], told) = match (is_layered, is_across) {
            (false, _) => {
                let [roughness, squeeze] = stretch::to_burley(lobe);
                let amount = (squeeze / 0.9).min(1.0);
                ([roughness, if is_across { -amount } else { amount }], None)
            }
            (true, false) => (stretch::to_openpbr(lobe), None),
            (true, true) => {
                let [roughness, _] = stretch::to_burley(lobe);
                let text =
                    "have a highlight across the tangent below a coat or sheen, which cannot be shown; it is round";
                ([roughness, 0.0], Some(text))
            }
        };
        let wanted = if mean > 0.0 { factor.max(0.01) * roughness / at_mean } else { factor };
        material.parameters.set(name, wanted.min(1.0));
        material.parameters.set(stretch_name, amount);
        let narrower =
            "have a stretched highlight with a texture of roughness, whose factor ends at 1; it is narrower than meant";
        told.or((wanted > 1.0).then_some(narrower))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::brdf::{GgxParameters, widths};

    #[test]
    fn a_stretched_lobe_is_as_wide_as_gltf_says() {
        for (roughness, strength) in [(0.5_f32, 0.6_f32), (0.3, 0.2), (0.8, 1.0)] {
            let mut material = Material::default();
            material.parameters.set("roughness", roughness);
            let along = Anisotropy { anisotropy_strength: strength, anisotropy_rotation: 0.1, ..Default::default() };
            assert_eq!(along.stretch(&mut material, 1.0), None);
            let p = GgxParameters::from(&material.parameters);
            let alpha = roughness * roughness;
            let expected = [alpha + (1.0 - alpha) * strength * strength, alpha];
            let found = widths(p.roughness, p.anisotropy);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05 * b), "{found:?} {expected:?}");
            Anisotropy { anisotropy_rotation: FRAC_PI_2, ..along }.stretch(&mut material, 1.0);
            assert!(material.parameters.number("anisotropy") < 0.0, "across the tangent");
        }
    }
}
