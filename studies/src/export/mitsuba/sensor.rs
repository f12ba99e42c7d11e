//! Integrator, camera and film.
//!
//! Mitsuba averages a pixel over its square at random, the references of this program at `--aa` fixed places: compare with a
//! reference of many. Its pixel grid and vertical field of view are the same.

use super::{MitsubaScene, xml};
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
    let bounds = scene.dataset.scene.mesh.bounds();
    let reach = camera.eye.distance(bounds.center()) + bounds.diagonal();
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
        xml::value("float", "far_clip", 2.0 * reach),
        // The upward axis of the picture rather than that of the camera, which may lie along the view.
        xml::look_at(camera.eye, camera.target, camera.world_from_view().y_axis),
        sampler,
        xml::plugin("film", "hdrfilm", "", &film.concat()),
    ]
    .concat()
}

/// What of the view Mitsuba does not show.
pub fn remarks(view: &View) -> Vec<String> {
    match view.background {
        Background::Blurred(_) => vec!["Mitsuba shows no blurred background: it is black there".into()],
        _ => Vec::new(),
    }
}
