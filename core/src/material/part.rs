//! Optional parts of materials. Shaders omit a part that no material has. The CPU skips it by a branch that is the same
//! for all directions of a pixel.

use crate::material::Material;

/// A part that a material has where a parameter is above zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialPart {
    /// Fresnel factors of conductors.
    Metal,
    /// A clear layer on top.
    Coat,
    /// Fibers on top.
    Fuzz,
    /// Emitted light.
    Emission,
}

impl MaterialPart {
    /// All parts.
    pub const ALL: [Self; 4] = [Self::Metal, Self::Coat, Self::Fuzz, Self::Emission];

    /// The shader constant that says whether any material has the part.
    pub const fn constant(self) -> &'static str {
        match self {
            Self::Metal => "HAS_METAL",
            Self::Coat => "HAS_COAT",
            Self::Fuzz => "HAS_FUZZ",
            Self::Emission => "HAS_EMISSION",
        }
    }

    /// The quantity whose parameter turns the part on.
    const fn quantity(self) -> &'static str {
        match self {
            Self::Metal => "metalness",
            Self::Coat => "coat_weight",
            Self::Fuzz => "fuzz_weight",
            Self::Emission => "emission_luminance",
        }
    }

    /// Whether a material has the part anywhere: a map may remove it, but never adds it.
    pub fn is_in(self, material: &Material) -> bool {
        let brings = material.parameter_for(self.quantity());
        brings.is_some_and(|parameter| material.parameters.value(parameter).number() > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{BrdfModel, Parameter};

    fn models_with(part: MaterialPart) -> Vec<BrdfModel> {
        let has = |model: &BrdfModel| model.parameter_for(part.quantity()).is_some();
        BrdfModel::ALL.iter().copied().filter(has).collect()
    }

    #[test]
    fn parts_are_there_where_their_parameter_is_above_zero() {
        assert!(MaterialPart::ALL.iter().all(|&part| !models_with(part).is_empty()));
        for part in MaterialPart::ALL {
            for model in models_with(part) {
                let parameter: &Parameter = model.parameter_for(part.quantity()).expect("those that have it");
                let with = |value: f32| {
                    let mut material = Material { model, ..Material::default() };
                    material.parameters.set(parameter.name, value);
                    material
                };
                assert!(part.is_in(&with(0.01)) && !part.is_in(&with(0.0)), "{part:?} of {model:?}");
            }
        }
        let plain = Material { model: BrdfModel::Lambert, ..Material::default() };
        assert!(!MaterialPart::Metal.is_in(&plain), "a model without");
    }
}
