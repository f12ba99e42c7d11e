//! Checks of the values of materials.

use super::{BrdfParameters, MapKind, Material};
use crate::texture::TextureSlot;
use thiserror::Error;

/// Largest parameter of a material and number of a texture's transform: their products stay numbers of 32 bits.
/// Parameters are clamped to their ranges after their maps, see [`BrdfParameters::sanitized`].
pub const MOST_MATERIAL_NUMBER: f32 = 1e6;

/// A number of a material that nothing can be computed with.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("its {what} {value} is no number from -{MOST_MATERIAL_NUMBER} to {MOST_MATERIAL_NUMBER}; correct it")]
pub struct MaterialProblem {
    /// Which number.
    pub what: String,
    /// What it is.
    pub value: f32,
}

impl Material {
    /// Checks that all numbers are finite, and none so large that products of them are not.
    ///
    /// # Errors
    /// The first number that is not.
    pub fn validate(&self) -> Result<(), MaterialProblem> {
        let slots = MapKind::all().filter_map(|kind| Some((kind, self.maps[kind].as_ref()?)));
        let of_slot = |(kind, slot): (MapKind, &TextureSlot)| {
            slot_numbers(slot).map(|(what, value)| (format!("{what} of the map {}", kind.key()), value))
        };
        let parameters = parameter_numbers(&self.parameters).map(|(what, value)| (what.to_owned(), value));
        match parameters.into_iter().chain(slots.flat_map(of_slot)).find(|(_, value)| !is_usable(*value)) {
            Some((what, value)) => Err(MaterialProblem { what, value }),
            None => Ok(()),
        }
    }
}

fn is_usable(value: f32) -> bool {
    value.abs() <= MOST_MATERIAL_NUMBER
}

fn parameter_numbers(p: &BrdfParameters) -> [(&'static str, f32); 8] {
    [
        ("base color", p.base_color.x),
        ("base color", p.base_color.y),
        ("base color", p.base_color.z),
        ("roughness", p.roughness),
        ("metalness", p.metalness),
        ("anisotropy", p.anisotropy),
        ("index of refraction", p.ior),
        ("specular weight", p.specular),
    ]
}

fn slot_numbers(slot: &TextureSlot) -> [(&'static str, f32); 6] {
    [
        ("scale", slot.scale.x),
        ("scale", slot.scale.y),
        ("offset", slot.offset.x),
        ("offset", slot.offset.y),
        ("rotation", slot.rotation),
        ("strength", slot.strength),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn every_number_is_checked_and_named() {
        let good = Material::default();
        assert_eq!(good.validate(), Ok(()));
        let most = BrdfParameters { base_color: Vec3::splat(MOST_MATERIAL_NUMBER), ..Default::default() };
        assert_eq!(Material { parameters: most, ..good.clone() }.validate(), Ok(()));
        let of = |parameters| Material { parameters, ..good.clone() }.validate().unwrap_err().to_string();
        let plain = BrdfParameters::default();
        assert!(of(BrdfParameters { ior: f32::INFINITY, ..plain }).starts_with("its index of refraction inf"));
        assert!(of(BrdfParameters { base_color: Vec3::new(0.0, 0.0, 2e6), ..plain }).contains("base color 2000000"));
        let slot = TextureSlot::default();
        assert_eq!(slot_numbers(&slot).len(), 6);
        for slot in [
            TextureSlot { scale: Vec2::new(1.0, f32::INFINITY), ..slot.clone() },
            TextureSlot { offset: Vec2::splat(f32::NAN), ..slot.clone() },
            TextureSlot { rotation: -2e6, ..slot.clone() },
            TextureSlot { strength: f32::NAN, ..slot },
        ] {
            let mut material = good.clone();
            material.maps[MapKind::Bump] = Some(slot);
            let problem = material.validate().unwrap_err().to_string();
            assert!(problem.contains("of the map bump"), "{problem}");
        }
    }
}
