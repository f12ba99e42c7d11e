//! The tone map shared by metrics and previews: exposure 1, clamped, sRGB, no curve.
//!
//! Metrics under a curve would depend on its design. Without one, any other tool can recompute them from a PNG.

use lapidary_core::{color::srgb_from_linear, image::Image};
use rayon::prelude::*;

/// The sRGB-encoded values, 0 to 1, that a display shows for a scene-linear picture; NaN becomes black.
///
/// The result holds *encoded* pixels: writing it as PNG would encode them again.
pub fn display(image: &Image) -> Image {
    let pixels = image.pixels.par_iter().map(|rgb| rgb.map(srgb_from_linear)).collect();
    Image { size: image.size, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn middle_gray_is_encoded_and_the_rest_is_clamped() {
        let shown =
            display(&Image { size: [2, 1], pixels: vec![Vec3::splat(0.214_041), Vec3::new(-1.0, 7.0, f32::NAN)] });
        assert!((shown.pixels[0] - Vec3::splat(0.5)).length() < 1e-5);
        assert!((shown.pixels[1] - Vec3::Y).length() < 1e-6);
    }
}
