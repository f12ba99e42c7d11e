//! Clamps the rest of a scene after the import: numbers out of range are replaced, and cameras and lights without a
//! place are left out, each with a warning.

use crate::names::listed;
use lapidary_core::{bounds::MOST_COORDINATE, camera::Camera, lights::Light, material::Material, scene::Scene};

/// Clamps all of a scene except its mesh.
pub(super) fn keep_in_range(scene: &mut Scene, warnings: &mut Vec<String>) {
    let repaired: Vec<String> =
        scene.materials.iter_mut().filter_map(|m| repair_material(m).then(|| m.name.clone())).collect();
    if !repaired.is_empty() {
        warnings.push(material_warning(&repaired));
    }
    leave_out_cameras(&mut scene.cameras, warnings);
    leave_out_lights(&mut scene.lights, warnings);
}

/// Clamps the numbers of a material; returns whether any changed.
pub(super) fn repair_material(material: &mut Material) -> bool {
    let repaired = material.clone().sanitized();
    let changed = repaired != *material;
    *material = repaired;
    changed
}

/// The warning about materials with numbers out of range.
pub(super) fn material_warning(names: &[String]) -> String {
    format!("the materials {} have numbers out of range, which were replaced; correct them", listed(names))
}

fn leave_out_cameras(cameras: &mut Vec<Camera>, warnings: &mut Vec<String>) {
    let (valid, invalid) = std::mem::take(cameras).into_iter().partition(Camera::is_valid);
    *cameras = valid;
    warn("cameras", invalid.into_iter().map(|camera: Camera| camera.name).collect(), warnings);
}

fn leave_out_lights(lights: &mut Vec<Light>, warnings: &mut Vec<String>) {
    let (valid, invalid) = std::mem::take(lights).into_iter().partition(|light| light.validate().is_ok());
    *lights = valid;
    warn("lights", invalid.into_iter().map(|light: Light| light.name).collect(), warnings);
}

fn warn(what: &str, names: Vec<String>, warnings: &mut Vec<String>) {
    if !names.is_empty() {
        warnings.push(format!(
            "the {what} {} were left out: they have no direction, or a number that is invalid or beyond {MOST_COORDINATE:e}; \
             correct them",
            listed(&names)
        ));
    }
}
