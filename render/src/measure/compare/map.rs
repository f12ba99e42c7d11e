//! False-color maps of the error in each pixel, with a legend.

use super::{CompareError, Pair, flip, rel_mse_term};
use glam::Vec3;
use lapidary_core::{
    color::{linear_from_srgb, luminance},
    image::Image,
};
use legend::Legend;
pub use magma::{magma, magma_stops};
use rayon::prelude::*;
use serde::Deserialize;

mod diverging;
mod legend;
mod magma;

/// Which error a map shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorMap {
    /// Root of the mean of `(a-b)² / (b² + 0.01)` over the components; the mean of its squares is
    /// [`rel_mse`](super::Metrics::rel_mse).
    #[default]
    #[serde(rename = "rel")]
    Relative,
    /// Root of the mean of `(a-b)²` over the components, in scene-linear units; its root mean square is
    /// [`rmse`](super::Metrics::rmse).
    #[serde(rename = "abs")]
    Absolute,
    /// Luminance of `a` less that of `b`: above zero where the test picture is too bright.
    Signed,
    /// FLIP, whose mean is [`flip`](super::Metrics::flip).
    Flip,
}

/// A displayable error map.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMapImage {
    /// The map in the top left corner, at the size of the pictures, with the legend below. Colors are linear: an sRGB file (PNG)
    /// shows the colors of the color map.
    pub image: Image,
    /// The errors at both ends of the color bar; larger errors have the end color.
    pub range: [f32; 2],
}

/// sRGB-encoded magenta, for pixels that are not finite in either picture.
const NOT_FINITE: Vec3 = Vec3::new(1.0, 0.0, 1.0);

/// Share of pixels within the range of the bar, so that outliers do not darken the rest.
const SHARE_IN_RANGE: f32 = 0.99;

/// The error of each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorField {
    /// Kind of error.
    pub kind: ErrorMap,
    /// Title of the error.
    pub title: &'static str,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Errors row by row.
    pub errors: Vec<f32>,
    /// Which pixels are finite in both pictures; the errors of others are meaningless.
    pub finite: Vec<bool>,
    /// The error at the upper end of the colors. Signed errors start at its negative, others at 0.
    pub top: f32,
}

impl ErrorField {
    /// The errors of `test` against `reference`. The colors end at `top`, which makes several maps comparable. Without `top` they
    /// end at 1 for FLIP, and at the 99th percentile for other errors, rounded up to 1, 2 or 5 times a power of ten.
    ///
    /// # Errors
    /// Different sizes, pictures without pixels, or a `top` that is not positive.
    pub fn new(test: &Image, reference: &Image, kind: ErrorMap, top: Option<f32>) -> Result<Self, CompareError> {
        let pair = Pair::of(test, reference)?;
        let errors = kind.errors(&pair);
        let top = match (top, kind) {
            (Some(top), _) if top > 0.0 && top.is_finite() => top,
            (Some(_), _) => return Err(CompareError::Range),
            (None, ErrorMap::Flip) => 1.0,
            (None, _) => top_of_range(pair.of_finite(&errors).map(f32::abs).collect()),
        };
        Ok(Self { kind, title: kind.title(), size: test.size, errors, finite: pair.finite, top })
    }

    /// Predicted errors in scene-linear units, one value per pixel for all components. They have the colors of absolute errors;
    /// `top` as in [`Self::new`].
    ///
    /// # Errors
    /// A picture without pixels or without a finite one, or a `top` that is not positive.
    pub fn predicted(errors: &Image, top: Option<f32>) -> Result<Self, CompareError> {
        let black = Image::filled(errors.size, Vec3::ZERO);
        Ok(Self { title: "Predicted error", ..Self::new(errors, &black, ErrorMap::Absolute, top)? })
    }

    /// The sRGB-encoded colors of all pixels; magenta where one is not finite.
    pub fn colors(&self) -> Vec<Vec3> {
        let color = |(&e, &finite): (&f32, &bool)| if finite { self.kind.color(e / self.top) } else { NOT_FINITE };
        self.errors.par_iter().zip(&self.finite).map(color).collect()
    }

    /// Errors as short texts, at both ends of the colors and at even steps that divide them into `parts`.
    pub fn ticks(&self, parts: usize) -> Vec<String> {
        (0..=parts).map(|i| legend::short_number(self.top * self.kind.error_at(i as f32 / parts as f32))).collect()
    }

    /// Number of pixels in each of `bins` equal parts of the range; the outer bins include errors beyond the range.
    pub fn histogram(&self, bins: usize) -> Vec<u32> {
        let mut counts = vec![0; bins];
        for error in self.finite_errors() {
            let bin = (self.kind.place_of(error / self.top) * bins as f32) as usize;
            counts[bin.min(bins - 1)] += 1;
        }
        counts
    }

    /// Pixels that are not finite in one of the pictures.
    pub fn non_finite(&self) -> usize {
        self.finite.iter().filter(|finite| !**finite).count()
    }

    fn finite_errors(&self) -> impl Iterator<Item = f32> {
        self.errors.iter().zip(&self.finite).filter(|(_, finite)| **finite).map(|(error, _)| *error)
    }
}

