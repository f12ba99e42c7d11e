//! The LDR-FLIP difference of two pictures, as seen when they alternate on one display.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström and M. D. Fairchild, *FLIP: A Difference Evaluator for
//! Alternating Images* (HPG 2020); section and equation numbers refer to it. The filters are separated and normalized as in version
//! 1.2 of the authors' program; the tests hold its results. The maintained binding (`nv-flip`) needs a C++ compiler, and this
//! project builds with the Rust toolchain alone.
//!
//! Two pipelines meet at the end (Fig. 2): the colors after the eye's blur, and the edges and points of the lightness, each
//! compared between test and reference.

use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{color::linear_from_srgb, image::Image};
use rayon::prelude::*;

mod color;
mod filter;

/// Pixels per degree of visual angle at 0.7 m from a display 0.7 m wide with 3840 pixels (section 4).
pub const PIXELS_PER_DEGREE: f32 = 67.0;

/// Exponent of the color difference, `q_c` (section 4.1.4).
const COLOR_EXPONENT: f32 = 0.7;
/// Fraction of the largest color difference that is stretched, `p_c`.
const SMALL_COLOR_DIFFERENCE: f32 = 0.4;
/// Upper end of the stretched range, `p_t`.
const SMALL_COLOR_RANGE: f32 = 0.95;
/// Exponent of the feature difference, `q_f` (Eq. 4).
const FEATURE_EXPONENT: f32 = 0.5;

/// The error of each pixel, 0 (no visible difference) to 1, row by row.
///
/// Both pictures hold sRGB-encoded values from 0 to 1. The measure is symmetric.
///
/// # Panics
/// If the sizes differ.
pub fn flip(test: &Image, reference: &Image, pixels_per_degree: f32) -> Vec<f32> {
    assert_eq!(test.size, reference.size, "FLIP needs pictures of one size");
    let test = Perceived::through(test, pixels_per_degree);
    let reference = Perceived::through(reference, pixels_per_degree);
    let largest = color::largest_difference().powf(COLOR_EXPONENT);
    let colors = test.colors.par_iter().zip(&reference.colors).map(|(a, b)| color_error(*a, *b, largest));
    let features = test.features.par_iter().zip(&reference.features).map(|(a, b)| feature_error(*a, *b));
    colors.zip(features).map(|(color, feature)| color.powf(1.0 - feature)).collect()
}

/// A picture as an observer perceives it.
struct Perceived {
    /// Hunt-adjusted CIELab after spatial filtering.
    colors: Vec<Vec3>,
    /// Strength of edges (x) and points (y) in the lightness.
    features: Vec<Vec2>,
}

impl Perceived {
    fn through(image: &Image, pixels_per_degree: f32) -> Self {
        let opponent: Vec<Vec3> =
            image.pixels.par_iter().map(|srgb| color::opponent_from_linear(srgb.map(linear_from_srgb))).collect();
        Self {
            colors: filtered_colors(&opponent, image.width(), pixels_per_degree),
            features: features(&opponent, image.width(), pixels_per_degree),
        }
    }
}

/// Section 4.1.1 to 4.1.3. The blue-yellow channel's filter is a sum of two Gaussians, hence four channels.
fn filtered_colors(opponent: &[Vec3], width: usize, pixels_per_degree: f32) -> Vec<Vec3> {
    let kernel = filter::contrast_sensitivity(pixels_per_degree);
    let channels: Vec<Vec4> = opponent.par_iter().map(|c| c.extend(c.z)).collect();
    let filtered = filter::separable(&channels, width, &kernel, &kernel);
    filtered.par_iter().map(|c| color::perceived(Vec3::new(c.x, c.y, c.z + c.w))).collect()
}

/// Section 4.2: first and second derivatives in x and y of the lightness, from 0 to 1.
fn features(opponent: &[Vec3], width: usize, pixels_per_degree: f32) -> Vec<Vec2> {
    let kernel = filter::FeatureKernel::new(pixels_per_degree);
    let lightness: Vec<Vec4> = opponent.par_iter().map(|c| Vec4::splat((c.x + 16.0) / 116.0)).collect();
    let derivatives = filter::separable(&lightness, width, &kernel.across, &kernel.down);
    derivatives.par_iter().map(|d| Vec2::new(Vec2::new(d.x, d.z).length(), Vec2::new(d.y, d.w).length())).collect()
}

/// Section 4.1.4: the HyAB distance, compressed and remapped to 0 to 1.
fn color_error(a: Vec3, b: Vec3, largest: f32) -> f32 {
    let difference = color::hyab(a, b).powf(COLOR_EXPONENT);
    let knee = SMALL_COLOR_DIFFERENCE * largest;
    if difference < knee {
        SMALL_COLOR_RANGE * difference / knee
    } else {
        SMALL_COLOR_RANGE + (1.0 - SMALL_COLOR_RANGE) * (difference - knee) / (largest - knee)
    }
}

/// Eq. 4: the larger change of edge or point strength, 0 to 1.
fn feature_error(a: Vec2, b: Vec2) -> f32 {
    (std::f32::consts::FRAC_1_SQRT_2 * (a - b).abs().max_element()).powf(FEATURE_EXPONENT)
}

#[cfg(test)]
mod tests;
