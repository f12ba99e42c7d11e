//! A blurred environment, as a defocused background.

use super::{Environment, texel_direction, texel_solid_angle};
use crate::image::Image;
use glam::Vec3;
use rayon::prelude::*;

/// Size of the result: a blurred map needs no more.
const SIZE: [u32; 2] = [256, 128];
/// Largest size of the summed map; larger maps are reduced first.
const SOURCE: [u32; 2] = [128, 64];
/// Smallest blur in radians: the size of one source texel.
const LEAST: f32 = 0.05;

impl Environment {
    /// The mean around every direction, weighted by a von Mises-Fisher lobe of standard deviation `width` radians per
    /// tangent axis.
    pub fn blurred(&self, width: f32) -> Self {
        let kappa = width.clamp(LEAST, 3.0).powi(-2);
        let source = reduced(&self.map);
        let samples: Vec<(Vec3, Vec3, f32)> = texels(SOURCE)
            .zip(&source.pixels)
            .map(|((x, y), &l)| (texel_direction(x, y, SOURCE), l, texel_solid_angle(y, SOURCE)))
            .collect();
        let mean = |(x, y): (u32, u32)| {
            let d = texel_direction(x, y, SIZE);
            let (sum, weight) = samples.iter().fold((Vec3::ZERO, 0.0), |(sum, weight), &(s, l, area)| {
                let w = area * (kappa * (d.dot(s) - 1.0)).exp();
                (sum + l * w, weight + w)
            });
            sum / weight
        };
        let targets: Vec<(u32, u32)> = texels(SIZE).collect();
        let pixels = targets.into_par_iter().map(mean).collect();
        Self::new(self.name.clone(), Image { size: SIZE, pixels })
    }
}

fn texels([width, height]: [u32; 2]) -> impl Iterator<Item = (u32, u32)> {
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// The map reduced to `SOURCE`: means of the texels that each new one covers.
fn reduced(map: &Image) -> Image {
    let range = |i: u32, to: u32, from: usize| {
        let at = |i: u32| (i as usize * from) / to as usize;
        at(i)..at(i + 1).max(at(i) + 1)
    };
    Image::from_fn(SOURCE, |x, y| {
        let (rows, columns) = (range(y, SOURCE[1], map.height()), range(x, SOURCE[0], map.width()));
        let count = rows.len() * columns.len();
        let sum: Vec3 = rows.flat_map(|r| columns.clone().map(move |c| map.at(c, r))).sum();
        sum / count as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_and_a_lamp_spreads_without_gaining() {
        let constant = Environment::new(String::new(), Image::filled([37, 20], Vec3::splat(2.0)));
        assert!(constant.blurred(0.3).map.pixels.iter().all(|p| (*p - 2.0).length() < 1e-4));
        let mut lamp = Environment::new(String::new(), Image::filled([128, 64], Vec3::ZERO));
        lamp.map.pixels[32 * 128 + 64] = Vec3::splat(100.0);
        let energy = |e: &Environment| -> f32 {
            let [w, _] = e.map.size;
            let area = |i: usize| texel_solid_angle(i as u32 / w, e.map.size);
            e.map.pixels.iter().enumerate().map(|(i, p)| p.x * area(i)).sum()
        };
        let blurred = lamp.blurred(0.2);
        assert!((energy(&blurred) / energy(&lamp) - 1.0).abs() < 0.03);
        assert!(blurred.radiance(Vec3::Z).x > 5.0 * blurred.radiance(Vec3::new(0.4, 0.0, 0.9).normalize()).x);
    }
}
