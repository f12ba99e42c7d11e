//! Material presets.
//!
//! Metals have the measured indices of refraction and extinction at 650, 550 and 450 nm, as refractiveindex.info
//! publishes them; they are not fits. The other presets use the index of the bulk material and the albedo of common
//! samples: starting points, not measurements. Colors are linear.

use super::{BrdfModel, Material, MaterialMaps};
use crate::brdf::{GgxParameters, Metal, OpenPbrParameters, OrenNayarParameters, Parameters};
use glam::Vec3;
use std::sync::LazyLock;

/// A material preset.
#[derive(Clone, Debug)]
pub struct Preset {
    /// Display name.
    pub name: &'static str,
    /// Group in the list.
    pub group: &'static str,
    /// Where the values are from, or a description.
    pub source: &'static str,
    /// Reflectance model.
    pub model: BrdfModel,
    /// Parameter values.
    pub parameters: Parameters,
}

impl Preset {
    /// `material` with this preset's model and values. Name and sides stay; maps, colors of vertices and opacity stay unless
    /// maps are to be cleared.
    pub fn applied_to(&self, material: &Material, clear_maps: bool) -> Material {
        let mut changed = material.clone();
        // Maps follow quantities that this model names differently.
        changed.change_model(self.model);
        changed.parameters = self.parameters.clone();
        if clear_maps {
            changed.maps = MaterialMaps::default();
            changed.vertex_colors = false;
        } else {
            // A leaf stays cut out, and its bake stays valid.
            changed.take_opacity(material, |slot| Some(slot.clone()));
        }
        changed
    }

    /// The preset as a new material.
    pub fn material(&self) -> Material {
        self.applied_to(&Material { name: self.name.into(), ..Default::default() }, true)
    }
}

/// All presets, group by group.
pub static PRESETS: LazyLock<Vec<Preset>> = LazyLock::new(|| {
    [matte(), plastics(), ceramics(), wood_and_paper(), cloth(), paints(), metals()].into_iter().flatten().collect()
});

fn rgb(color: [f32; 3]) -> Vec3 {
    Vec3::from_array(color)
}

fn pbr(group: &'static str, name: &'static str, source: &'static str, parameters: OpenPbrParameters) -> Preset {
    Preset { name, group, source, model: BrdfModel::OpenPbr, parameters: parameters.into() }
}

/// OpenPBR defaults with a color, a roughness and an index of refraction.
fn dielectric(color: [f32; 3], roughness: f32, ior: f32) -> OpenPbrParameters {
    OpenPbrParameters { base_color: rgb(color), specular_roughness: roughness, specular_ior: ior, ..Default::default() }
}

fn matte() -> Vec<Preset> {
    const GROUP: &str = "Matte";
    let rough = |name, color, diffuse_roughness, source| {
        let parameters = OrenNayarParameters { base_color: rgb(color), diffuse_roughness };
        Preset { name, group: GROUP, source, model: BrdfModel::OrenNayar, parameters: parameters.into() }
    };
    vec![
        rough("Chalk", [0.85, 0.85, 0.82], 0.3, "A dry, powdery surface of albedo 0.85"),
        rough("White plaster", [0.80, 0.79, 0.77], 0.5, "Dry plaster of albedo 0.8"),
        rough("Clay", [0.45, 0.23, 0.15], 0.6, "Terracotta, unglazed"),
        rough("Moon dust", [0.13, 0.125, 0.12], 1.0, "Regolith of albedo 0.13: flat to the edge"),
        pbr(
            GROUP,
            "Concrete",
            "Fresh concrete of albedo 0.51",
            OpenPbrParameters { base_diffuse_roughness: 0.7, ..dielectric([0.51, 0.51, 0.50], 0.85, 1.5) },
        ),
    ]
}

