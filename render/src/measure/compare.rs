//! Differences of a test picture from a reference: metrics and error maps.
//!
//! Both pictures are scene-linear. RMSE and its relatives use these values; PSNR, SSIM and FLIP use the displayed colors
//! ([`tonemap::display`]).
//!
//! Pixels that are not finite (NaN, infinite) in either picture are counted and left out of the metrics. For the neighborhoods of
//! SSIM and FLIP such a pixel takes the other picture's value, or black if neither has one. It then hides no difference around it
//! and adds none.

use glam::Vec3;
use lapidary_core::{color::LUMINANCE, image::Image};
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub mod flip;
pub mod map;
mod ssim;
pub mod tonemap;

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum CompareError {
    /// The pictures differ in width or height.
    #[error(
        "the test picture has {} x {} pixels but the reference {} x {}; render both at the same resolution",
        test[0], test[1], reference[0], reference[1]
    )]
    SizesDiffer {
        /// Width and height of the test picture.
        test: [u32; 2],
        /// Width and height of the reference.
        reference: [u32; 2],
    },
    /// There are no pixels.
    #[error("the pictures have no pixels; render them with a width and height of at least 1")]
    Empty,
    /// The end of an error map's range is not positive.
    #[error("the range of an error map must end at a positive number")]
    Range,
    /// No pixel can be compared.
    #[error(
        "none of the {pixels} pixels is a finite number in both pictures; check that the renders finished and \
         that no light or material holds a value that is not finite"
    )]
    NothingFinite {
        /// Number of pixels.
        pixels: usize,
    },
}

/// Differences of a test picture `a` from a reference `b`. All but PSNR and SSIM grow with the difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Root of the mean of `(a-b)²` over all RGB components.
    pub rmse: f64,
    /// `||a-b|| / ||b||`. Infinite if only the reference is black: `null` in JSON.
    #[serde(with = "infinite_as_null")]
    pub rel_rmse: f64,
    /// Mean over the components of `(a-b)² / (b² + 0.01)` (Rousselle et al., *Adaptive Sampling and
    /// Reconstruction using Greedy Error Minimization*, 2011).
    pub rel_mse: f64,
    /// Peak signal-to-noise ratio in decibels of the sRGB-encoded components, not quantized, with peak 1.
    /// Infinite for pictures that look equal: `null` in JSON.
    #[serde(with = "infinite_as_null")]
    pub psnr: f64,
    /// Mean structural similarity of the luma that a display shows, 1 for equal pictures (Wang et al. 2004).
    pub ssim: f64,
    /// Mean LDR-FLIP at 67 pixels per degree, 0 for equal pictures to 1 ([`flip`]).
    pub flip: f64,
    /// Number of compared pixels.
    pub pixels: usize,
    /// Number of pixels left out because a component is not finite in either picture.
    pub non_finite_pixels: usize,
}

impl Metrics {
    /// Names accepted by [`Metrics::get`], as in JSON.
    pub const NAMES: [&str; 7] = ["rmse", "rel_rmse", "rel_mse", "psnr", "ssim", "flip", "non_finite_pixels"];

    /// A value by its name in JSON; `None` if there is no such metric.
    pub fn get(&self, name: &str) -> Option<f64> {
        Some(match name {
            "rmse" => self.rmse,
            "rel_rmse" => self.rel_rmse,
            "rel_mse" => self.rel_mse,
            "psnr" => self.psnr,
            "ssim" => self.ssim,
            "flip" => self.flip,
            "non_finite_pixels" => self.non_finite_pixels as f64,
            _ => return None,
        })
    }
}

