//! Materials of diffuse and specular color and glossiness (`KHR_materials_pbrSpecularGlossiness`), converted to metallic-roughness
//! by Khronos' formula: the examples `convert-between-workflows` of the extension's specification.

use super::layers::{TextureInfo, extension};
use glam::Vec3;
use serde::Deserialize;
use serde_json::{Map, Value, json};

pub(super) const EXTENSION: &str = "KHR_materials_pbrSpecularGlossiness";

/// Reflectance of a dielectric toward the normal.
const DIELECTRIC: f32 = 0.04;

/// Guards divisions, as in Khronos' example.
const EPSILON: f32 = 1e-6;

/// The extension of a material.
#[derive(Clone, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Glossiness {
    diffuse_factor: [f32; 4],
    specular_factor: Vec3,
    glossiness_factor: f32,
    specular_glossiness_texture: Option<TextureInfo>,
}

impl Default for Glossiness {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            specular_factor: Vec3::ONE,
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

/// Base color and metalness of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Metallic {
    pub base_color: Vec3,
    pub metalness: f32,
    pub roughness: f32,
}

impl Glossiness {
    /// The extension of each material.
    pub fn of_all(document: &Value) -> Vec<Option<Self>> {
        let of = |material: &Value| extension(material, EXTENSION).and_then(Result::ok);
        document["materials"].as_array().map_or_else(Vec::new, |materials| materials.iter().map(of).collect())
    }

    /// The map of specular color and glossiness.
    pub fn texture(&self) -> Option<&TextureInfo> {
        self.specular_glossiness_texture.as_ref()
    }

    /// The surface for the means of the maps: of diffuse color, and of specular color and glossiness. Maps that are missing are 1.
    pub fn metallic(&self, diffuse: Vec3, specular: Vec3, glossiness: f32) -> Metallic {
        let [r, g, b, _] = self.diffuse_factor;
        let roughness = 1.0 - (self.glossiness_factor * glossiness).clamp(0.0, 1.0);
        let (base_color, metalness) = metallic(Vec3::new(r, g, b) * diffuse, self.specular_factor * specular);
        Metallic { base_color, metalness, roughness }
    }
}

/// Base color and metalness for a diffuse and a specular color.
fn metallic(diffuse: Vec3, specular: Vec3) -> (Vec3, f32) {
    let left = 1.0 - specular.max_element();
    let metalness = metalness(brightness(diffuse), brightness(specular), left);
    let of_diffuse = diffuse * (left / (1.0 - DIELECTRIC) / (1.0 - metalness).max(EPSILON));
    let of_specular = (specular - Vec3::splat(DIELECTRIC * (1.0 - metalness))) / metalness.max(EPSILON);
    let base_color = of_diffuse.lerp(of_specular, metalness * metalness);
    (base_color.clamp(Vec3::ZERO, Vec3::ONE), metalness)
}

/// Solves for the metalness at which a metallic-roughness material has this diffuse and specular brightness.
fn metalness(diffuse: f32, specular: f32, left: f32) -> f32 {
    if !(specular >= DIELECTRIC) {
        return 0.0;
    }
    let (a, b) = (DIELECTRIC, diffuse * left / (1.0 - DIELECTRIC) + specular - 2.0 * DIELECTRIC);
    let discriminant = (b * b - 4.0 * a * (DIELECTRIC - specular)).max(0.0);
    ((discriminant.sqrt() - b) / (2.0 * a)).clamp(0.0, 1.0)
}

fn brightness(color: Vec3) -> f32 {
    (color * color).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt()
}

/// Writes the diffuse color and map of such materials as those of a dielectric, for everything that reads these.
/// [`Glossiness::metallic`] then gives the numbers. Returns whether there are such materials.
pub(super) fn convert(document: &mut Value) -> bool {
    let mut is_changed = false;
    let materials = document.get_mut("materials").and_then(Value::as_array_mut);
    for material in materials.into_iter().flatten().filter_map(Value::as_object_mut) {
        if has_better_fallback(material) {
            material["extensions"].as_object_mut().map(|extensions| extensions.remove(EXTENSION));
            is_changed = true;
        }
        let Some(gloss) = material.get("extensions").and_then(|extensions| extensions.get(EXTENSION)) else { continue };
        let glossiness = gloss["glossinessFactor"].as_f64().unwrap_or(1.0).clamp(0.0, 1.0);
        let mut plain = json!({ "metallicFactor": 0, "roughnessFactor": 1.0 - glossiness });
        for (from, to) in [("diffuseFactor", "baseColorFactor"), ("diffuseTexture", "baseColorTexture")] {
            if let Some(value) = gloss.get(from) {
                plain[to] = value.clone();
            }
        }
        material.insert("pbrMetallicRoughness".into(), plain);
        is_changed = true;
    }
    is_changed
}

/// Whether the plain material has maps of metalness and roughness where the extension's map would count by its mean.
fn has_better_fallback(material: &Map<String, Value>) -> bool {
    let extension = material.get("extensions").map(|extensions| &extensions[EXTENSION]);
    let has_map = extension.is_some_and(|extension| extension["specularGlossinessTexture"].is_object());
    has_map && material.get("pbrMetallicRoughness").is_some_and(|plain| plain["metallicRoughnessTexture"].is_object())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_of_the_plain_material_count_more_than_the_mean_of_the_extensions_map() {
        let converted = |plain: Value| {
            let extension = json!({ "specularGlossinessTexture": { "index": 0 }, "diffuseFactor": [0.5, 0.5, 0.5, 1] });
            let material = json!({ "pbrMetallicRoughness": plain, "extensions": { EXTENSION: extension } });
            let mut document = json!({ "materials": [material] });
            assert!(convert(&mut document));
            (Glossiness::of_all(&document)[0].is_some(), document["materials"][0]["pbrMetallicRoughness"].clone())
        };
        let mapped = json!({ "metallicRoughnessTexture": { "index": 1 } });
        assert_eq!(converted(mapped.clone()), (false, mapped));
        let (is_kept, plain) = converted(json!({ "roughnessFactor": 0.3 }));
        assert!(is_kept && plain["baseColorFactor"][0] == 0.5, "negative control: no such map");
    }

    #[test]
    fn metals_and_plastics_come_out_as_such() {
        let of = |diffuse: [f32; 3], specular: [f32; 3]| metallic(diffuse.into(), specular.into());
        let (base, metalness) = of([0.5, 0.25, 0.1], [0.04; 3]);
        assert!(metalness < 1e-4 && base.distance(Vec3::new(0.5, 0.25, 0.1)) < 1e-4, "{base} {metalness}");
        let (base, metalness) = of([0.0; 3], [1.0, 0.77, 0.34]);
        assert!(metalness > 0.999 && base.distance(Vec3::new(1.0, 0.77, 0.34)) < 1e-3, "{base} {metalness}");
        // Forward and back: base color 0.6 and metalness 0.5 have these.
        let (base, metal) = (0.6_f32, 0.5_f32);
        let specular = DIELECTRIC * (1.0 - metal) + base * metal;
        let diffuse = base * (1.0 - DIELECTRIC) * (1.0 - metal) / (1.0 - specular);
        let found = of([diffuse; 3], [specular; 3]);
        assert!((found.1 - metal).abs() < 1e-3 && found.0.distance(Vec3::splat(base)) < 1e-3, "{found:?}");
    }
}
