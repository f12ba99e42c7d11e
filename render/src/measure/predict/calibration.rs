//! Comparison of a predicted error with the true one, pixel by pixel.

use lapidary_core::{color::luminance, image::Image};
use serde::Serialize;
use thiserror::Error;

/// Pixels of similar predicted error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Smallest and largest predicted error.
    pub predicted: [f32; 2],
    /// Number of pixels.
    pub pixels: usize,
    /// True errors not exceeded by 10, 50 and 90 % of the pixels.
    pub quantiles: [f32; 3],
    /// Share of the pixels whose true error is at most the predicted one.
    pub within: f64,
}

/// A predicted error against the true one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// Number of compared pixels: those with a predicted or true error.
    pub pixels: usize,
    /// Equally filled bins by ascending predicted error.
    pub bins: Vec<Bin>,
    /// Share of the pixels whose true error is at most the predicted one.
    pub within: f64,
    /// Spearman's rank correlation: 1 if a larger prediction always means a larger error, 0 if unrelated.
    pub rank_correlation: f64,
    /// Predicted over true error, both as root mean squares.
    pub ratio: f64,
}

/// Why errors cannot be compared.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum CalibrationError {
    /// The pictures show different views.
    #[error(
        "the predicted error has {} x {} pixels and the true one {} x {}; both must be of one view",
        predicted[0], predicted[1], truth[0], truth[1]
    )]
    SizesDiffer {
        /// Width and height of the prediction.
        predicted: [u32; 2],
        /// Width and height of the true error.
        truth: [u32; 2],
    },
    /// No pixel has an error.
    #[error("no pixel has a finite error, predicted or true; choose a view that shows a lit surface")]
    NoPixels,
}

/// Compares `predicted` luminance errors with the true luminance error of `test` from `reference`, in `bins` bins. Pixels without
/// error or not finite in any picture are left out.
///
/// # Errors
/// Pictures of different sizes, or no pixels to compare.
pub fn calibrate(
    predicted: &Image,
    test: &Image,
    reference: &Image,
    bins: usize,
) -> Result<Calibration, CalibrationError> {
    for other in [test, reference] {
        if other.size != predicted.size {
            return Err(CalibrationError::SizesDiffer { predicted: predicted.size, truth: other.size });
        }
    }
    let truth = test.pixels.iter().zip(&reference.pixels).map(|(&a, &b)| (luminance(a) - luminance(b)).abs());
    let pairs = predicted.pixels.iter().map(|&p| luminance(p)).zip(truth);
    let mut pairs: Vec<[f32; 2]> =
        pairs.map(|(p, t)| [p, t]).filter(|[p, t]| (p + t).is_finite() && p + t > 0.0).collect();
    if pairs.is_empty() {
        return Err(CalibrationError::NoPixels);
    }
    pairs.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let root_mean_square = |i: usize| pairs.iter().map(|pair| f64::from(pair[i]).powi(2)).sum::<f64>().sqrt();
    let size = pairs.len().div_ceil(bins.max(1));
    Ok(Calibration {
        pixels: pairs.len(),
        within: within(&pairs),
        rank_correlation: rank_correlation(&pairs),
        ratio: root_mean_square(0) / root_mean_square(1),
        bins: pairs.chunks(size).map(bin).collect(),
    })
}

/// Tolerance for pairs that are equal up to rounding, as a share of the prediction.
const ROUNDING: f32 = 1e-4;

fn within(pairs: &[[f32; 2]]) -> f64 {
    let count = pairs.iter().filter(|[predicted, truth]| *truth <= predicted * (1.0 + ROUNDING)).count();
    count as f64 / pairs.len() as f64
}

/// One bin of pairs sorted by predicted error.
fn bin(pairs: &[[f32; 2]]) -> Bin {
    let mut truth: Vec<f32> = pairs.iter().map(|pair| pair[1]).collect();
    truth.sort_unstable_by(f32::total_cmp);
    let quantile = |share: f64| truth[((truth.len() - 1) as f64 * share).round() as usize];
    Bin {
        predicted: [pairs[0][0], pairs[pairs.len() - 1][0]],
        pixels: pairs.len(),
        quantiles: [0.1, 0.5, 0.9].map(quantile),
        within: within(pairs),
    }
}