fn plastics() -> Vec<Preset> {
    const GROUP: &str = "Plastic and rubber";
    vec![
        pbr(
            GROUP,
            "Matte plastic",
            "Polypropylene to ABS, index 1.46 to 1.54",
            dielectric([0.18, 0.32, 0.55], 0.55, 1.5),
        ),
        pbr(GROUP, "Glossy plastic", "Acrylic, index 1.49", dielectric([0.60, 0.06, 0.04], 0.18, 1.49)),
        pbr(
            GROUP,
            "Black plastic",
            "ABS of a grained casing, index 1.54",
            dielectric([0.015, 0.015, 0.016], 0.45, 1.54),
        ),
        pbr(GROUP, "Rubber", "Natural rubber, index 1.52", dielectric([0.03, 0.03, 0.03], 0.7, 1.52)),
        pbr(
            GROUP,
            "Silicone",
            "Soft and slightly dusty, index 1.43",
            OpenPbrParameters { fuzz_weight: 0.25, fuzz_roughness: 0.6, ..dielectric([0.55, 0.62, 0.60], 0.5, 1.43) },
        ),
    ]
}

fn ceramics() -> Vec<Preset> {
    const GROUP: &str = "Ceramic and stone";
    let glazed = |color, roughness, coat_roughness, coat_ior| OpenPbrParameters {
        coat_weight: 1.0,
        coat_roughness,
        coat_ior,
        ..dielectric(color, roughness, 1.5)
    };
    vec![
        pbr(
            GROUP,
            "Porcelain",
            "White body under a clear glaze, index 1.5",
            glazed([0.82, 0.81, 0.78], 0.4, 0.05, 1.5),
        ),
        pbr(
            GROUP,
            "Ceramic glaze",
            "Celadon: glaze of index 1.54 on gray clay",
            glazed([0.36, 0.48, 0.40], 0.6, 0.1, 1.54),
        ),
        pbr(GROUP, "Polished marble", "Calcite, index 1.6", dielectric([0.78, 0.76, 0.73], 0.12, 1.6)),
        pbr(
            GROUP,
            "Slate",
            "Split and dry, index 1.55",
            OpenPbrParameters { base_diffuse_roughness: 0.4, ..dielectric([0.055, 0.06, 0.065], 0.6, 1.55) },
        ),
    ]
}

fn wood_and_paper() -> Vec<Preset> {
    const GROUP: &str = "Wood, paper, leather";
    vec![
        pbr(
            GROUP,
            "Raw oak",
            "Planed and dry, index 1.53",
            OpenPbrParameters { base_diffuse_roughness: 0.4, ..dielectric([0.42, 0.28, 0.16], 0.75, 1.53) },
        ),
        pbr(
            GROUP,
            "Varnished walnut",
            "Polyurethane varnish of index 1.52, which darkens the wood",
            OpenPbrParameters {
                coat_weight: 1.0,
                coat_color: rgb([0.95, 0.86, 0.70]),
                coat_roughness: 0.12,
                coat_ior: 1.52,
                ..dielectric([0.22, 0.12, 0.065], 0.6, 1.53)
            },
        ),
        pbr(
            GROUP,
            "Paper",
            "Uncoated, of albedo 0.8",
            OpenPbrParameters {
                base_diffuse_roughness: 0.3,
                specular_weight: 0.4,
                ..dielectric([0.80, 0.79, 0.75], 0.9, 1.5)
            },
        ),
        pbr(GROUP, "Coated paper", "Magazine paper, index 1.5", dielectric([0.82, 0.82, 0.80], 0.35, 1.5)),
        pbr(
            GROUP,
            "Leather",
            "Dyed and waxed, index 1.5",
            OpenPbrParameters { base_diffuse_roughness: 0.5, ..dielectric([0.16, 0.065, 0.03], 0.48, 1.5) },
        ),
        pbr(
            GROUP,
            "Skin (surface only)",
            "Index 1.4; without scattering below the surface",
            OpenPbrParameters { fuzz_weight: 0.15, ..dielectric([0.55, 0.33, 0.24], 0.45, 1.4) },
        ),
    ]
}

