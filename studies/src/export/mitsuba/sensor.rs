//! Integrator, camera and film.
//!
//! Mitsuba samples a pixel's square at random, the references of this program at `--aa` fixed positions: compare with a reference
//! that has many. Pixel grid and vertical field of view are the same.

use super::{MitsubaScene, xml};
use glam::Vec2;
use lapidary_core::{
    bounds::Bounds,
    camera::{Camera, Lens},
    ground::Ground,
};
use lapidary_render::{Appearance, Background, View, has_mirrors};

/// Values that `mitsuba -D` or `mi.load_file` may set.
pub const DEFAULTS: &str = "<default name=\"materials\" value=\"materials.xml\"/>\n\
    <default name=\"spp\" value=\"256\"/>\n<include filename=\"$materials\"/>\n";

/// The path integrator, a perspective camera and a film of linear Rec. 709 with a box filter.
pub fn integrator_and_sensor(scene: &MitsubaScene) -> String {
    let hidden = scene.view.background != Background::Environment && !scene.emission;
    let integrator = format!("<default name=\"max_depth\" value=\"{}\"/>\n", depth(scene))
        + &xml::plugin(
            "integrator",
            "path",
            "",
            &(xml::value("integer", "max_depth", "$max_depth") + &xml::value("boolean", "hide_emitters", hidden)),
        );
    integrator + &xml::plugin("sensor", lens(scene), "", &sensor(scene))
}

/// Thin surfaces along a path: Mitsuba counts each as a bounce.
const LAYERS: u32 = 8;

/// Edges of the longest path, including eye and light. Light from an emissive surface to another counts as a bounce, light from a
/// lamp does not.
fn depth(scene: &MitsubaScene) -> u32 {
    let is_lit_by_surfaces_alone = scene.environment.is_none() && scene.lights.is_empty();
    let layers = if scene.lets_through() { LAYERS } else { 0 };
    scene.bounces.saturating_add(layers + if is_lit_by_surfaces_alone { 1 } else { 2 })
}

/// A thin lens with an aperture, or a pinhole.
fn lens(scene: &MitsubaScene) -> &'static str {
    if scene.view.camera.lens.f_number.is_some() { "thinlens" } else { "perspective" }
}

fn sensor(scene: &MitsubaScene) -> String {
    let View { camera, size: [width, height], .. } = scene.view;
    let mesh = &scene.dataset.scene.mesh;
    let extent = |bounds: Bounds| camera.eye.distance(bounds.center()) + bounds.diagonal();
    // The ground is visible as far as it extends.
    let [reach, farthest] = [mesh.bounds(), Bounds::around(mesh.positions.iter().copied())].map(extent);
    let sampler = xml::plugin("sampler", "multijitter", "", &xml::value("integer", "sample_count", "$spp"));
    let film = [
        xml::value("integer", "width", width),
        xml::value("integer", "height", height),
        xml::value("string", "pixel_format", "rgb"),
        xml::value("string", "component_format", "float32"),
        xml::plugin("rfilter", "box", "", ""),
    ];
    [
        xml::value("string", "fov_axis", "y"),
        xml::value("float", "fov", camera.fov_y.to_degrees()),
        xml::value("float", "near_clip", 1e-6 * reach),
        xml::value("float", "far_clip", 2.0 * farthest),
        // The upward axis of the picture, because the camera's may be parallel to the view.
        xml::look_at(camera.eye, camera.target, camera.world_from_view().y_axis),
        aperture(camera),
        shift(scene.view),
        sampler,
        xml::plugin("film", "hdrfilm", "", &film.concat()),
    ]
    .concat()
}

/// Radius of the aperture and distance in focus, in meters.
pub fn aperture(camera: &Camera) -> String {
    if camera.lens.f_number.is_none() {
        return String::new();
    }
    let radius = xml::value("float", "aperture_radius", camera.aperture_radius());
    radius + &xml::value("float", "focus_distance", camera.focus_distance())
}

/// The shift of a pinhole, in widths and heights of the film: Mitsuba adds it to positions on the film, to the right and down.
pub fn shift(view: &View) -> String {
    let (Lens { shift, f_number, .. }, [width, height]) = (view.camera.lens, view.size);
    if shift == Vec2::ZERO || f_number.is_some() {
        return String::new();
    }
    let across = shift.x * height as f32 / width.max(1) as f32;
    xml::value("float", "principal_point_offset_x", across) + &xml::value("float", "principal_point_offset_y", -shift.y)
}

/// Differences of view and path length in Mitsuba.
pub fn remarks(scene: &MitsubaScene) -> Vec<String> {
    let view = scene.view;
    let shines = scene.emission;
    let behind = view.background != Background::Environment;
    let is_seen = shines && behind && scene.environment.is_some();
    let is_blurred = matches!(view.background, Background::Blurred(_)) && !shines;
    let is_ground = scene.dataset.scene.mesh.ground.is_some() && view.ground != Ground::On;
    let is_mixed = shines && (scene.environment.is_some() || !scene.lights.is_empty());
    let mirrors = || has_mirrors(&Appearance::of(&scene.dataset.scene), scene.dataset);
    let is_shifted = view.camera.lens.f_number.is_some() && view.camera.lens.shift != Vec2::ZERO;
    let is_mirrored = view.mirrors && scene.bounces < 2 && mirrors();
    [
        (is_shifted, "Mitsuba shifts no picture of an open lens: leave out the shift, or the f-number"),
        (is_mirrored, "mirrors show the scene in Mitsuba by bounces of light: choose two or more, and all surfaces bounce"),
        (is_blurred, "Mitsuba shows no blurred background: it is black there"),
        (
            is_seen,
            "Mitsuba shows the environment as background, because it could only hide it together with emissive surfaces",
        ),
        (is_ground, "Mitsuba shows the ground as a surface: choose --ground on to compare with it"),
        (
            scene.lets_through(),
            "Mitsuba counts surfaces that light passes as bounces: the longest path is 8 longer for them",
        ),
        (
            scene.lets_through() && !scene.lights.is_empty(),
            "Mitsuba's local lights cast whole shadows behind surfaces that let light through",
        ),
        (is_mixed, "light of emissive surfaces has one bounce more in Mitsuba, as many as light of lamps"),
    ]
    .into_iter()
    .filter(|(differs, _)| *differs)
    .map(|(_, remark)| remark.into())
    .collect()
}
