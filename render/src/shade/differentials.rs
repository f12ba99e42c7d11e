//! Spacing of neighboring samples on a surface: ray differentials of a pinhole camera (Igehy 1999), exact to first order on a
//! triangle's plane. Twin of `footprint_at` in `shaders/surface.wgsl`.

use crate::view::View;
use glam::{Vec2, Vec3};
use lapidary_core::texture::UvFootprint;

/// Spacing of neighboring samples, for all pixels of a view.
#[derive(Clone, Copy, Debug)]
pub struct Differentials {
    eye: Vec3,
    forward: Vec3,
    /// Ray displacement per meter of depth from a sample to the next on the right and below.
    per_depth: [Vec3; 2],
}

impl Differentials {
    /// For a view whose samples divide their pixel evenly.
    pub fn of(view: &View) -> Self {
        let projection = view.projection();
        let axes = projection.world_from_view;
        let size = projection.pixel_span(1.0) / (view.aa.max(1) as f32).sqrt();
        let per_depth = [axes.x_axis * size, -axes.y_axis * size];
        Self { eye: projection.eye, forward: projection.forward(), per_depth }
    }

    /// The footprint of a sample at `position` on a triangle's plane. `normal` may have any length; `per_u` and `per_v` are the
    /// gradients of u and v along the surface.
    pub fn at(&self, uv: Vec2, position: Vec3, normal: Vec3, [per_u, per_v]: [Vec3; 2]) -> UvFootprint {
        let away = position - self.eye;
        let depth = away.dot(self.forward);
        let changes = self.per_depth.map(|per_depth| {
            let across = depth * per_depth;
            let moved = across - away * (normal.dot(across) / normal.dot(away));
            Vec2::new(per_u.dot(moved), per_v.dot(moved))
        });
        UvFootprint { uv, changes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::camera::Camera;

    #[test]
    fn changes_are_those_of_neighbouring_rays_with_the_plane() {
        let camera = Camera::look_at(Vec3::new(0.3, 2.0, 1.0), Vec3::new(0.0, 0.0, -6.0), 40.0);
        let view = View { aa: 4, ..View::new(camera.clone(), [200, 100]) };
        let hit = |pixel: Vec2| {
            let direction = camera.direction_through(pixel, view.size);
            camera.eye - direction * (camera.eye.y / direction.y)
        };
        // Two units of u per meter of x, one unit of v per two meters of z.
        let (per_u, per_v) = (2.0 * Vec3::X, 0.5 * Vec3::Z);
        let uv = |p: Vec3| Vec2::new(per_u.dot(p), per_v.dot(p));
        for pixel in [Vec2::new(100.0, 50.0), Vec2::new(20.0, 80.0)] {
            let seen = hit(pixel);
            let footprint = Differentials::of(&view).at(uv(seen), seen, 3.0 * Vec3::Y, [per_u, per_v]);
            for (change, step) in footprint.changes.into_iter().zip([Vec2::X, Vec2::Y]) {
                // Four samples per pixel are half a pixel apart.
                let near = (uv(hit(pixel + 0.05 * step)) - uv(hit(pixel - 0.05 * step))) * 5.0;
                assert!((change - near).length() < 2e-3 * near.length(), "{change} {near}");
                assert!((change - 2.0 * near).length() > 0.5 * near.length(), "negative control");
            }
        }
    }
}
