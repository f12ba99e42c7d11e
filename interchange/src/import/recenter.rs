//! Moves scenes that are far from the origin there. Coordinates of maps have seven digits before the point, and `f32`
//! holds hardly more: a sphere of 1 m would be of steps of 0.5 m. Readers subtract the offset in double precision.

use glam::{DVec3, Vec3};
use lapidary_core::bounds::Bounds;

/// Largest distance from the origin as a multiple of the scene's size. Here `f32` resolves 1/8000 of the size.
const FARTHEST: f64 = 1000.0;

/// The offset to subtract from the positions of a scene that is too far from the origin: the middle of its bounds, in
/// few digits. Rounding of `places` does not matter.
pub(super) fn offset(places: impl Iterator<Item = Vec3>) -> Option<DVec3> {
    let bounds = Bounds::around(places);
    let (center, size) = (bounds.center().as_dvec3(), f64::from(bounds.diagonal()));
    let distance = center.length();
    if !(distance > FARTHEST * size && distance.is_finite()) {
        return None;
    }
    // The size may be rounded to zero.
    let digits = size.max(1e-7 * distance).log10().floor() as i32;
    Some(DVec3::from_array(center.to_array().map(|x| rounded(x, digits))))
}

/// The nearest multiple of a power of ten.
fn rounded(x: f64, exponent: i32) -> f64 {
    let step = 10f64.powi(exponent.abs());
    if exponent < 0 { (x * step).round() / step } else { (x / step).round() * step }
}

/// Warns that a scene was moved.
pub(super) fn warning(DVec3 { x, y, z }: DVec3) -> String {
    format!(
        "the scene lies far from the origin, where positions of single precision are too coarse, and was moved by \
         ({}, {}, {}); add ({x}, {y}, {z}) to its coordinates here for those of the file",
        0.0 - x,
        0.0 - y,
        0.0 - z
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(center: Vec3, size: f32) -> Option<DVec3> {
        offset([center - 0.5 * size, center + 0.5 * size].into_iter())
    }

    #[test]
    fn only_scenes_far_from_the_origin_for_their_size_move() {
        let utm = Vec3::new(451_234.5, 5_411_111.0, 300.0);
        assert_eq!(of(utm, 2.0), Some(DVec3::new(451_235.0, 5_411_111.0, 300.0)));
        assert_eq!(of(utm, 0.0).map(|o| o.y), Some(5_411_111.0), "a size below the resolution");
        assert_eq!(of(Vec3::splat(10.0), 1e-3), Some(DVec3::splat(10.0)));
        assert_eq!(of(utm, 1e5), None);
        assert_eq!(of(Vec3::splat(500.0), 1.0), None);
        for none in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(of(none, 0.0), None);
        }
        assert_eq!(offset(std::iter::empty()), None);
    }

    #[test]
    fn the_warning_names_the_offset() {
        let text = warning(DVec3::new(451_230.0, -5.5, 0.0));
        assert!(text.contains("moved by (-451230, 5.5, 0)") && text.contains("add (451230, -5.5, 0)"), "{text}");
    }
}
