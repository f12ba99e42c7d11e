//! A ball of the material under the light of the scene, to judge it apart from the scene's shadows.
//!
//! The ball is convex and alone, so every node above the horizon is visible: the renderer's shader with full
//! visibility. The camera looks from +Z, a little from above.

use glam::{Vec2, Vec3};
use lapidary_core::{material::Material, texture::Texture};
use lapidary_render::{Appearance, EnvironmentLight, SurfacePlace, UnoccludedShader};
use std::{
    f32::consts::{PI, TAU},
    sync::Arc,
};

/// Radius in meters, to which a bump map's height is relative.
const RADIUS: f32 = 0.1;
/// Unit squares of texture coordinates around the equator and from pole to pole, about 16 cm each.
const TILES: Vec2 = Vec2::new(4.0, 2.0);
/// The picture's half width in radii.
pub const MARGIN: f32 = 1.06;

/// A material and the light on it.
#[derive(Clone, Debug)]
pub struct Ball {
    /// The material; its maps refer to `textures`.
    pub material: Material,
    /// Textures of the material's maps; if one is missing, the material is shown without maps, as in the renderer.
    pub textures: Vec<Arc<Texture>>,
    /// The light.
    pub lighting: Arc<EnvironmentLight>,
}

/// A pixel of the ball: scene-linear radiance and how much of the pixel the ball covers.
pub type BallPixel = (Vec3, f32);

impl Ball {
    /// A square picture of `size` pixels, row by row from the top.
    pub fn render(&self, size: u32) -> Vec<BallPixel> {
        let material = std::slice::from_ref(&self.material);
        let (appearance, _) =
            Appearance { materials: material.to_vec(), textures: self.textures.clone(), assigned: None }
                .fitted(material);
        let mut shader = UnoccludedShader::new(appearance, &self.lighting);
        let view = View::new();
        let pixels = (0..size * size).map(|i| {
            let at = (Vec2::new((i % size) as f32, (i / size) as f32) + 0.5) / size as f32 * 2.0 - 1.0;
            let disc = Vec2::new(at.x, -at.y) * MARGIN;
            let coverage = ((1.0 - disc.length()) * size as f32 / (2.0 * MARGIN) + 0.5).clamp(0.0, 1.0);
            if coverage == 0.0 {
                return (Vec3::ZERO, 0.0);
            }
            (shader.shade(&place_of(view.normal_at(disc)), 0, view.wo), coverage)
        });
        pixels.collect()
    }
}

/// The camera: parallel rays.
struct View {
    wo: Vec3,
    up: Vec3,
}

impl View {
    fn new() -> Self {
        let wo = Vec3::new(0.0, 0.25, 1.0).normalize();
        Self { wo, up: wo.cross(Vec3::X) }
    }

    /// Normal of the unit ball at a point of the picture, at the rim for points outside.
    fn normal_at(&self, disc: Vec2) -> Vec3 {
        let disc = disc.clamp_length_max(0.998);
        let toward = (1.0 - disc.length_squared()).sqrt();
        (Vec3::X * disc.x + self.up * disc.y + self.wo * toward).normalize()
    }
}

/// The surface position of the ball with this normal; u increases with longitude from +Z toward +X, v with colatitude
/// from +Y.
fn place_of(normal: Vec3) -> SurfacePlace {
    let (longitude, colatitude) = (normal.x.atan2(normal.z), normal.y.clamp(-1.0, 1.0).acos());
    let (sin, cos) = longitude.sin_cos();
    let tangent = Vec3::new(cos, 0.0, -sin);
    let down = tangent.cross(normal);
    // The coordinates crowd at the poles; a bump there is cut off rather than endless.
    let circle = TAU * RADIUS * colatitude.sin().max(0.05);
    SurfacePlace {
        position: RADIUS * normal,
        smooth_normal: normal,
        tangent,
        handedness: 1.0,
        attributes: (Vec2::new(longitude / TAU, colatitude / PI) * TILES).into(),
        slopes: [Some([tangent * (TILES.x / circle), down * (TILES.y / (PI * RADIUS))]); 2],
    }
}

#[cfg(test)]
mod tests;
