//! Materials: a BRDF model, its eight parameters, and the textures that modulate them.
//!
//! The paper (4.2) allows a BRDF up to eight floating-point parameters per pixel, all modulated by textures. All models
//! here read the same eight, so that an artist can change the model and keep the look.

mod check;
mod maps;

pub use check::{MOST_MATERIAL_NUMBER, MaterialProblem};
pub use maps::{MapKind, Maps, MaterialMaps};

use crate::texture::TextureSlot;
use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// Which reflectance model a material uses; `brdf` has one file for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BrdfModel {
    /// Ideal diffuse reflection; reads the base colour only.
    Lambert,
    /// GGX microfacets with Fresnel over a diffuse base, metal or dielectric.
    #[default]
    Ggx,
    /// Ward's lobe over a diffuse base, isotropic or anisotropic.
    Ward,
}

/// The eight parameters of a BRDF (three of them a colour).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BrdfParameters {
    /// Diffuse albedo of a dielectric, normal-incidence reflectance of a metal; linear, 0 to 1.
    pub base_color: Vec3,
    /// Perceptual roughness, 0 to 1; the microfacet width is `alpha = roughness²`.
    pub roughness: f32,
    /// 0 for a dielectric, 1 for a metal.
    pub metalness: f32,
    /// -1 to 1: how far the highlight is stretched along the tangent (positive) or across it.
    pub anisotropy: f32,
    /// Index of refraction of a dielectric, at least 1.
    pub ior: f32,
    /// Weight of a dielectric's specular lobe, 0 to 1.
    pub specular: f32,
}

impl Default for BrdfParameters {
    fn default() -> Self {
        Self { base_color: Vec3::splat(0.8), roughness: 0.5, metalness: 0.0, anisotropy: 0.0, ior: 1.5, specular: 1.0 }
    }
}

impl BrdfParameters {
    /// Clamps every parameter into its range; NaN becomes the default.
    #[inline]
    pub fn sanitized(self) -> Self {
        let fallback = Self::default();
        let clamp = |x: f32, low: f32, high: f32, default: f32| if x.is_nan() { default } else { x.clamp(low, high) };
        let color = self.base_color;
        let component = |x: f32, d: f32| clamp(x, 0.0, 1.0, d);
        Self {
            base_color: Vec3::new(
                component(color.x, fallback.base_color.x),
                component(color.y, fallback.base_color.y),
                component(color.z, fallback.base_color.z),
            ),
            roughness: clamp(self.roughness, 0.0, 1.0, fallback.roughness),
            metalness: clamp(self.metalness, 0.0, 1.0, fallback.metalness),
            anisotropy: clamp(self.anisotropy, -1.0, 1.0, fallback.anisotropy),
            ior: clamp(self.ior, 1.0, 10.0, fallback.ior),
            specular: clamp(self.specular, 0.0, 1.0, fallback.specular),
        }
    }
}

/// A material of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Name from the source file.
    pub name: String,
    /// Reflectance model.
    pub model: BrdfModel,
    /// Values that the maps multiply.
    pub parameters: BrdfParameters,
    /// Textures.
    pub maps: MaterialMaps,
    /// Both sides reflect: the surface is lit and seen from behind as well.
    pub double_sided: bool,
}

impl Material {
    /// With parameters and placements of maps in their ranges; see [`BrdfParameters::sanitized`] and
    /// [`TextureSlot::sanitized`].
    pub fn sanitized(mut self) -> Self {
        self.parameters = self.parameters.sanitized();
        for slot in self.maps.slots_mut() {
            *slot = std::mem::take(slot).sanitized();
        }
        self
    }

