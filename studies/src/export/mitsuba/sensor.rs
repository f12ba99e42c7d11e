//! Integrator, camera and film.
//!
//! Mitsuba averages a pixel over its square at random, the references of this program at `--aa` fixed places: compare with a
//! reference of many. Its pixel grid and vertical field of view are the same.

use super::{MitsubaScene, xml};
use lapidary_core::{bounds::Bounds, ground::Ground};
use lapidary_render::{Background, View};

/// What `mitsuba -D` or `mi.load_file` may set.
pub const DEFAULTS: &str = "<default name=\"materials\" value=\"materials.xml\"/>\n\
    <default name=\"spp\" value=\"256\"/>\n<include filename=\"$materials\"/>\n";

/// The path integrator, a perspective camera and a film of linear Rec. 709 with a box filter.
pub fn integrator_and_sensor(scene: &MitsubaScene) -> String {
    // Mitsuba counts the edges of a path, eye and light included.
    let depth = scene.bounces.saturating_add(2);
    let hidden = scene.view.background != Background::Environment;
    let integrator = format!("<default name=\"max_depth\" value=\"{depth}\"/>\n")
        + &xml::plugin(
            "integrator",
            "path",
            "",
            &(xml::value("integer", "max_depth", "$max_depth") + &xml::value("boolean", "hide_emitters", hidden)),
        );
    integrator + &xml::plugin("sensor", "perspective", "", &sensor(scene))
}

fn sensor(scene: &MitsubaScene) -> String {
    let View { camera, size: [width, height], .. } = scene.view;
    let mesh = &scene.dataset.scene.mesh;
    let extent = |bounds: Bounds| camera.eye.distance(bounds.center()) + bounds.diagonal();
    // The ground is seen as far as it goes.
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
        // The upward axis of the picture rather than that of the camera, which may lie along the view.
        xml::look_at(camera.eye, camera.target, camera.world_from_view().y_axis),
        sampler,
        xml::plugin("film", "hdrfilm", "", &film.concat()),
    ]
    .concat()
}

/// What of the view Mitsuba does not show.
pub fn remarks(view: &View, has_ground: bool) -> Vec<String> {
    let blurred = matches!(view.background, Background::Blurred(_));
    let blurred = blurred.then(|| "Mitsuba shows no blurred background: it is black there".into());
    let ground = has_ground && view.ground != Ground::On;
    let ground = ground.then(|| "Mitsuba shows the ground as a surface: choose --ground on to compare with it".into());
    blurred.into_iter().chain(ground).collect()
}
