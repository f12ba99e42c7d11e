//! Triangle edges as lines of uniform width in pixels, drawn over the displayed picture after its tone curve, so they look the same
//! at any exposure.
//!
//! Twin of `shaders/wireframe.wgsl`. Lines are computed from the projected corners in homogeneous coordinates, so corners behind
//! the eye need no clipping.

use glam::{Vec2, Vec3};

/// Width of a line's opaque core in pixels.
pub const LINE_WIDTH: f32 = 1.0;
/// Width in pixels of the soft edge on each side of a line.
pub const LINE_FADE: f32 = 1.0;
/// Opacity in the middle of a line.
pub const LINE_OPACITY: f32 = 0.7;
/// sRGB-encoded line color: a cyan distinct from black, white, skin, wood and magma.
pub const LINE_COLOR: Vec3 = Vec3::new(0.10, 0.75, 0.95);

/// Distance in pixels from `pixel`, a position inside a projected triangle, to the nearest of its edges.
pub fn edge_distance(pixel: Vec2, corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners.map(|p| (p.truncate() - pixel * p.z).extend(p.z));
    line_distance(a, b).min(line_distance(b, c)).min(line_distance(c, a))
}

/// Distance from the origin to the line through two homogeneous points; infinite if they coincide.
fn line_distance(a: Vec3, b: Vec3) -> f32 {
    let line = a.cross(b);
    let length = line.truncate().length();
    if length > 0.0 { line.z.abs() / length } else { f32::INFINITY }
}

/// Line coverage of a sample at `distance` pixels from an edge, 0 to 1.
pub fn line_coverage(distance: f32) -> f32 {
    ((0.5 * LINE_WIDTH + LINE_FADE - distance) / LINE_FADE).clamp(0.0, 1.0)
}

/// A displayed color with lines drawn over it.
pub fn over(shown: Vec3, coverage: f32) -> Vec3 {
    shown.lerp(LINE_COLOR, LINE_OPACITY * coverage)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_on_the_screen_even_with_a_corner_behind_the_eye() {
        let at = |x: f32, y: f32, depth: f32| Vec3::new(x * depth, y * depth, depth);
        // Edges x = 0, y = 0 and x + y = 10, at different depths.
        let corners = [at(0.0, 0.0, 1.0), at(10.0, 0.0, 5.0), at(0.0, 10.0, 0.3)];
        assert!((edge_distance(Vec2::new(2.0, 3.0), corners) - 2.0).abs() < 1e-4);
        assert!((edge_distance(Vec2::new(4.5, 4.5), corners) - 0.5_f32.sqrt()).abs() < 1e-4);
        // The edges from (0, 0) continue through the screen toward corners behind the eye.
        let behind = [at(0.0, 0.0, 1.0), at(-10.0, 0.0, -2.0), at(0.0, -10.0, -2.0)];
        assert!((edge_distance(Vec2::new(2.0, 3.0), behind) - 2.0).abs() < 1e-4);
        let point = [at(1.0, 1.0, 1.0); 3];
        assert_eq!(edge_distance(Vec2::ZERO, point), f32::INFINITY);
    }

    #[test]
    fn lines_are_full_in_the_middle_fade_out_and_leave_the_rest_alone() {
        assert_eq!(line_coverage(0.0), 1.0);
        assert_eq!(line_coverage(0.5 * LINE_WIDTH + 0.5 * LINE_FADE), 0.5);
        assert_eq!(line_coverage(3.0), 0.0);
        assert_eq!(line_coverage(f32::INFINITY), 0.0);
        let shown = Vec3::new(0.2, 0.4, 0.6);
        assert_eq!(over(shown, 0.0), shown);
        assert!((over(shown, 1.0) - LINE_COLOR).length() < (shown - LINE_COLOR).length() * 0.31);
    }
}
