//! A table blurred over half vectors: the mean over a normal distribution in the plane of their x and y.

use super::{Level, MEASURED_SIZE, halved};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// Entries along each axis; a blurred table needs fewer.
const SIZE: [usize; 3] = [60, 45, 45];
/// Number of levels; each is twice as wide as the one before.
const LEVELS: usize = 7;
/// Width of the first level.
const FIRST: f32 = 0.01;
/// Samples of the distribution along radius and angle.
const SAMPLES: [usize; 2] = [24, 16];

/// The blurred levels of a measured table.
pub fn levels(measured: &Level) -> Vec<Level> {
    let coarse = coarser(measured);
    let level = |i: usize| blurred(&coarse, (FIRST * 2.0_f32.powi(i as i32)).powi(2));
    (0..LEVELS).map(level).collect()
}

/// Means over the difference-vector bins of a blurred level, for each angle of the half vector.
fn coarser(measured: &Level) -> Vec<[f32; 3]> {
    let [n_h, n_d, n_p] = MEASURED_SIZE;
    let [_, coarse_d, coarse_p] = SIZE;
    let (step_d, step_p) = (n_d / coarse_d, n_p / coarse_p);
    let mut sums = vec![[0.0; 3]; n_h * coarse_d * coarse_p];
    let share = 1.0 / (step_d * step_p) as f32;
    for (index, entry) in measured.entries.iter().enumerate() {
        let (h, d, p) = (index / (n_d * n_p), index / n_p % n_d, index % n_p);
        let sum = &mut sums[(h * coarse_d + d / step_d) * coarse_p + p / step_p];
        (0..3).for_each(|c| sum[c] += share * entry[c]);
    }
    sums
}

fn blurred(coarse: &[[f32; 3]], spread: f32) -> Level {
    let [n_h, n_d, n_p] = SIZE;
    let row = n_d * n_p;
    let blurred_row = |h: usize| {
        let weights = weights(middle(h, n_h), spread);
        let mut sums = vec![[0.0; 3]; row];
        for (from, &weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            for (sum, entry) in sums.iter_mut().zip(&coarse[from * row..][..row]) {
                (0..3).for_each(|c| sum[c] += weight * entry[c]);
            }
        }
        sums.into_iter().map(halved).collect::<Vec<_>>()
    };
    let entries = (0..n_h).into_par_iter().flat_map_iter(blurred_row).collect();
    Level { size: SIZE, spread, entries }
}

/// Angle of a half vector at the center of a bin.
fn middle(bin: usize, bins: usize) -> f32 {
    FRAC_PI_2 * ((bin as f32 + 0.5) / bins as f32).powi(2)
}

/// Weights of the measured angles in the mean around one. Angles beyond the hemisphere do not count.
fn weights(theta: f32, spread: f32) -> [f32; MEASURED_SIZE[0]] {
    let [radii, turns] = SAMPLES;
    let mut weights = [0.0; MEASURED_SIZE[0]];
    let last = MEASURED_SIZE[0] - 1;
    for sample in 0..radii * turns {
        let share = ((sample / turns) as f32 + 0.5) / radii as f32;
        let radius = (-spread * (1.0 - share).ln()).sqrt();
        let (sin, cos) = (PI * ((sample % turns) as f32 + 0.5) / turns as f32).sin_cos();
        let sin_h = (theta.sin() + radius * cos).hypot(radius * sin);
        if sin_h < 1.0 {
            let place = (sin_h.asin() / FRAC_PI_2).sqrt() * MEASURED_SIZE[0] as f32 - 0.5;
            let place = place.clamp(0.0, last as f32);
            let low = (place as usize).min(last - 1);
            weights[low] += 1.0 - (place - low as f32);
            weights[low + 1] += place - low as f32;
        }
    }
    let sum: f32 = weights.iter().sum();
    weights.map(|weight| weight / sum.max(1.0))
}
