//! The uniforms of a frame: camera, jitter, switches.

use super::{
    layout::{
        self,
        constants::{BACKGROUND_FLAT, BACKGROUND_MAP},
    },
    light::GpuLight,
    scene::GpuScene,
};
use crate::view::{Background, View};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// Uniforms of one jittered sample, which is at `offset` in its pixel, for every `stride`th pixel of every `stride`th row.
pub fn frame(
    view: &View,
    sample: u32,
    offset: Vec2,
    scene: &GpuScene,
    light: Option<&GpuLight>,
    stride: u32,
) -> layout::FrameUniforms {
    let world_from_view = view.camera.world_from_view();
    let tan_half_fov = (0.5 * view.camera.fov_y).tan();
    let (sin, cos) = light.map_or(0.0, |l| l.rotation).sin_cos();
    let (background, background_color) = match (view.background, light) {
        (Background::Flat(color), _) => (BACKGROUND_FLAT, color),
        (Background::Transparent, _) | (_, None) => (BACKGROUND_FLAT, Vec3::ZERO),
        (Background::Environment | Background::Blurred(_), Some(_)) => (BACKGROUND_MAP, Vec3::ZERO),
    };
    layout::FrameUniforms {
        clip_from_world: clip_from_world(view, offset, scene.near).to_cols_array_2d(),
        world_from_view: [0, 1, 2].map(|i| world_from_view.col(i).extend(0.0).to_array()),
        eye: view.camera.eye.to_array(),
        tan_half_fov,
        pixel_offset: offset.to_array(),
        size: view.size,
        background_color: background_color.to_array(),
        background,
        environment_turn: [sin, cos],
        environment_intensity: light.map_or(0.0, |l| l.intensity),
        leaf_solid_angle: scene.leaf_solid_angle,
        tree_height: scene.tree_height,
        view_mode: view.mode as u32,
        wireframe: u32::from(view.wireframe),
        source_tree_height: scene.sources.as_ref().map_or(0, |s| s.tree_height),
        sample,
        padding: 0,
        stride: [stride; 2],
    }
}

/// The rasteriser samples at the centre of a pixel: the picture is moved so that the jittered sample lies there.
fn clip_from_world(view: &View, offset: Vec2, near: f32) -> Mat4 {
    let size = Vec2::new(view.size[0] as f32, view.size[1] as f32);
    let tan = (0.5 * view.camera.fov_y).tan();
    let shift = (Vec2::splat(1.0) - 2.0 * offset) / size * Vec2::new(1.0, -1.0);
    // Depth is near / distance: 1 at the near plane, 0 at infinity.
    let clip_from_view = Mat4::from_cols(
        Vec4::new(size.y / (size.x * tan), 0.0, 0.0, 0.0),
        Vec4::new(0.0, 1.0 / tan, 0.0, 0.0),
        Vec4::new(-shift.x, -shift.y, 0.0, -1.0),
        Vec4::new(0.0, 0.0, near, 0.0),
    );
    let view_from_world = view.camera.world_from_view().transpose();
    clip_from_view * Mat4::from_mat3(view_from_world) * Mat4::from_translation(-view.camera.eye)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::camera::Camera;

    #[test]
    fn a_point_seen_through_a_jittered_sample_lands_on_the_centre_of_its_pixel() {
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.2, 0.1, -0.5), 50.0);
        let view = View::new(camera, [64, 48]);
        for (pixel, offset) in [([3.0, 5.0], [0.1, 0.8]), ([60.0, 40.0], [0.9, 0.2]), ([0.0, 0.0], [0.5, 0.5])] {
            let (pixel, offset) = (Vec2::from(pixel), Vec2::from(offset));
            let direction = view.camera.direction_through(pixel + offset, view.size);
            let clip = clip_from_world(&view, offset, 0.01) * (view.camera.eye + 7.0 * direction).extend(1.0);
            let ndc = clip / clip.w;
            let position = Vec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * Vec2::new(64.0, 48.0);
            assert!((position - pixel - 0.5).length() < 1e-3, "{position} for {pixel}");
            assert!(ndc.z > 0.0 && ndc.z < 1.0);
        }
    }
}
