//! Views from lights, one per layer of the shadow maps. Twin of `shaders/shadow.wgsl`.
//!
//! A narrow spot has one view. A point has the six faces of a cube. A wide spot and each point of a rectangle have the
//! five faces of a hemicube. Directional lights have rays instead.

use crate::device::layout::{ShadowView, constants::KERNEL_RADIUS};
use glam::{Vec2, Vec3};
use lapidary_core::lights::{Emission, Light, RectangleShape};

/// Margin of texels around the contents of a view, so that the filter stays on the map.
pub const BORDER: u32 = KERNEL_RADIUS + 2;

/// Cones beyond this angle from axis to edge, in degrees, take a hemicube: one view would be coarse in the middle.
const WIDEST_VIEW: f32 = 75.0;

/// Inputs of views besides the light.
#[derive(Clone, Copy, Debug)]
pub struct ShadowViewSettings {
    /// Distance from a light, in meters, within which nothing casts a shadow.
    pub near: f32,
    /// Texels of a side of a map.
    pub size: u32,
    /// Rectangles cast shadows from `grid` x `grid` points.
    pub grid: u32,
}

/// Views around each point of a light that casts shadows.
pub fn views_per_point(light: &Light) -> u32 {
    match light.emission {
        Emission::Point => 6,
        Emission::Spot { cone_degrees, .. } if cone_degrees > WIDEST_VIEW => 5,
        Emission::Spot { .. } => 1,
        Emission::Rectangle { .. } => 5,
        Emission::Directional { .. } => 0,
    }
}

/// Views of a light in all.
pub fn view_count(light: &Light, grid: u32) -> u32 {
    let points = if matches!(light.emission, Emission::Rectangle { .. }) { grid * grid } else { 1 };
    points * views_per_point(light)
}

/// The views of a light, [`view_count`] of them, point by point; a light without a direction looks down.
pub fn views(light: &Light, settings: &ShadowViewSettings) -> Vec<ShadowView> {
    let forward = light.forward().unwrap_or(Vec3::NEG_Y);
    match light.emission {
        Emission::Point => cube(light.position, settings),
        Emission::Spot { cone_degrees, .. } if cone_degrees > WIDEST_VIEW => {
            hemicube(light.position, forward, settings)
        }
        Emission::Spot { cone_degrees, .. } => {
            let tan = cone_degrees.to_radians().tan();
            vec![perspective(light.position, forward, forward.any_orthonormal_vector(), tan, settings)]
        }
        // Rays cast their shadows.
        Emission::Directional { .. } => Vec::new(),
        Emission::Rectangle { .. } => {
            let points = RectangleShape::of(light).map_or_else(Vec::new, |shape| grid_points(&shape, settings.grid));
            points.into_iter().flat_map(|p| hemicube(p, forward, settings)).collect()
        }
    }
}

/// The middles of the cells of a grid on a rectangle.
fn grid_points(shape: &RectangleShape, grid: u32) -> Vec<Vec3> {
    let at = |i: u32| (i as f32 + 0.5) / grid as f32;
    (0..grid * grid).map(|i| shape.point(Vec2::new(at(i % grid), at(i / grid)))).collect()
}

fn cube(origin: Vec3, settings: &ShadowViewSettings) -> Vec<ShadowView> {
    let mut views = hemicube(origin, Vec3::Y, settings);
    views.push(perspective(origin, Vec3::NEG_Y, Vec3::X, 1.0, settings));
    views
}

fn hemicube(origin: Vec3, forward: Vec3, settings: &ShadowViewSettings) -> Vec<ShadowView> {
    let right = forward.any_orthonormal_vector();
    let up = forward.cross(right);
    let sides = [right, -right, up, -up].map(|side| (side, forward));
    let faces = [(forward, right)].into_iter().chain(sides);
    faces.map(|(face, up)| perspective(origin, face, up, 1.0, settings)).collect()
}

/// How much larger a view is than what it has to show.
fn with_border(size: u32) -> f32 {
    size as f32 / (size - 2 * BORDER) as f32
}

fn perspective(origin: Vec3, forward: Vec3, up: Vec3, tan: f32, settings: &ShadowViewSettings) -> ShadowView {
    let half = tan * with_border(settings.size);
    ShadowView {
        origin: origin.to_array(),
        depth_scale: settings.near,
        right: forward.cross(up).to_array(),
        half_width: half,
        up: up.to_array(),
        half_height: half,
        forward: forward.to_array(),
        padding: 0,
    }
}

#[cfg(test)]
mod tests;
