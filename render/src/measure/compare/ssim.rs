//! Structural similarity: Z. Wang, A. C. Bovik, H. R. Sheikh and E. P. Simoncelli, *Image Quality Assessment: From
//! Error Visibility to Structural Similarity* (2004), with their window and constants.
//!
//! The mean includes the pixels whose window lies inside the picture, as in the authors' program and in scikit-image
//! (`gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1`); the tests hold its results. If a picture is
//! smaller than the window, all its pixels count, and it is mirrored beyond its border.

use rayon::prelude::*;

/// Standard deviation of the window in pixels.
const SIGMA: f64 = 1.5;
/// Pixels on either side of the middle: the window is 11 wide.
const RADIUS: usize = 5;
/// `(K1 L)²` for the peak `L = 1`.
const C1: f64 = 0.01 * 0.01;
/// `(K2 L)²`.
const C2: f64 = 0.03 * 0.03;

/// Means under the window of `a`, `b`, `a²`, `b²` and `ab`.
type Moments = [f64; 5];

/// Mean structural similarity of two gray pictures with values from 0 to 1, given row by row; 1 if they are equal.
///
/// # Panics
/// If the sizes differ or there are no pixels.
pub fn ssim(a: &[f64], b: &[f64], width: usize) -> f64 {
    assert_eq!(a.len(), b.len(), "SSIM needs pictures of one size");
    let height = a.len() / width;
    let products = a.par_iter().zip(b).map(|(&a, &b)| [a, b, a * a, b * b, a * b]).collect();
    let moments = windowed(products, width);
    let (columns, rows) = (inside(width), inside(height));
    let count = columns.len() * rows.len();
    let sum: f64 = rows.map(|y| moments[y * width..][columns.clone()].iter().map(similarity).sum::<f64>()).sum();
    sum / count as f64
}

/// Similarity of two windows (Eq. 13).
fn similarity(&[a, b, aa, bb, ab]: &Moments) -> f64 {
    let (variance_a, variance_b, covariance) = (aa - a * a, bb - b * b, ab - a * b);
    let luminance = (2.0 * a * b + C1) / (a * a + b * b + C1);
    luminance * (2.0 * covariance + C2) / (variance_a + variance_b + C2)
}

/// Positions along one axis whose window lies inside the picture; all positions if there are none.
fn inside(length: usize) -> std::ops::Range<usize> {
    if length > 2 * RADIUS { RADIUS..length - RADIUS } else { 0..length }
}

/// Weighted means under the window, along rows and then along columns.
fn windowed(values: Vec<Moments>, width: usize) -> Vec<Moments> {
    let height = values.len() / width;
    let weights = weights();
    let mean = |value: &dyn Fn(usize) -> Moments, at: usize, length: usize| {
        let mut sum = [0.0; 5];
        for (tap, weight) in weights.iter().enumerate() {
            let value = value(mirrored(at as isize + tap as isize - RADIUS as isize, length));
            sum.iter_mut().zip(value).for_each(|(sum, v)| *sum += weight * v);
        }
        sum
    };
    let pixel = |i: usize| (i % width, i / width);
    let count = values.len();
    let rows: Vec<Moments> =
        (0..count).into_par_iter().map(|i| mean(&|x| values[pixel(i).1 * width + x], pixel(i).0, width)).collect();
    (0..count).into_par_iter().map(|i| mean(&|y| rows[y * width + pixel(i).0], pixel(i).1, height)).collect()
}

fn weights() -> [f64; 2 * RADIUS + 1] {
    let gaussian = |tap: usize| (-0.5 * ((tap as f64 - RADIUS as f64) / SIGMA).powi(2)).exp();
    let weights: [f64; 2 * RADIUS + 1] = std::array::from_fn(gaussian);
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

/// The index mirrored from a position beyond the border; the border pixel repeats.
fn mirrored(position: isize, length: usize) -> usize {
    let period = 2 * length as isize;
    let folded = position.rem_euclid(period);
    folded.min(period - 1 - folded) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(x: f64, y: f64) -> f64 {
        0.5 + 0.3 * (0.31 * x + 0.17 * y).sin() + 0.1 * (0.05 * x * y).cos()
    }

    fn test(x: f64, y: f64) -> f64 {
        reference(x, y) + 0.1 * (1.7 * x - 0.9 * y).sin()
    }

    fn picture([width, height]: [usize; 2], value: fn(f64, f64) -> f64) -> Vec<f64> {
        (0..width * height).map(|i| value((i % width) as f64, (i / width) as f64)).collect()
    }

    /// Values from scikit-image 0.26 for the same formulas.
    #[test]
    fn values_are_those_of_scikit_image() {
        for (size, expected) in [
            ([40, 30], 0.835_987_822_125_584_1),
            ([64, 17], 0.848_922_077_590_541_1),
            ([11, 11], 0.905_013_184_536_838_8),
        ] {
            let found = ssim(&picture(size, test), &picture(size, reference), size[0]);
            assert!((found - expected).abs() < 1e-9, "{size:?}: {found}, not {expected}");
        }
    }

    #[test]
    fn equal_pictures_are_similar_and_inverted_ones_are_not() {
        let a = picture([30, 20], reference);
        let inverted: Vec<f64> = a.iter().map(|v| 1.0 - v).collect();
        assert!((ssim(&a, &a, 30) - 1.0).abs() < 1e-12);
        assert!(ssim(&a, &inverted, 30) < 0.0, "negative control");
    }

    #[test]
    fn pictures_smaller_than_the_window_are_mirrored() {
        assert!((ssim(&[0.3], &[0.3], 1) - 1.0).abs() < 1e-12);
        let known = (2.0 * 0.3 * 0.6 + C1) / (0.3 * 0.3 + 0.6 * 0.6 + C1);
        assert!((ssim(&[0.3; 12], &[0.6; 12], 4) - known).abs() < 1e-9);
        let order: Vec<usize> = (-3..6).map(|p| mirrored(p, 3)).collect();
        assert_eq!(order, [2, 1, 0, 0, 1, 2, 2, 1, 0]);
    }
}
