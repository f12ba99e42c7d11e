//! Size of a picture within a frame time, and rows per band, from the measured speed.

/// Steps from nothing to the full size. Sizes are steps of a ladder, so that noise in the
/// measurement does not change the size from frame to frame.
const STEPS: u32 = 8;

/// Steps of the smallest picture: pixels of a smaller one, stretched, would be a mosaic. It also keeps the fixed cost of a picture
/// from being mistaken for the cost of its pixels.
const LEAST_STEPS: u32 = 3;

/// Target time of a band of rows in milliseconds: short enough to drop everything for a new request, long enough that
/// starting it costs little.
const BAND_MS: f64 = 45.0;

/// Rows of the first band of all, before anything was measured.
const FIRST_BAND: u32 = 16;

/// Measured speed of rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    ms_per_pixel: Option<f64>,
}

impl Pace {
    /// Records that one sample of `pixels` pixels took `millis` milliseconds. Earlier measurements count half.
    pub fn measured(&mut self, pixels: u64, millis: f64) {
        if pixels == 0 || !(millis >= 0.0) {
            return;
        }
        let now = millis / pixels as f64;
        self.ms_per_pixel = Some(self.ms_per_pixel.map_or(now, |before| 0.5 * (before + now)));
    }

    /// The largest picture that is rendered in `budget_ms`, from three eighths of each axis to all of it.
    pub fn reduced_size(&self, full: [u32; 2], budget_ms: f32) -> [u32; 2] {
        let steps = self.ms_per_pixel.map_or(LEAST_STEPS, |ms| {
            let pixels = f64::from(full[0]) * f64::from(full[1]);
            let scale = (f64::from(budget_ms) / (ms * pixels)).sqrt();
            // The cast turns NaN into the least size, and infinity into the largest.
            ((scale * f64::from(STEPS)) as u32).clamp(LEAST_STEPS, STEPS)
        });
        full.map(|side| (u64::from(side) * u64::from(steps)).div_ceil(STEPS.into()).max(1) as u32)
    }

    /// The speed of doing both for each pixel.
    pub fn and(self, other: Self) -> Self {
        let sum = |a: f64| a + other.ms_per_pixel.unwrap_or(0.0);
        Self { ms_per_pixel: self.ms_per_pixel.map(sum) }
    }

    /// Milliseconds for `pixels` pixels, if measured.
    pub fn millis(&self, pixels: u64) -> Option<f64> {
        self.ms_per_pixel.map(|ms| ms * pixels as f64)
    }

    /// How many times `pixels` pixels can be rendered in `millis` milliseconds, if measured.
    pub fn times_within(&self, millis: f64, pixels: f64) -> Option<usize> {
        // The cast turns negatives and NaN into zero, and infinity into the largest number.
        self.ms_per_pixel.map(|ms| (millis / (ms * pixels)) as usize)
    }

    /// Rows of a picture of `width` pixels that take the time of a band.
    pub fn band_rows(&self, width: u32) -> u32 {
        self.ms_per_pixel
            .map_or(FIRST_BAND, |ms| (BAND_MS / (ms * f64::from(width.max(1)))).clamp(1.0, 32_768.0) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: [u32; 2] = [800, 600];

    fn pace(ms_per_pixel: f64) -> Pace {
        Pace { ms_per_pixel: Some(ms_per_pixel) }
    }

    #[test]
    fn a_reduced_picture_is_the_largest_step_that_fits() {
        let budget = 100.0;
        for ms_per_pixel in [1e-7, 1e-4, 2.1e-4, 3e-4, 1e-3, 5e-3, 1.3e-2] {
            let size = pace(ms_per_pixel).reduced_size(FULL, budget);
            let steps = size[0] / 100;
            assert_eq!(size, [100 * steps, 75 * steps]);
            let millis = |steps: u32| f64::from(100 * steps) * f64::from(75 * steps) * ms_per_pixel;
            assert!(millis(steps) <= 100.0 || steps == LEAST_STEPS, "{ms_per_pixel}: {steps}");
            assert!(steps == STEPS || millis(steps + 1) > 100.0, "{ms_per_pixel}: {steps} is too small");
        }
    }

    #[test]
    fn no_axis_falls_below_three_eighths_or_to_nothing() {
        assert_eq!(pace(1e3).reduced_size(FULL, 1.0), [300, 225]);
        assert_eq!(pace(1e3).reduced_size([1001, 3], 1.0), [376, 2]);
        assert_eq!(Pace::default().reduced_size(FULL, 1e9), [300, 225], "an unknown speed is taken for slow");
        assert_eq!(pace(0.0).reduced_size(FULL, 1.0), FULL);
        assert_eq!(pace(0.0).reduced_size([0, 0], 0.0), [1, 1]);
        assert_eq!(pace(1e-9).reduced_size(FULL, f32::NAN), [300, 225]);
    }

    #[test]
    fn bands_take_the_time_of_a_band() {
        assert_eq!([1e-4, 1e-3, 1e-2].map(|ms| pace(ms).band_rows(1000)), [450, 45, 4], "45 ms");
        assert_eq!(pace(10.0).band_rows(1000), 1);
        assert!(pace(0.0).band_rows(1000) > 10_000);
        assert_eq!(Pace::default().band_rows(1000), FIRST_BAND);
    }

    #[test]
    fn speeds_add_up_and_tell_times() {
        let both = pace(1e-3).and(pace(3e-3));
        assert_eq!(both.millis(1000), Some(4.0));
        assert_eq!(both.times_within(41.0, 1000.0), Some(10));
        assert_eq!((both.times_within(-1.0, 10.0), pace(0.0).times_within(1.0, 0.0)), (Some(0), Some(usize::MAX)));
        assert_eq!(pace(1e-3).and(Pace::default()), pace(1e-3));
        assert_eq!(Pace::default().and(pace(1e-3)).millis(1), None, "an unknown speed stays unknown");
    }

    #[test]
    fn measurements_are_smoothed_and_nonsense_is_left_out() {
        let mut pace = Pace::default();
        pace.measured(1000, 10.0);
        assert_eq!(pace, super::Pace { ms_per_pixel: Some(0.01) });
        pace.measured(100, 3.0);
        assert_eq!(pace, super::Pace { ms_per_pixel: Some(0.02) });
        let before = pace;
        pace.measured(0, 3.0);
        pace.measured(10, f64::NAN);
        assert_eq!(pace, before);
    }
}
