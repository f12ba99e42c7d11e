//! Parts of materials that only some have, which shaders leave out where no material has them. The CPU passes each by with a branch
//! that is the same for all directions of a pixel.

use crate::material::Material;

/// A part, brought by a parameter that is above zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialPart {
    /// Fresnel factors of conductors.
    Metal,
    /// A clear layer over all.
    Coat,
    /// Fibers over all.
    Fuzz,
    /// Light of their own.
    Emission,
}

impl MaterialPart {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Metal, Self::Coat, Self::Fuzz, Self::Emission];

    /// The constant that tells shaders whether any material has it.
    pub const fn constant(self) -> &'static str {
        match self {
            Self::Metal => "HAS_METAL",
            Self::Coat => "HAS_COAT",
            Self::Fuzz => "HAS_FUZZ",
            Self::Emission => "HAS_EMISSION",
        }
    }

    /// The quantity of the parameter that brings it.
    const fn quantity(self) -> &'static str {
        match self {
            Self::Metal => "metalness",
            Self::Coat => "coat_weight",
            Self::Fuzz => "fuzz_weight",
            Self::Emission => "emission_luminance",
        }
    }

    /// Whether a material has it somewhere: a map may take it away, and never brings it.
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