    /// The parameters after their maps, whose texels `sample` looks up; not yet clamped. Twin of
    /// `shaders/parameters_pass.wgsl`.
    pub fn modulated(&self, sample: impl Fn(&TextureSlot) -> Vec4) -> BrdfParameters {
        let (maps, p) = (&self.maps, self.parameters);
        let scalar = |kind| maps[kind].as_ref().map_or(1.0, |s| sample(s)[s.channel as usize]);
        BrdfParameters {
            base_color: p.base_color * maps[MapKind::BaseColor].as_ref().map_or(Vec3::ONE, |s| sample(s).truncate()),
            roughness: p.roughness * scalar(MapKind::Roughness),
            metalness: p.metalness * scalar(MapKind::Metalness),
            anisotropy: p.anisotropy * scalar(MapKind::Anisotropy),
            ior: maps[MapKind::Ior].as_ref().map_or(p.ior, |_| 1.0 + (p.ior - 1.0) * scalar(MapKind::Ior)),
            specular: p.specular * scalar(MapKind::Specular),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Channel;
    use serde_json::Value;

    #[test]
    fn sanitizing_clamps_and_replaces_nan() {
        let bad = BrdfParameters { roughness: 7.0, ior: 0.2, metalness: f32::NAN, ..Default::default() };
        let good = bad.sanitized();
        assert_eq!((good.roughness, good.ior, good.metalness), (1.0, 1.0, 0.0));
    }

    #[test]
    fn a_partial_json_material_takes_defaults_and_a_misspelt_key_is_an_error() {
        let m: Material = serde_json::from_str(r#"{"model": "ward", "parameters": {"roughness": 0.3}}"#).unwrap();
        assert_eq!(m.model, BrdfModel::Ward);
        assert_eq!(m.parameters.ior, 1.5);
        assert!(serde_json::from_str::<Material>(r#"{"parameters": {"rougness": 0.3}}"#).is_err());
    }

    #[test]
    fn every_parameter_has_a_map() {
        let keys = |value: Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
        let maps = keys(serde_json::to_value(MaterialMaps::default()).unwrap());
        let parameters = keys(serde_json::to_value(BrdfParameters::default()).unwrap());
        assert_eq!(parameters.len(), 6);
        assert!(parameters.iter().all(|p| maps.contains(p)), "{parameters:?}, {maps:?}");
        let slots = r#"{"texture": 1}"#;
        let all: String = maps.iter().map(|key| format!("\"{key}\": {slots},")).collect();
        let mut all: MaterialMaps = serde_json::from_str(&format!("{{{}}}", all.trim_end_matches(','))).unwrap();
        assert_eq!((all.slots().count(), all.slots_mut().count()), (maps.len(), maps.len()));
    }

    #[test]
    fn maps_scale_what_they_modulate_and_nothing_else() {
        let parameters = BrdfParameters {
            base_color: Vec3::new(0.8, 0.4, 0.2),
            roughness: 0.6,
            metalness: 0.9,
            anisotropy: -0.8,
            ior: 2.0,
            specular: 0.5,
        };
        let plain = Material { parameters, ..Default::default() };
        let texel = Vec4::new(0.5, 0.25, -1.0, 0.0);
        let with = |kind, channel| {
            let mut material = plain.clone();
            material.maps[kind] = Some(TextureSlot { channel, ..Default::default() });
            material.modulated(|_| texel)
        };
        let expect = |p: BrdfParameters, expected: BrdfParameters| assert_eq!(p, expected);
        expect(plain.modulated(|_| texel), parameters);
        let base_color = Vec3::new(0.4, 0.1, -0.2);
        expect(with(MapKind::BaseColor, Channel::R), BrdfParameters { base_color, ..parameters });
        expect(with(MapKind::Roughness, Channel::R), BrdfParameters { roughness: 0.3, ..parameters });
        expect(with(MapKind::Metalness, Channel::A), BrdfParameters { metalness: 0.0, ..parameters });
        expect(with(MapKind::Specular, Channel::G), BrdfParameters { specular: 0.125, ..parameters });
        expect(with(MapKind::Anisotropy, Channel::G), BrdfParameters { anisotropy: -0.2, ..parameters });
        expect(with(MapKind::Anisotropy, Channel::B), BrdfParameters { anisotropy: 0.8, ..parameters });
        for (channel, ior) in [(Channel::R, 1.5), (Channel::G, 1.25), (Channel::A, 1.0)] {
            expect(with(MapKind::Ior, channel), BrdfParameters { ior, ..parameters });
        }
        assert_eq!(with(MapKind::Ior, Channel::B).sanitized().ior, 1.0);
    }
}
