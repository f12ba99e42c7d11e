//! Colors by direction in the real spherical harmonics of the first three bands: smooth, and nine coefficients a channel.

use crate::{simd::Vec3x8, transport::Coefficient};
use glam::{Vec3, Vec3A};
use std::ops::{Add, Mul, Sub};
use wide::f32x8;

/// Number of functions.
pub const FUNCTIONS: usize = 9;

/// Coefficients of a color by direction. The tensor product of the meshless basis with these functions has such coefficients
/// (meshless paper, 2.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonics(pub [Vec3A; FUNCTIONS]);

impl Harmonics {
    /// Of a light from a unit direction: radiance times solid angle.
    pub fn of_light(direction: Vec3, power: Vec3) -> Self {
        let power = Vec3A::from(power);
        Self(values(direction).map(|value| power * value))
    }

    /// The color in a unit direction. It may be below zero beside a bright one.
    #[inline]
    pub fn at(&self, direction: Vec3) -> Vec3 {
        self.0.iter().zip(values(direction)).map(|(&of, value)| of * value).sum::<Vec3A>().into()
    }

    /// [`Self::at`] in eight directions.
    pub fn at_x8(&self, Vec3x8 { x, y, z }: Vec3x8) -> Vec3x8 {
        let [one, two, three] = [FIRST, SECOND, THIRD].map(f32x8::splat);
        let of_pole = f32x8::splat(POLE) * (f32x8::splat(3.0) * z * z - f32x8::splat(1.0));
        let values = [
            f32x8::splat(CONSTANT),
            one * y,
            one * z,
            one * x,
            two * x * y,
            two * y * z,
            of_pole,
            two * x * z,
            three * (x * x - y * y),
        ];
        let color = |of: &Vec3A| Vec3x8::splat(Vec3::from(*of));
        let parts = self.0.iter().zip(values);
        parts.fold(Vec3x8::splat(Vec3::ZERO), |sum, (of, value)| sum + color(of) * value)
    }
}

impl Coefficient for Harmonics {
    const ZERO: Self = Self([Vec3A::ZERO; FUNCTIONS]);
}

impl Add for Harmonics {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Harmonics {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl Mul<f32> for Harmonics {
    type Output = Self;

    fn mul(self, factor: f32) -> Self {
        Self(self.0.map(|of| of * factor))
    }
}

/// Norms of the functions.
const CONSTANT: f32 = 0.282_094_8;
const FIRST: f32 = 0.488_602_5;
const SECOND: f32 = 1.092_548_4;
const THIRD: f32 = 0.546_274_2;
const POLE: f32 = 0.315_391_57;

/// The functions in a unit direction, band by band.
#[inline]
pub fn values(Vec3 { x, y, z }: Vec3) -> [f32; FUNCTIONS] {
    [
        CONSTANT,
        FIRST * y,
        FIRST * z,
        FIRST * x,
        SECOND * x * y,
        SECOND * y * z,
        POLE * (3.0 * z * z - 1.0),
        SECOND * x * z,
        THIRD * (x * x - y * y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;
    use std::f32::consts::PI;

    #[test]
    fn the_functions_are_orthonormal() {
        let directions = fibonacci_directions(20_000);
        let weight = 4.0 * PI / directions.len() as f32;
        for (i, j) in (0..FUNCTIONS).flat_map(|i| (0..FUNCTIONS).map(move |j| (i, j))) {
            let product: f32 = directions.iter().map(|&d| values(d)[i] * values(d)[j]).sum::<f32>() * weight;
            assert!((product - f32::from(u8::from(i == j))).abs() < 2e-3, "{i} {j}: {product}");
        }
    }

    #[test]
    fn a_smooth_color_comes_back_and_a_sharp_one_is_smoothed() {
        let directions = fibonacci_directions(4000);
        let weight = 4.0 * PI / directions.len() as f32;
        let projected = |color: &dyn Fn(Vec3) -> Vec3| {
            directions.iter().fold(Harmonics::ZERO, |sum, &d| sum + Harmonics::of_light(d, color(d) * weight))
        };
        let smooth = |d: Vec3| Vec3::new(1.0 + d.x, 2.0 - d.y * d.z, 0.5 * d.z);
        let found = projected(&smooth);
        for &direction in directions.iter().step_by(17) {
            assert!((found.at(direction) - smooth(direction)).length() < 0.01, "{direction}");
        }
        let eight = std::array::from_fn(|i| directions[i * 400]);
        let at_once = found.at_x8(Vec3x8::from_array(eight));
        eight.iter().enumerate().for_each(|(i, &d)| assert!((at_once.lane(i) - found.at(d)).length() < 1e-5, "{d}"));
        let sharp = projected(&|d: Vec3| if d.y > 0.9 { Vec3::ONE } else { Vec3::ZERO });
        assert!(sharp.at(Vec3::Y).x < 0.6 && sharp.at(Vec3::Y).x > 3.0 * sharp.at(Vec3::X).x.abs(), "negative control");
    }
}