fn cloth() -> Vec<Preset> {
    const GROUP: &str = "Cloth";
    let woven = |color, fuzz_weight, fuzz_color, fuzz_roughness| OpenPbrParameters {
        base_diffuse_roughness: 0.8,
        specular_weight: 0.3,
        fuzz_weight,
        fuzz_color: rgb(fuzz_color),
        fuzz_roughness,
        ..dielectric(color, 0.8, 1.5)
    };
    vec![
        pbr(GROUP, "Cotton", "Plain weave", woven([0.62, 0.58, 0.50], 0.4, [0.9, 0.88, 0.85], 0.7)),
        pbr(GROUP, "Denim", "Indigo over white", woven([0.035, 0.06, 0.14], 0.5, [0.35, 0.42, 0.6], 0.6)),
        pbr(GROUP, "Felt", "Pressed wool", woven([0.30, 0.04, 0.05], 0.8, [0.75, 0.30, 0.30], 0.8)),
        pbr(
            GROUP,
            "Velvet",
            "Dark pile that glows at the edges",
            woven([0.05, 0.004, 0.02], 1.0, [0.75, 0.15, 0.30], 0.35),
        ),
        pbr(
            GROUP,
            "Silk",
            "Satin weave, stretched along the warp",
            OpenPbrParameters {
                specular_color: rgb([1.0, 0.9, 0.75]),
                specular_roughness_anisotropy: 0.7,
                fuzz_weight: 0.2,
                fuzz_color: rgb([0.9, 0.75, 0.5]),
                ..dielectric([0.45, 0.28, 0.08], 0.42, 1.55)
            },
        ),
    ]
}

fn paints() -> Vec<Preset> {
    const GROUP: &str = "Paint and lacquer";
    let coated = |base: OpenPbrParameters, coat_roughness| OpenPbrParameters {
        coat_weight: 1.0,
        coat_roughness,
        coat_ior: 1.5,
        ..base
    };
    let flakes = |color, roughness| OpenPbrParameters { base_metalness: 0.8, ..dielectric(color, roughness, 1.5) };
    vec![
        pbr(
            GROUP,
            "Black lacquer",
            "Urushi and polyurethane, index about 1.55",
            OpenPbrParameters { coat_ior: 1.55, ..coated(dielectric([0.005, 0.005, 0.006], 0.3, 1.5), 0.05) },
        ),
        pbr(
            GROUP,
            "Solid red",
            "Solid red under a clear coat",
            coated(dielectric([0.42, 0.012, 0.01], 0.5, 1.5), 0.06),
        ),
        pbr(
            GROUP,
            "Metallic blue",
            "Aluminum flakes in blue under a clear coat",
            coated(flakes([0.02, 0.07, 0.35], 0.42), 0.05),
        ),
        pbr(
            GROUP,
            "Metallic silver",
            "Aluminum flakes under a clear coat",
            coated(flakes([0.55, 0.56, 0.57], 0.40), 0.05),
        ),
        pbr(
            GROUP,
            "Wall paint",
            "Matte emulsion",
            OpenPbrParameters { base_diffuse_roughness: 0.4, ..dielectric([0.72, 0.70, 0.64], 0.8, 1.45) },
        ),
    ]
}