/// The error of each pixel of `test` against `reference` as a picture with a legend; see [`ErrorField::new`] for `top`.
///
/// # Errors
/// As [`ErrorField::new`].
pub fn error_map(
    test: &Image,
    reference: &Image,
    kind: ErrorMap,
    top: Option<f32>,
) -> Result<ErrorMapImage, CompareError> {
    let field = ErrorField::new(test, reference, kind, top)?;
    let legend = Legend {
        kind,
        top: field.top,
        saturated: field.finite_errors().any(|error| error.abs() > field.top),
        non_finite: field.non_finite(),
    };
    let pixels = field.colors().into_iter().map(linear).collect();
    let image = legend::append(&Image { size: test.size, pixels }, &legend);
    Ok(ErrorMapImage { image, range: [field.top * kind.error_at(0.0), field.top] })
}

impl ErrorMap {
    /// All kinds in menu order.
    pub const ALL: [Self; 4] = [Self::Relative, Self::Absolute, Self::Signed, Self::Flip];

    /// Display name.
    pub fn title(self) -> &'static str {
        match self {
            Self::Relative => "Relative error",
            Self::Absolute => "Absolute error",
            Self::Signed => "Signed error",
            Self::Flip => "FLIP",
        }
    }

    /// The sRGB-encoded color of an error in units of the range's upper end.
    pub fn color(self, error: f32) -> Vec3 {
        match self {
            Self::Signed => diverging::diverging(error),
            _ => magma(error),
        }
    }

    /// The error, in units of the range's upper end, at a position of 0 to 1 in the colors.
    pub fn error_at(self, place: f32) -> f32 {
        if self == Self::Signed { 2.0 * place - 1.0 } else { place }
    }

    /// The inverse of [`Self::error_at`], cut to 0 to 1.
    fn place_of(self, error: f32) -> f32 {
        let place = if self == Self::Signed { 0.5 + 0.5 * error } else { error };
        place.clamp(0.0, 1.0)
    }

    fn errors(self, pair: &Pair) -> Vec<f32> {
        let pixels = || pair.test.pixels.par_iter().zip(&pair.reference.pixels);
        let per_pixel = |term: fn(f64, f64) -> f64| pixels().map(|(a, b)| root_mean(*a, *b, term)).collect();
        match self {
            Self::Relative => per_pixel(rel_mse_term),
            Self::Absolute => per_pixel(|a, b| (a - b).powi(2)),
            Self::Signed => pixels().map(|(a, b)| luminance(*a) - luminance(*b)).collect(),
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

/// A round number above most errors; the largest error if most are zero, or 1 if all are.
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
    use crate::measure::compare::compare;

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
    fn signed_errors_tell_too_bright_from_too_dark() {
        let (reference, brighter, darker) = (gradient(0.0), gradient(0.1), gradient(-0.1));
        let field = |test| ErrorField::new(test, &reference, ErrorMap::Signed, Some(0.25)).unwrap();
        assert!(field(&brighter).errors.iter().all(|e| (e - 0.1).abs() < 1e-5));
        assert!(field(&darker).errors.iter().all(|e| (e + 0.1).abs() < 1e-5));
        assert_eq!(field(&brighter).histogram(4), [0, 0, 800, 0]);
        assert_eq!(field(&darker).histogram(8), [0, 0, 800, 0, 0, 0, 0, 0]);
        assert_eq!(field(&darker).ticks(4), ["-0.25", "-0.125", "0", "0.125", "0.25"]);
        assert_eq!(error_map(&darker, &reference, ErrorMap::Signed, Some(0.2)).unwrap().range, [-0.2, 0.2]);
        let absolute = |test| ErrorField::new(test, &reference, ErrorMap::Absolute, Some(0.2)).unwrap().colors()[0];
        assert!((absolute(&brighter) - absolute(&darker)).length() < 1e-3, "negative control");
        assert!((field(&brighter).colors()[0] - field(&darker).colors()[0]).length() > 0.3);
    }

    #[test]
    fn histograms_count_every_finite_pixel_once() {
        let reference = gradient(0.0);
        let mut test = gradient(0.1);
        test.pixels[5] += 100.0;
        test.pixels[7].x = f32::NAN;
        let field = ErrorField::new(&test, &reference, ErrorMap::Absolute, Some(0.3)).unwrap();
        assert_eq!(field.histogram(4), [0, 798, 0, 1], "errors beyond the range lie in the last bin");
        assert_eq!(field.non_finite(), 1);
    }

    #[test]
    fn equal_pixels_are_black_changed_ones_are_not_and_nan_is_magenta() {
        let reference = gradient(0.0);
        let mut test = gradient(0.0);
        test.pixels[3] *= 2.0;
        test.pixels[35].y = f32::NAN;
        for kind in ErrorMap::ALL {
            let map = error_map(&test, &reference, kind, None).unwrap().image;
            assert_eq!(map.at(20, 19), linear(kind.color(0.0)), "{kind:?}");
            assert!(map.at(3, 0).x > map.at(20, 19).x, "{kind:?}");
            assert_eq!(map.at(35, 0), linear(NOT_FINITE), "{kind:?}");
        }
    }

    #[test]
    fn one_pixel_and_only_nan_are_mapped_and_no_pixel_is_an_error() {
        let one = Image::filled([1, 1], Vec3::ONE);
        let nan = Image::filled([1, 1], Vec3::NAN);
        let none = Image::filled([0, 0], Vec3::ONE);
        for kind in ErrorMap::ALL {
            assert!(error_map(&one, &one, kind, None).is_ok());
            assert_eq!(error_map(&nan, &one, kind, None).unwrap().image.at(0, 0), linear(NOT_FINITE));
            assert_eq!(error_map(&none, &none, kind, None), Err(CompareError::Empty));
            assert!(error_map(&one, &none, kind, None).is_err());
        }
    }
}
