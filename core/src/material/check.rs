//! Checks of the names and values of materials.

use super::{BUMP, Maps, Material, NORMAL};
use crate::{
    brdf::{BrdfFile, BrdfModel, ContentKind, Parameters},
    texture::TextureSlot,
};
use thiserror::Error;

/// Largest parameter of a material and number of a texture's transform, so that products stay within 32-bit floats. Parameters are
/// clamped to their ranges after their maps, see [`Parameter::sanitized`](crate::brdf::Parameter::sanitized).
pub const MOST_MATERIAL_NUMBER: f32 = 1e6;

/// A number of a material that is not finite or too large.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("its {what} {value} is not a number from -{MOST_MATERIAL_NUMBER} to {MOST_MATERIAL_NUMBER}; correct it")]
pub struct MaterialProblem {
    /// Name of the number.
    pub what: String,
    /// Its value.
    pub value: f32,
}

/// A name that no model has.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("unknown {what} `{name}`, expected one of {}", expected.join(", "))]
pub struct UnknownName {
    what: &'static str,
    name: String,
    expected: Vec<String>,
}

/// Checks that every parameter and map belongs to some model: materials keep those of earlier models.
///
/// # Errors
/// The first unknown name, with the names of `model`.
pub(super) fn check_names<T>(
    model: BrdfModel,
    file: Option<&BrdfFile>,
    parameters: &Parameters,
    maps: &Maps<T>,
) -> Result<(), UnknownName> {
    // Declared parameters are known only once the file is read.
    if file.is_some_and(|file| ContentKind::of(&file.path) == Some(ContentKind::Written)) {
        return Ok(());
    }
    let is_declared = |name: &str| BrdfModel::declared(name).is_some();
    let known = || model.parameters().iter().chain(model.stored_parameters()).map(|p| p.name);
    let quoted = |names: &mut dyn Iterator<Item = &'static str>| names.map(|name| format!("`{name}`")).collect();
    if let Some((name, _)) = parameters.iter().find(|(name, _)| !is_declared(name)) {
        return Err(UnknownName { what: "parameter", name: name.into(), expected: quoted(&mut known()) });
    }
    let is_map = |name: &str| is_declared(name) || [NORMAL, BUMP].contains(&name);
    if let Some((name, _)) = maps.iter().find(|(name, _)| !is_map(name)) {
        return Err(UnknownName { what: "map", name: name.into(), expected: quoted(&mut super::map_names(model)) });
    }
    Ok(())
}

impl Material {
    /// Checks that all numbers are finite and small enough for their products to be finite.
    ///
    /// # Errors
    /// The first number that fails.
    pub fn validate(&self) -> Result<(), MaterialProblem> {
        let parameters = self.parameters.iter().flat_map(|(name, value)| {
            let numbers = if BrdfModel::declared(name).is_some_and(|p| p.is_color()) { 3 } else { 1 };
            value.color().to_array().into_iter().take(numbers).map(move |number| (name.replace('_', " "), number))
        });
        let of_slot = |(name, slot): (&str, &TextureSlot)| {
            slot_numbers(slot).map(|(what, value)| (format!("{what} of the map {name}"), value))
        };
        match parameters.chain(self.maps.iter().flat_map(of_slot)).find(|(_, value)| !is_usable(*value)) {
            Some((what, value)) => Err(MaterialProblem { what, value }),
            None => Ok(()),
        }
    }
}

fn is_usable(value: f32) -> bool {
    value.abs() <= MOST_MATERIAL_NUMBER
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
        let with = |name, value: crate::brdf::Value| {
            let parameters = Parameters::default().with(name, value);
            Material { parameters, ..good.clone() }.validate()
        };
        assert_eq!(with("base_color", Vec3::splat(MOST_MATERIAL_NUMBER).into()), Ok(()));
        let of = |name, value| with(name, value).unwrap_err().to_string();
        assert!(of("ior", f32::INFINITY.into()).starts_with("its ior inf"));
        assert!(of("base_color", Vec3::new(0.0, 0.0, 2e6).into()).contains("base color 2000000"));
        let slot = TextureSlot::default();
        for slot in [
            TextureSlot { scale: Vec2::new(1.0, f32::INFINITY), ..slot.clone() },
            TextureSlot { offset: Vec2::splat(f32::NAN), ..slot.clone() },
            TextureSlot { rotation: -2e6, ..slot.clone() },
            TextureSlot { strength: f32::NAN, ..slot },
        ] {
            let mut material = good.clone();
            material.maps.set(BUMP, Some(slot));
            let problem = material.validate().unwrap_err().to_string();
            assert!(problem.contains("of the map bump"), "{problem}");
        }
    }
}
