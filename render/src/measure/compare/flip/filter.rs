//! The filters of FLIP, each as two passes of one-dimensional kernels over four channels.

use glam::Vec4;
use rayon::prelude::*;
use std::f32::consts::PI;

/// One weight per channel for each tap; the length is odd and the middle tap is the center pixel.
pub(super) type Kernel = Vec<Vec4>;

/// Gaussians `a sqrt(π/b) exp(-π² x²/b)` of the contrast sensitivity functions, x in degrees (Table 1): the
/// achromatic and the red-green channel, then the two terms of blue-yellow.
const AMPLITUDE: Vec4 = Vec4::new(1.0, 1.0, 34.1, 13.5);
const SCALE: Vec4 = Vec4::new(0.0047, 0.0053, 0.04, 0.025);

/// Width of the feature detectors in degrees, `w` (section 4.2).
const FEATURE_WIDTH: f32 = 0.082;

/// The kernel of one pass of the spatial filter for the channels Y, Cx, Cz, Cz; the sum of the last two is
/// the filtered Cz.
pub(super) fn contrast_sensitivity(pixels_per_degree: f32) -> Kernel {
    let widest_sigma = (SCALE.max_element() / (2.0 * PI * PI)).sqrt();
    let offsets = taps((3.0 * widest_sigma * pixels_per_degree).ceil());
    // The amplitude is split evenly between the two passes; Y and Cx are normalized anyway.
    let amplitude = (AMPLITUDE * (Vec4::splat(PI) / SCALE).map(f32::sqrt)).map(f32::sqrt);
    let weight = |offset: f32| {
        let degrees = offset / pixels_per_degree;
        amplitude * (-PI * PI * degrees * degrees / SCALE).exp()
    };
    let kernel: Kernel = offsets.map(weight).collect();
    let sum: Vec4 = kernel.iter().sum();
    // Two-dimensional sums are squares of one-dimensional ones, and both terms of Cz together make one filter.
    let norm_z = sum.z.hypot(sum.w);
    let norm = Vec4::new(sum.x, sum.y, norm_z, norm_z);
    kernel.into_iter().map(|weight| weight / norm).collect()
}

/// Detectors of edges and points: derivatives of a Gaussian along one axis, the Gaussian along the other.
/// The channels are d/dx, d²/dx², d/dy, d²/dy².
pub(super) struct FeatureKernel {
    /// The pass along rows.
    pub across: Kernel,
    /// The pass along columns.
    pub down: Kernel,
}

impl FeatureKernel {
    pub(super) fn new(pixels_per_degree: f32) -> Self {
        let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let radius = (3.0 * sigma).ceil();
        let gaussian = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
        let smooth = normalized(taps(radius).map(gaussian));
        let first = normalized(taps(radius).map(|x| -x * gaussian(x)));
        let second = normalized(taps(radius).map(|x| (x * x / (sigma * sigma) - 1.0) * gaussian(x)));
        let channels = || first.iter().zip(&second).zip(&smooth).map(|((&first, &second), &g)| (first, second, g));
        Self {
            across: channels().map(|(first, second, g)| Vec4::new(first, second, g, g)).collect(),
            down: channels().map(|(first, second, g)| Vec4::new(g, g, first, second)).collect(),
        }
    }
}

fn taps(radius: f32) -> impl Iterator<Item = f32> {
    let radius = radius as i32;
    (-radius..=radius).map(|offset| offset as f32)
}

/// Scales the positive weights to a sum of 1 and the negative ones to -1.
fn normalized(weights: impl Iterator<Item = f32>) -> Vec<f32> {
    let weights: Vec<f32> = weights.collect();
    let positive: f32 = weights.iter().filter(|&&w| w > 0.0).sum();
    let negative: f32 = -weights.iter().filter(|&&w| w < 0.0).sum::<f32>();
    let scale = |w: f32| match w {
        w if w > 0.0 => w / positive,
        w if w < 0.0 => w / negative,
        zero => zero,
    };
    weights.into_iter().map(scale).collect()
}

/// Filters along rows, then along columns; beyond the border the nearest pixel repeats.
pub(super) fn separable(pixels: &[Vec4], width: usize, across: &Kernel, down: &Kernel) -> Vec<Vec4> {
    if pixels.is_empty() {
        return Vec::new();
    }
    let height = pixels.len() / width;
    let mut rows = vec![Vec4::ZERO; pixels.len()];
    rows.par_chunks_mut(width).zip(pixels.par_chunks(width)).for_each(|(output, input)| {
        for (x, sum) in output.iter_mut().enumerate() {
            *sum = across.iter().enumerate().map(|(tap, weight)| weight * input[reached(x, tap, across, width)]).sum();
        }
    });
    let mut filtered = vec![Vec4::ZERO; pixels.len()];
    filtered.par_chunks_mut(width).enumerate().for_each(|(y, output)| {
        for (tap, &weight) in down.iter().enumerate() {
            let row = reached(y, tap, down, height) * width;
            for (sum, value) in output.iter_mut().zip(&rows[row..row + width]) {
                *sum += weight * value;
            }
        }
    });
    filtered
}

/// The index that a tap of a kernel centered at `center` reads, clamped to `0..count`.
fn reached(center: usize, tap: usize, kernel: &Kernel, count: usize) -> usize {
    (center + tap).saturating_sub(kernel.len() / 2).min(count - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_picture_keeps_its_colour_and_has_no_features() {
        let pixels = vec![Vec4::splat(0.7); 15];
        let kernel = contrast_sensitivity(67.0);
        let filtered = separable(&pixels, 5, &kernel, &kernel);
        assert!(filtered.iter().all(|c| (c.x - 0.7).abs() < 1e-5 && (c.y - 0.7).abs() < 1e-5));
        assert!(filtered.iter().all(|c| (c.z + c.w - 0.7).abs() < 1e-5));
        let kernel = FeatureKernel::new(67.0);
        assert!(separable(&pixels, 5, &kernel.across, &kernel.down).iter().all(|d| d.length() < 1e-5));
    }

    #[test]
    fn a_step_is_an_edge_of_its_height_in_its_direction() {
        let pixels: Vec<Vec4> = (0..40 * 40).map(|i| Vec4::splat(if i % 40 < 20 { 0.0 } else { 0.5 })).collect();
        let kernel = FeatureKernel::new(67.0);
        let edges = separable(&pixels, 40, &kernel.across, &kernel.down);
        let strongest = edges.iter().map(|d| d.x.abs()).fold(0.0, f32::max);
        assert!((strongest - 0.5).abs() < 1e-5, "{strongest}");
        assert!(edges.iter().all(|d| d.z.abs() < 1e-5), "there is no vertical change");
    }
}