/// Compares a test picture with a reference, both scene-linear.
///
/// # Errors
/// Different sizes, pictures without pixels, or no pixel that is finite in both.
pub fn compare(test: &Image, reference: &Image) -> Result<Metrics, CompareError> {
    let pair = Pair::of(test, reference)?;
    let non_finite_pixels = pair.non_finite_pixels();
    let pixels = pair.finite.len() - non_finite_pixels;
    if pixels == 0 {
        return Err(CompareError::NothingFinite { pixels: non_finite_pixels });
    }
    let squared_error = pair.mean(|a, b| (a - b).powi(2));
    let shown = pair.displayed();
    Ok(Metrics {
        rmse: squared_error.sqrt(),
        rel_rmse: relative(squared_error, pair.mean(|_, b| b * b)).sqrt(),
        rel_mse: pair.mean(rel_mse_term),
        psnr: -10.0 * shown.mean(|a, b| (a - b).powi(2)).log10(),
        ssim: shown.ssim(),
        flip: shown.mean_flip(),
        pixels,
        non_finite_pixels,
    })
}

/// `difference / reference`; 0 if both are 0.
fn relative(difference: f64, reference: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference / reference }
}

/// One component's contribution to relMSE.
fn rel_mse_term(a: f64, b: f64) -> f64 {
    /// Keeps dark pixels from dominating.
    const EPSILON: f64 = 0.01;
    (a - b).powi(2) / (b * b + EPSILON)
}

/// Two pictures of one size that are finite everywhere.
struct Pair {
    test: Image,
    reference: Image,
    /// Pixels that were finite in both pictures originally.
    finite: Vec<bool>,
}

impl Pair {
    fn of(test: &Image, reference: &Image) -> Result<Self, CompareError> {
        if test.size != reference.size {
            return Err(CompareError::SizesDiffer { test: test.size, reference: reference.size });
        }
        if test.pixels.is_empty() {
            return Err(CompareError::Empty);
        }
        let pixels = || test.pixels.iter().zip(&reference.pixels);
        let patched = |pick: fn((Vec3, Vec3)) -> Vec3| Image {
            size: test.size,
            pixels: pixels().map(|(&a, &b)| pick(finite_pair(a, b))).collect(),
        };
        Ok(Self {
            test: patched(|(a, _)| a),
            reference: patched(|(_, b)| b),
            finite: pixels().map(|(a, b)| a.is_finite() && b.is_finite()).collect(),
        })
    }

    fn displayed(&self) -> Self {
        Self {
            test: tonemap::display(&self.test),
            reference: tonemap::display(&self.reference),
            finite: self.finite.clone(),
        }
    }

    fn non_finite_pixels(&self) -> usize {
        self.finite.iter().filter(|finite| !**finite).count()
    }

    /// Values of the pixels that were finite in both pictures.
    fn of_finite<'a, T: Copy>(&'a self, values: &'a [T]) -> impl Iterator<Item = T> + 'a {
        values.iter().zip(&self.finite).filter(|(_, finite)| **finite).map(|(value, _)| *value)
    }

    /// Mean of `term(a, b)` over all finite components.
    fn mean(&self, term: impl Fn(f64, f64) -> f64) -> f64 {
        let pixels = self.of_finite(&self.test.pixels).zip(self.of_finite(&self.reference.pixels));
        mean(pixels.flat_map(|(a, b)| (0..3).map(move |c| (a[c].into(), b[c].into()))).map(|(a, b)| term(a, b)))
    }

    fn ssim(&self) -> f64 {
        ssim::ssim(&luma(&self.test), &luma(&self.reference), self.test.width())
    }

    fn mean_flip(&self) -> f64 {
        let errors = flip::flip(&self.test, &self.reference, flip::PIXELS_PER_DEGREE);
        mean(self.of_finite(&errors).map(f64::from))
    }
}

/// Both values if they are finite, else each other's, else black.
fn finite_pair(a: Vec3, b: Vec3) -> (Vec3, Vec3) {
    match (a.is_finite(), b.is_finite()) {
        (true, true) => (a, b),
        (true, false) => (a, a),
        (false, true) => (b, b),
        (false, false) => (Vec3::ZERO, Vec3::ZERO),
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0_usize, 0.0), |(count, sum), value| (count + 1, sum + value));
    sum / count as f64
}

/// The luma of a displayed picture.
fn luma(shown: &Image) -> Vec<f64> {
    shown.pixels.iter().map(|rgb| f64::from(rgb.dot(LUMINANCE))).collect()
}

/// JSON has no infinity.
mod infinite_as_null {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(value).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}

#[cfg(test)]
mod tests;
