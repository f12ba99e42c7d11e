//! Display color of a pixel in each view mode.
//!
//! Twin of `shaders/display_pass.wgsl`. Exposure and tone curve apply only to light; quantities of other modes look the same at any
//! exposure, so they can be read off.

use crate::{measure::compare::map::magma, post::Post, view_mode::ViewMode};
use glam::Vec3;
use lapidary_core::color::srgb_from_linear;

/// The sRGB-encoded color of a pixel's `value`, each channel 0 to 1. Counts of at least `count_top` have magma's last color. NaN
/// becomes magenta.
pub fn display_pixel(mode: ViewMode, post: &Post, count_top: f32, value: Vec3) -> Vec3 {
    if value.is_nan() {
        return Vec3::new(1.0, 0.0, 1.0);
    }
    match mode {
        ViewMode::Shaded | ViewMode::BasisLevel | ViewMode::Gloss => post.display(value),
        ViewMode::Albedo => value.map(srgb_from_linear),
        ViewMode::Normals | ViewMode::Roughness | ViewMode::BasisFunction | ViewMode::BasisCoefficients => {
            value.clamp(Vec3::ZERO, Vec3::ONE)
        }
        ViewMode::VisibilityCut | ViewMode::MergedCut | ViewMode::BrdfEvaluations => magma(value.x / count_top),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_light_is_exposed() {
        let (dark, bright) = (Post::default(), Post { exposure: 2.0, ..Post::default() });
        let value = Vec3::new(0.2, 0.1, 0.05);
        for mode in ViewMode::ALL {
            let [a, b] = [&dark, &bright].map(|post| display_pixel(mode, post, 512.0, value));
            assert_eq!(a == b, !mode.is_light(), "{mode:?}");
        }
    }

    #[test]
    fn known_values() {
        let show = |mode, value: f32| display_pixel(mode, &Post::default(), 512.0, Vec3::splat(value));
        assert!((show(ViewMode::Albedo, 0.214_041) - 0.5).length() < 1e-5);
        assert_eq!(show(ViewMode::Roughness, 0.25), Vec3::splat(0.25));
        assert_eq!(show(ViewMode::Normals, 1.5), Vec3::ONE);
        assert_eq!(show(ViewMode::MergedCut, 512.0), show(ViewMode::BrdfEvaluations, 9999.0));
        assert_eq!(show(ViewMode::MergedCut, 256.0), magma(0.5));
        for mode in ViewMode::ALL {
            assert_eq!(show(mode, f32::NAN), Vec3::new(1.0, 0.0, 1.0), "{mode:?}");
        }
    }
}
