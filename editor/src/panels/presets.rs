//! Materials to start from. Values are physically plausible; colours are linear.
//!
//! Metals: reflectance at normal incidence close to what is commonly published for them. Dielectrics: index of refraction
//! of the bulk material, albedo of common samples. They are starting points, not measurements.

use glam::Vec3;
use lapidary_core::brdf::GgxParameters;
use lapidary_core::material::{BrdfModel, Material, MaterialMaps};

/// A material to start from.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Name for people.
    pub name: &'static str,
    /// Where the values are from.
    pub source: &'static str,
    /// Reflectance model.
    pub model: BrdfModel,
    /// Its values.
    pub parameters: GgxParameters,
}

impl Preset {
    /// `material` with this preset's model and values; name and sides stay, and the maps unless they are to be cleared.
    pub fn applied_to(&self, material: &Material, clear_maps: bool) -> Material {
        Material {
            model: self.model,
            parameters: self.parameters.into(),
            maps: if clear_maps { MaterialMaps::default() } else { material.maps.clone() },
            ..material.clone()
        }
    }
}

/// All presets, dull to shiny, then metals.
pub const PRESETS: [Preset; 18] = [
    lambert("Chalk", [0.85, 0.85, 0.82]),
    lambert("White plaster", [0.80, 0.79, 0.77]),
    dielectric("Clay", [0.45, 0.23, 0.15], 0.85, 1.5, "Terracotta; unglazed, so rough"),
    dielectric("Concrete", [0.51, 0.51, 0.51], 0.9, 1.5, "Albedo of fresh concrete, 0.51"),
    dielectric("Rubber", [0.03, 0.03, 0.03], 0.7, 1.52, "Natural rubber, index 1.52"),
    dielectric("Skin (surface only)", [0.55, 0.33, 0.24], 0.45, 1.4, "Index 1.4; without scattering below the surface"),
    dielectric("Matte plastic", [0.18, 0.32, 0.55], 0.55, 1.46, "Polypropylene to ABS, index 1.46 to 1.54"),
    dielectric("Glossy plastic", [0.60, 0.06, 0.04], 0.18, 1.49, "Acrylic, index 1.49"),
    dielectric("Ceramic glaze", [0.72, 0.74, 0.70], 0.08, 1.54, "Fired glaze, index 1.5 to 1.6"),
    dielectric("Black lacquer", [0.005, 0.005, 0.006], 0.05, 1.55, "Urushi and polyurethane, index about 1.55"),
    dielectric("Car paint red", [0.42, 0.012, 0.01], 0.12, 1.5, "Solid red under a clear coat, index 1.5"),
    metal("Gold", [1.0, 0.766, 0.336], 0.2, 0.0),
    metal("Silver", [0.972, 0.960, 0.915], 0.15, 0.0),
    metal("Copper", [0.955, 0.637, 0.538], 0.25, 0.0),
    metal("Brushed aluminum", [0.913, 0.921, 0.925], 0.35, 0.8),
    metal("Iron", [0.560, 0.570, 0.580], 0.45, 0.0),
    metal("Satin brass", [0.910, 0.778, 0.423], 0.4, 0.0),
    metal("Chrome", [0.550, 0.556, 0.554], 0.05, 0.0),
];

const BASE: GgxParameters = GgxParameters {
    base_color: Vec3::ONE,
    roughness: 0.5,
    metalness: 0.0,
    anisotropy: 0.0,
    ior: 1.5,
    specular: 1.0,
    edge_color: Vec3::splat(0.9),
};

const fn lambert(name: &'static str, color: [f32; 3]) -> Preset {
    let parameters = GgxParameters { base_color: Vec3::from_array(color), ..BASE };
    Preset { name, source: "Albedo of a dry, powdery surface", model: BrdfModel::Lambert, parameters }
}

const fn dielectric(name: &'static str, color: [f32; 3], roughness: f32, ior: f32, source: &'static str) -> Preset {
    let parameters = GgxParameters { base_color: Vec3::from_array(color), roughness, ior, ..BASE };
    Preset { name, source, model: BrdfModel::Ggx, parameters }
}

const fn metal(name: &'static str, reflectance: [f32; 3], roughness: f32, anisotropy: f32) -> Preset {
    let base_color = Vec3::from_array(reflectance);
    let parameters = GgxParameters { base_color, roughness, metalness: 1.0, anisotropy, ..BASE };
    Preset { name, source: "Reflectance at normal incidence, as commonly published", model: BrdfModel::Ggx, parameters }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::brdf::Parameters;
    use lapidary_core::texture::TextureSlot;
    use std::collections::HashSet;

    #[test]
    fn presets_are_in_range_and_have_names_of_their_own() {
        for preset in &PRESETS {
            let parameters = Parameters::from(preset.parameters);
            assert_eq!(parameters, parameters.clone().sanitized(), "{}", preset.name);
            assert!(preset.parameters.base_color.max_element() > 0.0);
        }
        let names: HashSet<&str> = PRESETS.iter().map(|p| p.name).collect();
        assert_eq!(names.len(), PRESETS.len());
    }

    #[test]
    fn a_preset_keeps_name_and_maps_unless_told_to_clear_them() {
        let maps = MaterialMaps::from([("bump", TextureSlot::default())]);
        let material = Material { name: "Knob".into(), maps, double_sided: true, ..Default::default() };
        let gold = PRESETS.iter().find(|p| p.name == "Gold").unwrap();
        let kept = gold.applied_to(&material, false);
        assert_eq!((kept.name.as_str(), kept.double_sided, &kept.maps), ("Knob", true, &material.maps));
        assert_eq!(kept.parameters.number("metalness"), 1.0);
        assert_eq!(gold.applied_to(&material, true).maps, MaterialMaps::default());
    }
}