/// Correlation of the ranks; equal values share their mean rank. 0 if either side has one value only.
fn rank_correlation(pairs: &[[f32; 2]]) -> f64 {
    let [a, b] = [0, 1].map(|i| ranks(pairs.iter().map(|pair| pair[i]).collect()));
    let middle = 0.5 * (pairs.len() as f64 - 1.0);
    let covariance = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - middle) * (y - middle)).sum::<f64>();
    let spread = (covariance(&a, &a) * covariance(&b, &b)).sqrt();
    if spread > 0.0 { covariance(&a, &b) / spread } else { 0.0 }
}

fn ranks(values: Vec<f32>) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_unstable_by(|&i, &j| values[i].total_cmp(&values[j]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for equal in order.chunk_by(|&i, &j| values[i] == values[j]) {
        let mean = first as f64 + 0.5 * (equal.len() as f64 - 1.0);
        equal.iter().for_each(|&i| ranks[i] = mean);
        first += equal.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn gray(values: &[f32]) -> Image {
        Image { size: [values.len() as u32, 1], pixels: values.iter().map(|&v| Vec3::splat(v)).collect() }
    }

    #[test]
    fn a_prediction_twice_as_great_is_within_everywhere_and_half_as_great_nowhere() {
        let errors: Vec<f32> = (1..=100).map(|i| i as f32 * 0.01).collect();
        let scaled = |scale: f32| gray(&errors.iter().map(|e| e * scale).collect::<Vec<_>>());
        let of = |scale| calibrate(&scaled(scale), &gray(&errors), &gray(&[0.0; 100]), 10).unwrap();
        let twice = of(2.0);
        assert_eq!((twice.pixels, twice.within, twice.bins.len()), (100, 1.0, 10));
        assert!((twice.rank_correlation - 1.0).abs() < 1e-9 && (twice.ratio - 2.0).abs() < 1e-5);
        let first = twice.bins[0];
        assert_eq!(first.pixels, 10);
        assert!(first.quantiles.iter().zip([0.02, 0.06, 0.09]).all(|(q, e)| (q - e).abs() < 0.006), "{first:?}");
        assert_eq!(of(0.5).within, 0.0, "negative control");
        assert_eq!(of(1.0).within, 1.0, "equal errors count as within");
    }

    #[test]
    fn ranks_tell_order_alone() {
        let up: Vec<f32> = (0..50).map(|i| (i as f32 * 0.2).exp()).collect();
        let down: Vec<f32> = up.iter().rev().copied().collect();
        let of = |a: &[f32], b: &[f32]| {
            calibrate(&gray(a), &gray(b), &gray(&vec![0.0; a.len()]), 4).unwrap().rank_correlation
        };
        assert!((of(&up, &up) - 1.0).abs() < 1e-9 && (of(&up, &down) + 1.0).abs() < 1e-9);
        assert_eq!(of(&up, &[1.0; 50]), 0.0);
        assert_eq!(ranks(vec![3.0, 1.0, 3.0, 0.0]), [2.5, 1.0, 2.5, 0.0]);
    }

    #[test]
    fn what_is_not_finite_or_nothing_is_left_out() {
        let predicted = gray(&[1.0, f32::NAN, 0.0, 2.0]);
        let calibration = calibrate(&predicted, &gray(&[0.5, 1.0, 0.0, f32::INFINITY]), &gray(&[0.0; 4]), 3).unwrap();
        assert_eq!((calibration.pixels, calibration.bins.len()), (1, 1));
        let nothing = gray(&[0.0; 4]);
        assert_eq!(calibrate(&nothing, &nothing, &nothing, 3), Err(CalibrationError::NoPixels));
        let other = calibrate(&nothing, &nothing, &gray(&[0.0; 3]), 3).unwrap_err().to_string();
        assert!(other.contains("4 x 1") && other.contains("3 x 1"), "{other}");
    }
}
