//! The uniforms of a frame: camera, jitter, switches.

use super::{
    light::{GpuLight, GpuPyramid},
    scene::GpuScene,
};
use crate::{
    device::layout::{
        self,
        constants::{BACKGROUND_FLAT, BACKGROUND_MAP, SEEN_IN_MIRRORS, SEEN_WITH_MIRRORS},
    },
    shade::{background::share_weights, mirrors::DEEPEST},
    view::{Background, View},
};
use glam::{Vec2, Vec3};

/// The light of a picture.
#[derive(Clone, Copy)]
pub struct ShownLight<'a> {
    /// The environment if it is shown.
    pub shown: Option<&'a GpuLight>,
    /// The environment, shown or not.
    pub behind: Option<&'a GpuLight>,
    /// Whether the light is shown that surfaces send by themselves.
    pub emission: bool,
    /// Reflectance of a ground that catches shadows for a radiance of 1 behind it, if there is one.
    pub catches: Option<Vec3>,
    /// Whether mirrors show the scene.
    pub mirrors: bool,
    /// Most light of a surface that rays of wider lobes show.
    pub brightest: f32,
}

/// Uniforms of one jittered sample, which is at `offset` in its pixel, for every `stride`th pixel of every `stride`th row.
pub fn frame(
    view: &View,
    sample: u32,
    offset: Vec2,
    scene: &GpuScene,
    lit: ShownLight,
    stride: u32,
) -> layout::FrameUniforms {
    let projection = view.projection_of(sample);
    let (sin, cos) = lit.behind.map_or(0.0, |l| l.rotation).sin_cos();
    let [background, caught] = [behind(view, lit.shown.is_some()), caught(view)];
    let background = if view.hides_background { BLACK } else { background };
    let catcher = scene.ground.as_ref().filter(|_| lit.catches.is_some()).map_or(u32::MAX, |g| g.first_triangle);
    layout::FrameUniforms {
        clip_from_world: projection.clip_from_world(offset, scene.near).to_cols_array_2d(),
        world_from_view: [0, 1, 2].map(|i| projection.world_from_view.col(i).extend(0.0).to_array()),
        eye: projection.eye.to_array(),
        tan_half_fov: projection.tan_half_fov,
        pixel_offset: offset.to_array(),
        size: view.size,
        background_color: background.1.to_array(),
        background: background.0,
        environment_turn: [sin, cos],
        environment_intensity: lit.behind.map_or(0.0, |l| l.intensity),
        leaf_solid_angle: scene.leaf_solid_angle,
        tree_height: scene.tree_height,
        view_mode: view.mode as u32,
        wireframe: u32::from(view.wireframe),
        source_tree_height: scene.sources.as_ref().map_or(0, |s| s.tree_height),
        sample,
        catcher,
        stride: [stride; 2],
        caught_color: caught.1.to_array(),
        caught: caught.0,
        caught_per_radiance: lit.catches.unwrap_or_default().to_array(),
        lets_light_through: u32::from(view.background == Background::Transparent),
        share_weights: lit.catches.map_or(Vec3::ZERO, share_weights).to_array(),
        mirrored_height: lit.shown.and_then(|light| light.mirrored.as_ref()).map_or(0, GpuPyramid::height),
        shows_emission: lit.emission.into(),
        sample_distance: (view.aa.max(1) as f32).sqrt().recip(),
        seen: if lit.mirrors { SEEN_WITH_MIRRORS } else { 0 },
        // WGSL has no infinity.
        brightest: lit.brightest.min(f32::MAX),
        picture_sample: sample,
        of_lobe: (view.aa.max(1) as f32).recip(),
        picture_stride: [stride; 2],
        center: projection.center.to_array(),
        padding: [0; 2],
    }
}

/// Uniforms for the points that so many mirrors show in a frame, in the pass that adds light to that of some others. Maps are looked
/// up at points. The last mirror shows light as baked.
pub fn in_mirrors(frame: layout::FrameUniforms, mirrors: u32, others: u32) -> layout::FrameUniforms {
    layout::FrameUniforms {
        background: BLACK.0,
        background_color: BLACK.1.to_array(),
        wireframe: 0,
        sample: others,
        stride: [1; 2],
        caught: BACKGROUND_MAP,
        lets_light_through: 0,
        sample_distance: 0.0,
        seen: if mirrors < DEEPEST { SEEN_IN_MIRRORS | SEEN_WITH_MIRRORS } else { SEEN_IN_MIRRORS },
        ..frame
    }
}

const BLACK: (u32, Vec3) = (BACKGROUND_FLAT, Vec3::ZERO);

/// Kind and color of what pixels without a surface show.
fn behind(view: &View, has_map: bool) -> (u32, Vec3) {
    match view.background {
        Background::Flat(color) => (BACKGROUND_FLAT, color),
        Background::Environment | Background::Blurred(_) if has_map => (BACKGROUND_MAP, Vec3::ZERO),
        _ => BLACK,
    }
}

/// Kind and color of what a ground catches: white for an alpha channel.
fn caught(view: &View) -> (u32, Vec3) {
    match view.background {
        Background::Transparent => (BACKGROUND_FLAT, Vec3::ONE),
        _ => behind(view, true),
    }
}
