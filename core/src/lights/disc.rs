//! Disc of directions of a directional light with an extent.

use super::{Emission, Light};
use crate::simd::{Lanes, Vec3x8};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_4, PI, TAU};

/// A disc of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Unit direction to its center.
    pub axis: Vec3,
    /// Unit vector at right angles to the axis.
    pub right: Vec3,
    /// Unit vector at right angles to both.
    pub up: Vec3,
    /// One minus the cosine of the angle from its center to its rim.
    pub height: f32,
}

impl Disc {
    /// The disc of a light; `None` for parallel light and other lights, and if target and position coincide.
    pub fn of(light: &Light) -> Option<Self> {
        let Emission::Directional { angle_degrees } = light.emission else { return None };
        let axis = -light.forward().filter(|_| angle_degrees > 0.0)?;
        let (right, up) = axis.any_orthonormal_pair();
        Some(Self { axis, right, up, height: 2.0 * (0.25 * angle_degrees).to_radians().sin().powi(2) })
    }

    /// Solid angle in steradians.
    pub fn solid_angle(&self) -> f32 {
        TAU * self.height
    }

    /// Radiance of the disc over the irradiance of a surface that faces it.
    pub fn radiance_of_irradiance(&self) -> f32 {
        1.0 / (PI * self.sin_sq())
    }

    /// The unit direction at `u` in the unit square, uniform per solid angle. Squares around the center map to discs
    /// around the center (Shirley and Chiu 1997).
    pub fn direction(&self, u: Vec2) -> Vec3 {
        let at = concentric(2.0 * u - 1.0);
        let height = at.length_squared() * self.height;
        let spread = (self.height * (2.0 - height)).max(0.0).sqrt();
        self.axis * (1.0 - height) + (self.right * at.x + self.up * at.y) * spread
    }

    /// [`Self::direction`] for eight points.
    #[inline(always)]
    pub fn directions<L: Lanes>(&self, [u, v]: [L; 2]) -> Vec3x8<L> {
        let one = L::splat(1.0);
        let [x, y] = concentric_x8([u + u - one, v + v - one]);
        let height = (x * x + y * y) * L::splat(self.height);
        let spread = (L::splat(self.height) * (L::splat(2.0) - height)).at_least(0.0).sqrt();
        Vec3x8::splat(self.axis) * (one - height)
            + Vec3x8::splat(self.right) * (x * spread)
            + Vec3x8::splat(self.up) * (y * spread)
    }

    /// Whether it contains a unit direction.
    pub fn contains(&self, direction: Vec3) -> bool {
        self.axis.dot(direction) > 0.0 && self.axis.cross(direction).length_squared() <= self.sin_sq()
    }

    /// Whether any part of it may be above a plane with this normal.
    pub fn may_be_above(&self, normal: Vec3) -> bool {
        self.axis.dot(normal) > -self.sine()
    }

    /// Sine of the angle from its center to its rim.
    pub fn sine(&self) -> f32 {
        self.sin_sq().sqrt()
    }

    /// Squared sine of the angle from its center to its rim, which is at most 90 degrees.
    fn sin_sq(&self) -> f32 {
        self.height * (2.0 - self.height)
    }
}

/// Point of the unit disc for a point of the square from -1 to 1.
fn concentric(square: Vec2) -> Vec2 {
    let Vec2 { x, y } = square;
    let (radius, angle) = match () {
        () if x == 0.0 && y == 0.0 => return Vec2::ZERO,
        () if x.abs() > y.abs() => (x, FRAC_PI_4 * (y / x)),
        () => (y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * (x / y)),
    };
    radius * Vec2::from_angle(angle)
}

/// [`concentric`] for eight points.
#[inline(always)]
fn concentric_x8<L: Lanes>([x, y]: [L; 2]) -> [L; 2] {
    let is_wide = x.abs().simd_gt(y.abs());
    let (radius, other) = (is_wide.select(x, y), is_wide.select(y, x));
    let is_middle = radius.abs().simd_le(L::splat(0.0));
    let angle = L::splat(FRAC_PI_4) * (other / is_middle.select(L::splat(1.0), radius));
    // Taylor polynomials, for angles up to 45 degrees.
    let sq = angle * angle;
    let [mut cos, mut sin] = [L::splat(1.0 / 40_320.0), L::splat(1.0 / 362_880.0)];
    for (even, odd) in [(1.0 / 720.0, 1.0 / 5040.0), (1.0 / 24.0, 1.0 / 120.0), (0.5, 1.0 / 6.0), (1.0, 1.0)] {
        (cos, sin) = (L::splat(even) - sq * cos, L::splat(odd) - sq * sin);
    }
    let sin = angle * sin;
    let (along, across) = (radius * cos, radius * sin);
    [is_wide.select(along, across), is_wide.select(across, along)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use wide::f32x8;

    fn disc(angle_degrees: f32) -> Disc {
        let emission = Emission::Directional { angle_degrees };
        Disc::of(&Light { emission, position: Vec3::new(1.0, 2.0, -0.5), ..Default::default() }).unwrap()
    }

    #[test]
    fn directions_fill_it_evenly() {
        for angle in [0.53, 5.0, 90.0_f32] {
            let disc = disc(angle);
            let (steps, mut inside) = (200, [0; 2]);
            for i in 0..steps * steps {
                let u = (Vec2::new((i % steps) as f32, (i / steps) as f32) + 0.5) / steps as f32;
                let direction = disc.direction(u);
                assert!(disc.contains(direction) && (direction.length() - 1.0).abs() < 1e-5, "{angle}: {direction}");
                // Half of the solid angle is within half of the height.
                let [x, y] = [disc.right, disc.up].map(|axis| direction.dot(axis));
                let half = 0.5 * disc.height;
                inside[0] += usize::from(x * x + y * y < half * (2.0 - half));
                inside[1] += usize::from(x > 0.0);
            }
            let share = inside.map(|count| count as f32 / (steps * steps) as f32);
            assert!(share.iter().all(|share| (share - 0.5).abs() < 0.01), "{angle}: {share:?}");
        }
    }

    #[test]
    fn eight_directions_are_those_of_each() {
        let disc = disc(3.0);
        let grid = |i: usize| Vec2::new((i % 17) as f32, (i / 17) as f32) / 16.0;
        for first in (0..17 * 17).step_by(8) {
            let u: [Vec2; 8] = std::array::from_fn(|i| grid((first + i).min(288)));
            let found = disc.directions([f32x8::new(u.map(|u| u.x)), f32x8::new(u.map(|u| u.y))]);
            for (lane, &u) in u.iter().enumerate() {
                assert!((found.lane(lane) - disc.direction(u)).length() < 1e-6, "{u}");
            }
            assert!((found.lane(0) - disc.direction(u[0] + 0.01)).length() > 1e-6, "negative control");
        }
    }

    #[test]
    fn it_ends_at_its_rim() {
        let disc = disc(0.53);
        let at = |degrees: f32| disc.axis * degrees.to_radians().cos() + disc.right * degrees.to_radians().sin();
        assert!(disc.contains(at(0.263)) && !disc.contains(at(0.267)) && !disc.contains(-disc.axis));
        assert!((disc.solid_angle() / (PI * 0.265_f32.to_radians().powi(2)) - 1.0).abs() < 1e-3);
        let parallel = Light { emission: Emission::PARALLEL, position: Vec3::Y, ..Default::default() };
        assert_eq!(Disc::of(&parallel), None);
    }
}
