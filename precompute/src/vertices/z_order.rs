//! Bake points in an order that keeps neighbors in space together.

use crate::vertices::points::BakePoint;
use lapidary_core::bounds::Bounds;

/// Cells along each axis, as bits.
const BITS: u32 = 10;

/// Indices of the points along a Z-curve through cells of space; within a cell by the octants of their normals.
pub fn z_order(points: &[BakePoint]) -> Vec<u32> {
    let bounds = Bounds::around(points.iter().map(|point| point.position));
    let cells = ((1 << BITS) - 1) as f32 / (bounds.max - bounds.min).max_element().max(f32::MIN_POSITIVE);
    let key = |point: &BakePoint| {
        let [x, y, z] = ((point.position - bounds.min) * cells).as_uvec3().to_array();
        (spread(x) << 2 | spread(y) << 1 | spread(z), point.normal.is_negative_bitmask())
    };
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by_cached_key(|&i| key(&points[i as usize]));
    order
}

/// The lowest [`BITS`] bits, each followed by two zeros.
fn spread(v: u32) -> u32 {
    (0..BITS).fold(0, |spread, bit| spread | (v >> bit & 1) << (3 * bit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn neighbours_in_order_are_near_each_other() {
        let mut rng = fastrand::Rng::with_seed(1);
        let place = |_| BakePoint {
            position: Vec3::new(rng.f32(), rng.f32(), rng.f32()),
            normal: Vec3::Y,
            offset: 0.0,
            horizon: 0.0,
            two_sided: false,
            places: [Vec3::ZERO; 2],
        };
        let points: Vec<BakePoint> = (0..4096).map(place).collect();
        let order = z_order(&points);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().zip(0..4096).all(|(&a, b)| a == b));
        let mean = |order: &[u32]| {
            let step = |w: &[u32]| points[w[0] as usize].position.distance(points[w[1] as usize].position);
            order.windows(2).map(step).sum::<f32>() / 4095.0
        };
        assert!(mean(&order) < 0.15, "{}", mean(&order));
        assert!(mean(&sorted) > 0.5, "negative control");
    }
}
