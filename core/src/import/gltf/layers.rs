//! Coat, sheen and anisotropy of glTF materials (`KHR_materials_clearcoat`, `_sheen`, `_anisotropy`), read from the JSON
//! itself: the `gltf` crate does not offer them.
//!
//! A material with a coat or sheen becomes OpenPBR. Its coat does not darken the base, as glTF's does not. Sheen is the same
//! lobe here, of the square of glTF's roughness.

use super::materials::Transform;
use crate::{
    brdf::{BrdfModel, GgxParameters},
    material::Material,
    texture::{Channel, ColorSpace, TextureSlot},
};
use glam::Vec3;
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// The extensions that are read here.
pub(super) const EXTENSIONS: [&str; 3] = [CLEARCOAT, SHEEN, ANISOTROPY];
const CLEARCOAT: &str = "KHR_materials_clearcoat";
const SHEEN: &str = "KHR_materials_sheen";
const ANISOTROPY: &str = "KHR_materials_anisotropy";

/// A texture and how it lies.
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
    /// Its `KHR_texture_transform`, if any.
    pub fn transform(&self) -> Transform {
        serde_json::from_value(self.extensions["KHR_texture_transform"].clone()).unwrap_or_default()
    }
}

#[derive(Clone, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Clearcoat {
    clearcoat_factor: f32,
    clearcoat_texture: Option<TextureInfo>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<TextureInfo>,
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
}

/// What the extensions of a material say.
#[derive(Clone, Default)]
pub(super) struct Layers {
    clearcoat: Option<Clearcoat>,
    sheen: Option<Sheen>,
    anisotropy: Option<Anisotropy>,
}

impl Layers {
    /// Of each material of a document.
    pub fn of_all(document: &Value) -> Vec<Self> {
        let of = |material: &Value| Self {
            clearcoat: extension(material, CLEARCOAT),
            sheen: extension(material, SHEEN),
            anisotropy: extension(material, ANISOTROPY),
        };
        document["materials"].as_array().map_or_else(Vec::new, |materials| materials.iter().map(of).collect())
    }

    /// Gives them to a GGX material; `slot` makes the slot of a texture.
    ///
    /// # Errors
    /// Those of `slot`.
    pub fn add_to<E>(
        &self,
        material: &mut Material,
        mut slot: impl FnMut(&TextureInfo) -> Result<TextureSlot, E>,
    ) -> Result<(), E> {
        if let Some(anisotropy) = &self.anisotropy {
            anisotropy.stretch(material);
        }
        if self.clearcoat.is_none() && self.sheen.is_none() {
            return Ok(());
        }
        material.change_model(BrdfModel::OpenPbr);
        let mut map =
            |material: &mut Material, name: &'static str, info: &Option<TextureInfo>, channel, color_space| {
                let made = info.as_ref().map(&mut slot).transpose()?;
                material.maps.set(name, made.map(|slot| TextureSlot { channel, color_space, ..slot }));
                Ok(())
            };
        if let Some(coat) = &self.clearcoat {
            material.parameters.set("coat_weight", coat.clearcoat_factor);
            material.parameters.set("coat_roughness", coat.clearcoat_roughness_factor);
            material.parameters.set("coat_ior", 1.5);
            material.parameters.set("coat_darkening", 0.0);
            map(material, "coat_weight", &coat.clearcoat_texture, Channel::R, ColorSpace::Linear)?;
            map(material, "coat_roughness", &coat.clearcoat_roughness_texture, Channel::G, ColorSpace::Linear)?;
        }
        if let Some(sheen) = &self.sheen {
            let is_there = sheen.sheen_color_factor.max_element() > 0.0;
            material.parameters.set("fuzz_weight", if is_there { 1.0 } else { 0.0 });
            material.parameters.set("fuzz_color", sheen.sheen_color_factor);
            material.parameters.set("fuzz_roughness", sheen.sheen_roughness_factor.powi(2));
            map(material, "fuzz_color", &sheen.sheen_color_texture, Channel::R, ColorSpace::Srgb)?;
            map(material, "fuzz_roughness", &sheen.sheen_roughness_texture, Channel::A, ColorSpace::Linear)?;
        }
        Ok(())
    }
}

/// The extension of a material, if it is there and can be read.
fn extension<T: DeserializeOwned>(material: &Value, name: &str) -> Option<T> {
    let value = &material["extensions"][name];
    (!value.is_null()).then(|| serde_json::from_value(value.clone()).ok()).flatten()
}

impl Anisotropy {
    /// The roughness and stretch whose lobe is as wide as `mix(roughness², 1, strength²)` along the highlight and
    /// `roughness²` across it. A turn is along the tangent or across it, whichever is nearer.
    fn stretch(&self, material: &mut Material) {
        let p = GgxParameters::from(&material.parameters);
        let across = p.roughness.powi(2).max(1e-4);
        let along = across + (1.0 - across) * self.anisotropy_strength.clamp(0.0, 1.0).powi(2);
        let amount = ((1.0 - across / along) / 0.9).min(1.0);
        let from_tangent = (self.anisotropy_rotation.rem_euclid(2.0 * FRAC_PI_2) - FRAC_PI_2).abs();
        let sign = if from_tangent < FRAC_PI_4 { -1.0 } else { 1.0 };
        material.parameters.set("roughness", (across * along).sqrt().sqrt());
        material.parameters.set("anisotropy", sign * amount);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::widths;

    #[test]
    fn a_stretched_lobe_is_as_wide_as_gltf_says() {
        for (roughness, strength) in [(0.5_f32, 0.6_f32), (0.3, 0.2), (0.8, 1.0)] {
            let mut material = Material::default();
            material.parameters.set("roughness", roughness);
            Anisotropy { anisotropy_strength: strength, anisotropy_rotation: 0.1 }.stretch(&mut material);
            let p = GgxParameters::from(&material.parameters);
            let alpha = roughness * roughness;
            let expected = [alpha + (1.0 - alpha) * strength * strength, alpha];
            let found = widths(p.roughness, p.anisotropy);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05 * b), "{found:?} {expected:?}");
            Anisotropy { anisotropy_strength: strength, anisotropy_rotation: FRAC_PI_2 }.stretch(&mut material);
            assert!(material.parameters.number("anisotropy") < 0.0, "across the tangent");
        }
    }
}
