//! Distance of ray origins from surfaces, and of ray ends from lights.
//!
//! Positions are rounded in proportion to the size of a scene, so distances are shares of the diagonal of its bounds.
//! For baked or shaded points they also scale with the edges of their triangles, because the rounding of a position on
//! a triangle does. Points that only send or receive bounced light need no such care.
//!
//! Shaded and baked points share one rule, [`of_shading`] and [`of_baking`]. The others are separate constants, because
//! pictures and bakes would change with them. This is the only place that defines them.

/// Distance of ray origins from a baked or shaded point, as a share of the mean edge of its triangles.
pub const OF_EDGE: f32 = 0.02;
/// Largest distance of ray origins from a surface for baked and shaded points, as a share of the diagonal.
pub const LARGEST: f32 = 2e-4;
/// Smallest distance of ray origins from a surface for baked points, as a share of the diagonal.
pub const SMALLEST_BAKED: f32 = 4e-6;
/// Distance from a surface of shadow ray origins, for points that bounce light, as a share of the diagonal.
pub const BOUNCE: f32 = 1e-4;
/// Distance from a surface of ray origins in light transport, and of the ends of segments to sources, as a share of the
/// diagonal: sources see into narrow gaps.
pub const TRANSPORT: f32 = 1e-5;

/// Share of the way to a light that shadow rays of a shaded point cover: lights often lie in the surface of their lamp.
pub const REACH_OF_SHADING: f32 = 1.0 - 1e-4;
/// [`REACH_OF_SHADING`] for points that bounce light.
pub const REACH_OF_BOUNCE: f32 = 1.0 - 1e-3;

/// Distance in meters of ray origins from the triangle of a shaded point. `edge` is its mean edge in meters, `largest`
/// is [`LARGEST`] times the diagonal of the scene.
#[inline(always)]
pub fn of_shading(edge: f32, largest: f32) -> f32 {
    (OF_EDGE * edge).clamp(OF_EDGE * largest, largest)
}

/// [`of_shading`] for a baked vertex: `edge` is the mean edge around it, and `height` the largest offset that the
/// surrounding triangles allow, in meters.
pub fn of_baking(edge: f32, height: f32, diagonal: f32) -> f32 {
    (OF_EDGE * edge).min(height).clamp(SMALLEST_BAKED * diagonal, LARGEST * diagonal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_follow_the_edges_between_their_bounds() {
        let diagonal = 10.0;
        let largest = LARGEST * diagonal;
        assert_eq!(of_shading(0.05, largest), 0.02 * 0.05);
        assert_eq!((of_shading(1.0, largest), of_shading(0.0, largest)), (largest, OF_EDGE * largest));
        assert_eq!(of_baking(0.05, 1.0, diagonal), 0.02 * 0.05);
        assert_eq!(of_baking(0.05, 1e-4, diagonal), 1e-4, "a sliver's height");
        assert_eq!((of_baking(1.0, 1.0, diagonal), of_baking(0.0, 1.0, diagonal)), (largest, 4e-6 * diagonal));
    }
}
