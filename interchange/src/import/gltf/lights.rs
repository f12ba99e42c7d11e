//! Lights of a glTF file (`KHR_lights_punctual`), read from the JSON itself: the `gltf` crate refuses a whole file for
//! one invalid light.
//!
//! The extension uses candela and lux. They are taken as W/sr and W/m², without a luminous efficacy: renderers of
//! linear RGB have no other unit of brightness, and exporters disagree about the factor.

use crate::{
    features::gltf::RANGES,
    import::{fields, source::Source},
};
use glam::{Mat4, Vec3};
use lapidary_core::lights::{Emission, Light, MAX_LIGHTS};
use serde::Deserialize;
use serde_json::Value;
use std::f32::consts::FRAC_PI_4;

/// Name of the extension.
pub(super) const EXTENSION: &str = "KHR_lights_punctual";

/// A light as in the extension.
#[derive(Deserialize)]
#[serde(default)]
struct Punctual {
    name: Option<String>,
    #[serde(rename = "type")]
    kind: String,
    color: Vec3,
    intensity: f32,
    range: Option<f32>,
    spot: Spot,
}

impl Default for Punctual {
    fn default() -> Self {
        let spot = Spot::default();
        Self { name: None, kind: String::new(), color: Vec3::ONE, intensity: 1.0, range: None, spot }
    }
}

/// Angles from the axis in radians.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Spot {
    inner_cone_angle: f32,
    outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: FRAC_PI_4 }
    }
}

/// Adds the lights of all nodes; `document` is the JSON of the file. Invalid lights are left out with a warning.
pub(super) fn add_lights(source: &mut Source, document: &Value, nodes: &[(gltf::Node, Mat4)]) {
    let mut ranged = Vec::new();
    let mut count = 0;
    for (node, world_from_node) in nodes {
        let index = &document["nodes"][node.index()]["extensions"][EXTENSION]["light"];
        if index.is_null() {
            continue;
        }
        count += 1;
        if source.lights.len() == MAX_LIGHTS {
            continue;
        }
        let fallback = format!("light {count}");
        match read_light(document, index, node.name().unwrap_or(&fallback), *world_from_node) {
            Ok((light, range)) => {
                ranged.extend(range.map(|_| light.name.clone()));
                source.lights.push(light);
            }
            Err(reason) => {
                let name = node.name().unwrap_or(&fallback);
                source.warnings.push(format!("the light \"{name}\" was left out: {reason}"));
            }
        }
    }
    source.warnings.extend(RANGES.warning("lights", &ranged));
    if count > MAX_LIGHTS {
        source.warnings.push(format!("the file has {count} lights, of which the first {MAX_LIGHTS} are used"));
    }
}

/// The light of a node, and its range.
fn read_light(
    document: &Value,
    index: &Value,
    name: &str,
    world_from_node: Mat4,
) -> Result<(Light, Option<f32>), String> {
    let index = index.as_u64().and_then(|i| usize::try_from(i).ok()).ok_or("its index is not a number")?;
    let entry = document["extensions"][EXTENSION]["lights"].get(index);
    let entry = entry.ok_or_else(|| format!("it refers to light {index}, which the file has not"))?;
    let punctual: Punctual = fields::contents(entry)?;
    let emission = emission(&punctual)?;
    let position = world_from_node.w_axis.truncate();
    let forward = -world_from_node.z_axis.truncate().normalize_or(Vec3::NEG_Z);
    let light = Light {
        name: punctual.name.unwrap_or_else(|| name.to_owned()),
        enabled: true,
        emission,
        position,
        target: position + forward,
        intensity: punctual.color * punctual.intensity,
    };
    light.validate().map_err(|problem| problem.to_string())?;
    Ok((light, punctual.range))
}

fn emission(light: &Punctual) -> Result<Emission, String> {
    match light.kind.as_str() {
        "point" => Ok(Emission::Point),
        "directional" => Ok(Emission::PARALLEL),
        "spot" => {
            let cone_degrees = light.spot.outer_cone_angle.to_degrees();
            let inner_degrees = light.spot.inner_cone_angle.to_degrees();
            Ok(Emission::Spot { cone_degrees, penumbra_degrees: cone_degrees - inner_degrees })
        }
        kind => Err(format!("its type is \"{kind}\"; point, spot and directional are known")),
    }
}
