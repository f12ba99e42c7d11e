//! Decrease of light over bounces, and the light missing after the last.

use glam::Vec3;

/// Light per bounce of a solution, and the light missing after the last bounce.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BounceEnergy {
    /// Number of computed indirect bounces.
    pub bounces: u32,
    /// Light of the last bounce, as a share of all light.
    pub last_share: f32,
    /// Light missing after the last bounce, as a share of all light including it; 1 if the light of bounces does not decrease.
    pub missing_share: f32,
}

impl BounceEnergy {
    /// The energy from the mean irradiance of direct light and then of each bounce. The missing light continues the
    /// last two bounces as a geometric series.
    pub fn of(mean_irradiance: &[Vec3]) -> Self {
        let energy: Vec<f64> = mean_irradiance.iter().map(|e| f64::from(e.element_sum())).collect();
        let sum: f64 = energy.iter().sum();
        let bounces = energy.len().saturating_sub(1) as u32;
        let [.., before, last] = energy[..] else {
            return Self { bounces, last_share: 0.0, missing_share: 0.0 };
        };
        if !(sum > 0.0 && last > 0.0) {
            return Self { bounces, last_share: 0.0, missing_share: 0.0 };
        }
        let kept = last / before;
        let missing = if kept < 1.0 { last * kept / (1.0 - kept) } else { f64::INFINITY };
        let missing_share = if missing.is_finite() { missing / (sum + missing) } else { 1.0 };
        Self { bounces, last_share: (last / sum) as f32, missing_share: missing_share as f32 }
    }

    /// The energy with one more bounce, the next of the same geometric series.
    pub fn and_the_next(self) -> Self {
        let Self { bounces, last_share: last, missing_share } = self;
        let bounces = bounces + 1;
        if last <= 0.0 || missing_share >= 1.0 {
            return Self { bounces, ..self };
        }
        // Relative to the light so far: the missing light is last * kept / (1 - kept).
        let missing = missing_share / (1.0 - missing_share);
        let next = last * missing / (last + missing);
        Self { bounces, last_share: next / (1.0 + next), missing_share: (missing - next) / (1.0 + missing) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn energy_of(energies: &[f32]) -> BounceEnergy {
        BounceEnergy::of(&energies.iter().map(|e| Vec3::new(*e, 0.5 * e, 0.0)).collect::<Vec<_>>())
    }

    #[test]
    fn what_is_missing_is_the_rest_of_the_series() {
        let half = energy_of(&[16.0, 8.0, 4.0, 2.0]);
        assert_eq!(half.bounces, 3);
        assert!((half.last_share - 2.0 / 30.0).abs() < 1e-6 && (half.missing_share - 2.0 / 32.0).abs() < 1e-6);
        let bright = energy_of(&[1.0, 0.9, 0.81]);
        assert!((bright.missing_share - 0.729).abs() < 1e-5, "{bright:?}");
        assert_eq!(energy_of(&[1.0, 1.0, 1.0]).missing_share, 1.0, "a closed box of reflectance one");
    }

    #[test]
    fn darkness_misses_nothing() {
        for dark in [&[0.0, 0.0, 0.0][..], &[1.0, 0.0], &[1.0], &[]] {
            let energy = energy_of(dark);
            assert_eq!((energy.last_share, energy.missing_share), (0.0, 0.0), "{dark:?}");
        }
    }

    #[test]
    fn the_next_bounce_goes_on_with_the_series() {
        // 16, 8, 4, and then 2, 1 and so on.
        let energy = BounceEnergy { bounces: 2, last_share: 4.0 / 28.0, missing_share: 4.0 / 32.0 };
        let BounceEnergy { bounces, last_share, missing_share } = energy.and_the_next();
        assert_eq!(bounces, 3);
        assert!((last_share - 2.0 / 30.0).abs() < 1e-6 && (missing_share - 2.0 / 32.0).abs() < 1e-6);
        let endless = BounceEnergy { bounces: 4, last_share: 0.2, missing_share: 1.0 };
        assert_eq!(endless.and_the_next(), BounceEnergy { bounces: 5, ..endless });
    }
}