fn metals() -> Vec<Preset> {
    const GROUP: &str = "Metal";
    let metal = |name, source, n: [f32; 3], k: [f32; 3], roughness, anisotropy| {
        let (base_color, edge_color) = Metal::artistic(rgb(n), rgb(k));
        let parameters =
            GgxParameters { base_color, edge_color, metalness: 1.0, roughness, anisotropy, ..Default::default() };
        Preset { name, group: GROUP, source, model: BrdfModel::Ggx, parameters: parameters.into() }
    };
    let aluminum = ([1.346, 0.965, 0.617], [7.475, 6.400, 5.303]);
    let iron = ([2.911, 2.950, 2.585], [3.089, 2.932, 2.767]);
    vec![
        metal("Gold", "Measured indices", [0.143, 0.375, 1.442], [3.983, 2.386, 1.603], 0.2, 0.0),
        metal("Silver", "Measured indices", [0.155, 0.117, 0.138], [4.828, 3.122, 2.147], 0.15, 0.0),
        metal("Copper", "Measured indices", [0.200, 0.924, 1.102], [3.913, 2.453, 2.142], 0.25, 0.0),
        metal("Satin brass", "Measured indices of 70 % copper", [0.444, 0.527, 1.094], [3.695, 2.765, 1.829], 0.4, 0.0),
        metal("Polished aluminum", "Measured indices", aluminum.0, aluminum.1, 0.1, 0.0),
        metal("Brushed aluminum", "Measured indices, stretched along the tangent", aluminum.0, aluminum.1, 0.35, 0.8),
        metal("Chrome", "Measured indices", [4.370, 2.917, 1.655], [5.206, 4.231, 3.755], 0.06, 0.0),
        metal("Iron", "Measured indices, cast", iron.0, iron.1, 0.45, 0.0),
        metal("Brushed steel", "Indices of iron, stretched along the tangent", iron.0, iron.1, 0.32, 0.85),
        metal("Titanium", "Measured indices", [2.741, 2.542, 2.267], [3.814, 3.435, 3.039], 0.3, 0.0),
        metal("Tungsten", "Measured indices", [4.371, 3.300, 2.998], [3.501, 2.605, 2.273], 0.35, 0.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{material::BUMP, texture::TextureSlot};
    use std::collections::HashSet;

    #[test]
    fn presets_are_in_range_and_have_names_of_their_own() {
        for preset in PRESETS.iter() {
            assert_eq!(preset.parameters, preset.parameters.clone().sanitized(), "{}", preset.name);
            let albedo = preset.material().plain_brdf().as_brdf().albedo();
            assert!(albedo.max_element() > 0.02 && albedo.max_element() <= 1.0, "{}: {albedo}", preset.name);
            assert!(
                preset.parameters.iter().all(|(name, _)| preset.model.parameter(name).is_some()),
                "{}",
                preset.name
            );
        }
        let names: HashSet<&str> = PRESETS.iter().map(|p| p.name).collect();
        assert_eq!(names.len(), PRESETS.len());
        assert!(names.len() >= 32, "{}", names.len());
    }

    #[test]
    fn metals_have_their_measured_reflectance() {
        let albedo = |name: &str| {
            let preset = PRESETS.iter().find(|p| p.name == name).unwrap();
            preset.parameters.color("base_color")
        };
        // ((n - 1)² + k²) / ((n + 1)² + k²).
        assert!((albedo("Gold") - Vec3::new(0.966, 0.797, 0.32)).length() < 0.02, "{}", albedo("Gold"));
        assert!((albedo("Silver") - Vec3::new(0.974, 0.958, 0.905)).length() < 0.02, "{}", albedo("Silver"));
        assert!((albedo("Copper") - albedo("Gold")).length() > 0.1, "negative control");
    }

    #[test]
    fn a_preset_keeps_name_and_maps_unless_told_to_clear_them() {
        let maps = MaterialMaps::from([(BUMP, TextureSlot::default())]);
        let material = Material { name: "Knob".into(), maps, double_sided: true, ..Default::default() };
        let gold = PRESETS.iter().find(|p| p.name == "Gold").unwrap();
        let kept = gold.applied_to(&material, false);
        assert_eq!((kept.name.as_str(), kept.double_sided, &kept.maps), ("Knob", true, &material.maps));
        assert_eq!(kept.parameters.number("metalness"), 1.0);
        assert_eq!(gold.applied_to(&material, true).maps, MaterialMaps::default());
        let rough =
            Material { maps: MaterialMaps::from([("roughness", TextureSlot::default())]), ..Default::default() };
        let leather = PRESETS.iter().find(|p| p.name == "Leather").unwrap();
        assert!(
            leather.applied_to(&rough, false).maps.get("specular_roughness").is_some(),
            "the map of the same quantity"
        );
    }
}
