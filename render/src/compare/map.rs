//! False-colour maps of the error in each pixel, with a legend.

use super::{CompareError, Pair, flip, rel_mse_term};
use glam::Vec3;
use lapidary_core::{color::linear_from_srgb, image::Image};
use legend::Legend;
pub use magma::{magma, magma_stops};
use rayon::prelude::*;

mod font;
mod legend;
mod magma;

/// Which error a map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorMap {
    /// Root of the mean of `(a-b)² / (b² + 0.01)` over the components; the mean of its squares is
    /// [`rel_mse`](super::Metrics::rel_mse).
    Relative,
    /// Root of the mean of `(a-b)²` over the components, in scene-linear units; its root mean square is
    /// [`rmse`](super::Metrics::rmse).
    Absolute,
    /// FLIP, whose mean is [`flip`](super::Metrics::flip).
    Flip,
}

/// A displayable error map.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMapImage {
    /// The map in the top left corner, at the size of the pictures, and the legend below it. Colours are linear: what
    /// writes a picture as sRGB (PNG) shows those of the colour map.
    pub image: Image,
    /// The errors at the two ends of the colour bar; errors above have the colour of the end.
    pub range: [f32; 2],
}

/// sRGB-encoded magenta, for pixels that are not finite in either picture.
const NOT_FINITE: Vec3 = Vec3::new(1.0, 0.0, 1.0);

/// This share of the pixels lies within the range of the bar, so that a few outliers do not darken the rest.
const SHARE_IN_RANGE: f32 = 0.99;

/// The error of each pixel of `test` against `reference`, in the colours of magma. The range ends at `top`, which
/// makes several maps comparable; without it at 1 for FLIP and otherwise at the 99th percentile of the errors, rounded
/// up to 1, 2 or 5 times a power of ten.
///
/// # Errors
/// Sizes that differ, pictures without pixels, and a `top` that is not positive.
pub fn error_map(
    test: &Image,
    reference: &Image,
    kind: ErrorMap,
    top: Option<f32>,
) -> Result<ErrorMapImage, CompareError> {
    let pair = Pair::of(test, reference)?;
    let errors = kind.errors(&pair);
    let top = match (top, kind) {
        (Some(top), _) if top > 0.0 && top.is_finite() => top,
        (Some(_), _) => return Err(CompareError::Range),
        (None, ErrorMap::Flip) => 1.0,
        (None, ErrorMap::Relative | ErrorMap::Absolute) => top_of_range(pair.of_finite(&errors).collect()),
    };
    let color = |(&error, &finite): (&f32, &bool)| linear(if finite { magma(error / top) } else { NOT_FINITE });
    let pixels = errors.par_iter().zip(&pair.finite).map(color).collect();
    let legend = Legend {
        title: kind.title(),
        top,
        saturated: pair.of_finite(&errors).any(|error| error > top),
        non_finite: pair.non_finite_pixels(),
    };
    let image = legend::append(&Image { size: test.size, pixels }, &legend);
    Ok(ErrorMapImage { image, range: [0.0, top] })
}

impl ErrorMap {
    fn title(self) -> &'static str {
        match self {
            Self::Relative => "RELATIVE ERROR",
            Self::Absolute => "ABSOLUTE ERROR",
            Self::Flip => "FLIP",
        }
    }

    fn errors(self, pair: &Pair) -> Vec<f32> {
        let per_pixel = |term: fn(f64, f64) -> f64| {
            let pixels = pair.test.pixels.par_iter().zip(&pair.reference.pixels);
            pixels.map(|(a, b)| root_mean(*a, *b, term)).collect()
        };
        match self {
            Self::Relative => per_pixel(rel_mse_term),
            Self::Absolute => per_pixel(|a, b| (a - b).powi(2)),
            Self::Flip => {
                let shown = pair.displayed();
                flip::flip(&shown.test, &shown.reference, flip::PIXELS_PER_DEGREE)
            }
        }
    }
}

/// Root of the mean over the components of a squared error.
fn root_mean(a: Vec3, b: Vec3, squared_error: fn(f64, f64) -> f64) -> f32 {
    let sum: f64 = (0..3).map(|c| squared_error(a[c].into(), b[c].into())).sum();
    (sum / 3.0).sqrt() as f32
}

/// A round number with most errors below it; the largest error if most are nil, 1 if all are.
fn top_of_range(mut errors: Vec<f32>) -> f32 {
    errors.sort_unstable_by(f32::total_cmp);
    let Some(last) = errors.len().checked_sub(1) else { return 1.0 };
    let typical = errors[(SHARE_IN_RANGE * last as f32) as usize];
    let largest = errors[last];
    [typical, largest].into_iter().find(|&error| error > 0.0).map_or(1.0, round_up)
}

