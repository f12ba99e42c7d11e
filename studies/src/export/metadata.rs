//! Metadata of picture files: everything needed to reproduce the picture, and the work done.

use super::Taken;
use lapidary_core::{
    animation::ClipTime,
    dataset::Dataset,
    scene::{Scene, pose::Poses},
};
use lapidary_interchange::image::{Layer, LayeredImage, MetaValue, Metadata};
use lapidary_render::{Look, RenderStats};
use serde_json::{Map, Value, json};

/// The program with its version.
pub const SOFTWARE: &str = concat!("Lapidary ", env!("CARGO_PKG_VERSION"));

/// All settings of a picture except its size, by attribute names without their prefix.
pub fn settings(look: &Look, dataset: &Dataset) -> Map<String, Value> {
    let camera = &look.view.camera;
    let lights: Vec<_> = look.lights.iter().filter(|light| light.shines()).collect();
    let environment = &look.illumination.environment;
    let Value::Object(mut settings) = json!({
        "scene_hash": dataset.scene_hash,
        "bake": dataset.settings,
        "camera": camera.name,
        "camera.eye": camera.eye.to_array().map(number),
        "camera.target": camera.target.to_array().map(number),
        "camera.up": camera.up.to_array().map(number),
        "camera.fov_degrees": number(camera.fov_y.to_degrees()),
        "camera.lens": camera.lens,
        "environment": environment.name,
        "environment.rotation_degrees": number(look.illumination.rotation.to_degrees()),
        "environment.intensity": number(look.illumination.intensity),
        "lights": lights,
        "materials": look.appearance.materials,
        "components": look.components.to_string(),
        "solution": look.shown_solution().to_string(),
        "illumination_cut": look.illum_cut,
        "lit_cuts": number(look.tau),
        "brdf_sampling": look.sampling,
        "samples": look.view.aa,
        "background": format!("{:?}", look.view.background),
        "exposure_stops": number(look.post.exposure),
        "tone_map": look.post.tone_map,
        "vignette": number(look.post.vignette),
    }) else {
        unreachable!("braces make an object")
    };
    let scene = &dataset.scene;
    settings.extend(posed("bake.", &scene.placed_poses(), scene.clip_time.as_ref(), scene));
    settings.extend(posed("", &look.poses, look.poses.clip_time(), scene));
    settings
}

/// Poses of objects and the animation time that deforms them; empty if nothing moved. A bake's poses are relative to its file, a
/// look's poses to the bake.
fn posed(prefix: &str, poses: &Poses, time: Option<&ClipTime>, scene: &Scene) -> Vec<(String, Value)> {
    let name = |object: u32| scene.objects.get(object as usize).map_or("", |object| &object.name);
    let by_themselves = poses.without_deformed();
    let pose = |object| json!({ "object": object, "name": name(object), "pose": poses.of(object) });
    let all: Vec<Value> = by_themselves.moved().map(pose).collect();
    let poses = (!all.is_empty()).then(|| ("poses", all.into()));
    let time =
        time.map(|ClipTime { clip, seconds }| [("clip", json!(clip)), ("clip.seconds", json!(number(*seconds)))]);
    let entries = poses.into_iter().chain(time.into_iter().flatten());
    entries.map(|(name, value)| (format!("{prefix}{name}"), value)).collect()
}

/// A number with the digits of its 32-bit float and no more.
fn number(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::NAN)
}

/// A file of layers with metadata.
pub fn layered(look: &Look, dataset: &Dataset, taken: &Taken, layers: Vec<Layer>) -> LayeredImage {
    let mut entries = settings(look, dataset);
    entries.append(&mut work(&taken.stats));
    let attribute = |(name, value): (String, Value)| (format!("lapidary.{name}"), attribute(value));
    let metadata = Metadata {
        software: Some(SOFTWARE.into()),
        camera: Some(look.view.camera.clone()),
        entries: entries.into_iter().map(attribute).collect(),
    };
    LayeredImage { size: look.view.size, layers, metadata }
}

/// The work for a picture.
fn work(stats: &RenderStats) -> Map<String, Value> {
    let entries = [
        ("backend", json!(stats.adapter.as_ref().unwrap_or(&stats.backend))),
        ("render_seconds", json!(stats.seconds)),
        ("pixels_shaded", json!(stats.pixels_shaded)),
        ("mean_merged_nodes", json!(stats.mean_merged_nodes)),
        ("mean_brdf_evaluations", json!(stats.mean_brdf_evaluations)),
    ];
    entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// Writes three numbers as a vector, and other values that attributes cannot hold as JSON.
fn attribute(value: Value) -> MetaValue {
    match value {
        Value::String(words) => MetaValue::Text(words),
        Value::Number(number) => MetaValue::Number(number.as_f64().unwrap_or(f64::NAN)),
        other => vector(&other).map_or_else(|| MetaValue::Text(other.to_string()), MetaValue::Vector),
    }
}

fn vector(value: &Value) -> Option<glam::Vec3> {
    let [x, y, z] = value.as_array()?.as_slice() else { return None };
    let part = |value: &Value| value.as_f64().map(|number| number as f32);
    Some(glam::Vec3::new(part(x)?, part(y)?, part(z)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::{
        scene::pose::{DeformedObject, Pose, PosedVertices},
        test_scenes,
    };
    use lapidary_render::test_looks::look;

    fn moved(x: f32) -> Poses {
        let mut poses = Poses::default();
        poses.set(0, Pose { translate: Vec3::X * x, ..Pose::AS_BAKED });
        poses
    }

    fn deformed() -> Poses {
        let mesh = test_scenes::dataset(&["a"], &[]).scene.mesh;
        let vertices = PosedVertices { positions: mesh.positions, normals: mesh.normals, tangents: mesh.tangents };
        let mut poses = Poses::default();
        poses.deform(0, Some(DeformedObject::new(vertices, [0, 0, 1])));
        poses
    }

    fn time(seconds: f32) -> ClipTime {
        ClipTime { clip: "walk".into(), seconds }
    }

    #[test]
    fn poses_and_times_of_bake_and_look_are_told() {
        let mut dataset = test_scenes::dataset(&["a"], &[]);
        let as_baked = settings(&look(), &dataset);
        dataset.scene.place(&moved(2.0)).unwrap();
        dataset.scene.clip_time = Some(time(0.1));
        let all = settings(&Look { poses: deformed().at(time(0.7)), ..look() }, &dataset);
        assert_eq!(
            (&all["bake.poses"][0]["name"], &all["bake.poses"][0]["pose"]["translate"][0]),
            (&json!("o"), &json!(2.0))
        );
        assert_eq!((&all["bake.clip"], &all["bake.clip.seconds"]), (&json!("walk"), &json!(0.1)));
        assert_eq!((&all["clip"], &all["clip.seconds"], all.get("poses")), (&json!("walk"), &json!(0.7), None));
        let moved_look = Look { poses: moved(1.0), ..look() };
        assert_eq!(settings(&moved_look, &dataset)["poses"][0]["pose"]["translate"][0], 1.0);
        let others: Vec<&String> = all.keys().filter(|name| !as_baked.contains_key(*name)).collect();
        assert_eq!(others.len(), 5, "{others:?}");
    }
}