/// The next number of the form 1, 2 or 5 times a power of ten.
fn round_up(value: f32) -> f32 {
    let value = f64::from(value);
    let decade = 10.0_f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|step| step * decade);
    // The largest finite error has no larger round number.
    let rounded = steps.into_iter().find(|&step| step >= value * (1.0 - 1e-6)).unwrap_or(10.0 * decade);
    rounded.clamp(f32::MIN_POSITIVE.into(), f32::MAX.into()) as f32
}

fn linear(srgb: Vec3) -> Vec3 {
    srgb.map(linear_from_srgb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::compare;

    const KINDS: [ErrorMap; 3] = [ErrorMap::Relative, ErrorMap::Absolute, ErrorMap::Flip];

    fn gradient(offset: f32) -> Image {
        Image::from_fn([40, 20], |x, y| Vec3::new(x as f32 / 40.0, y as f32 / 20.0, 0.3) + offset)
    }

    #[test]
    fn ranges_are_round_numbers() {
        for (value, rounded) in [(0.011, 0.02), (0.02, 0.02), (0.3, 0.5), (0.7, 1.0), (1.0, 1.0), (23.0, 50.0)] {
            assert!((round_up(value) - rounded).abs() < 1e-6 * rounded, "{value}");
        }
        assert!(round_up(f32::MAX).is_finite() && round_up(1e-45) > 0.0);
        assert_eq!(top_of_range(vec![]), 1.0);
        assert_eq!(top_of_range(vec![0.0; 9]), 1.0);
        let mut errors = vec![0.0; 999];
        errors.push(3.0);
        assert_eq!(top_of_range(errors), 5.0, "a single wrong pixel is shown");
    }

    #[test]
    fn an_outlier_saturates_and_leaves_the_others_visible() {
        let reference = gradient(0.0);
        let mut test = gradient(0.1);
        test.pixels[33].x += 1e6;
        let map = error_map(&test, &reference, ErrorMap::Absolute, None).unwrap();
        assert!((map.range[1] - 0.1).abs() < 1e-6 || (map.range[1] - 0.2).abs() < 1e-6);
        assert_eq!(map.image.at(33, 0), linear(magma(1.0)));
    }

    #[test]
    fn a_given_top_makes_maps_comparable() {
        let reference = gradient(0.0);
        let map = |offset, top| error_map(&gradient(offset), &reference, ErrorMap::Absolute, top);
        let pixel = |offset, top| map(offset, top).unwrap().image.at(20, 10);
        assert_eq!(map(0.1, Some(0.4)).unwrap().range, [0.0, 0.4]);
        assert!(pixel(0.1, Some(0.4)).x < pixel(0.2, Some(0.4)).x);
        assert!((pixel(0.1, None) - pixel(0.2, None)).length() < 1e-3, "negative control: each fills its own range");
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(map(0.1, Some(bad)), Err(CompareError::Range));
        }
    }

    #[test]
    fn errors_per_pixel_agree_with_the_metrics() {
        let (test, reference) = (gradient(0.07), gradient(0.0));
        let metrics = compare(&test, &reference).unwrap();
        let pair = Pair::of(&test, &reference).unwrap();
        let mean = |kind: ErrorMap, power: i32| {
            kind.errors(&pair).iter().map(|&e| f64::from(e).powi(power)).sum::<f64>() / 800.0
        };
        assert!((mean(ErrorMap::Absolute, 2).sqrt() - metrics.rmse).abs() < 1e-6);
        assert!((mean(ErrorMap::Relative, 2) - metrics.rel_mse).abs() < 1e-6);
        assert!((mean(ErrorMap::Flip, 1) - metrics.flip).abs() < 1e-6);
    }

    #[test]
    fn equal_pixels_are_black_changed_ones_are_not_and_nan_is_magenta() {
        let reference = gradient(0.0);
        let mut test = gradient(0.0);
        test.pixels[3] *= 2.0;
        test.pixels[35].y = f32::NAN;
        for kind in KINDS {
            let map = error_map(&test, &reference, kind, None).unwrap().image;
            assert_eq!(map.at(20, 19), linear(magma(0.0)), "{kind:?}");
            assert!(map.at(3, 0).x > map.at(20, 19).x, "{kind:?}");
            assert_eq!(map.at(35, 0), linear(NOT_FINITE), "{kind:?}");
        }
    }

    #[test]
    fn one_pixel_and_only_nan_are_mapped_and_no_pixel_is_an_error() {
        let one = Image::filled([1, 1], Vec3::ONE);
        let nan = Image::filled([1, 1], Vec3::NAN);
        let none = Image::filled([0, 0], Vec3::ONE);
        for kind in KINDS {
            assert!(error_map(&one, &one, kind, None).is_ok());
            assert_eq!(error_map(&nan, &one, kind, None).unwrap().image.at(0, 0), linear(NOT_FINITE));
            assert_eq!(error_map(&none, &none, kind, None), Err(CompareError::Empty));
            assert!(error_map(&one, &none, kind, None).is_err());
        }
    }
}
