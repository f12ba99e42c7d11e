//! The mean of many passes and its remaining noise.

use lapidary_core::image::Image;

/// A picture of light paths.
#[derive(Clone, Debug, PartialEq)]
pub struct PathPicture {
    /// Mean of all passes.
    pub image: Image,
    /// Number of averaged passes.
    pub passes: u32,
    /// Relative RMSE of [`Self::image`] against a noise-free picture, estimated from two halves of the passes; `None` while there
    /// is only one half.
    pub noise: Option<f64>,
}

/// Sums over the passes of both halves. Passes alternate in whole patterns of the pixel's samples; otherwise the halves would see
/// different parts of the pixels.
pub(super) struct Halves {
    sums: [Image; 2],
    passes: [u32; 2],
    /// Passes that cover a whole pixel.
    pattern: u32,
}

impl Halves {
    pub fn new(size: [u32; 2], pattern: u32) -> Self {
        let black = Image::filled(size, glam::Vec3::ZERO);
        Self { sums: [black.clone(), black], passes: [0; 2], pattern: pattern.max(1) }
    }

    /// Number of passes so far.
    pub fn passes(&self) -> u32 {
        self.passes[0] + self.passes[1]
    }

    pub fn add(&mut self, pass: &Image) {
        let half = (self.passes() / self.pattern % 2) as usize;
        self.sums[half].add(pass);
        self.passes[half] += 1;
    }

    /// The picture so far; black before the first pass.
    pub fn picture(&self) -> PathPicture {
        let [a, b] = &self.sums;
        let scale = 1.0 / self.passes().max(1) as f32;
        let pixels = a.pixels.iter().zip(&b.pixels).map(|(a, b)| scale * (*a + *b)).collect();
        let image = Image { size: a.size, pixels };
        PathPicture { noise: self.noise(&image), image, passes: self.passes() }
    }

    /// Variance of a pass, estimated from the difference of the halves' means, over the number of passes.
    fn noise(&self, mean: &Image) -> Option<f64> {
        let [m, n] = self.passes.map(f64::from);
        if !(m > 0.0 && n > 0.0) {
            return None;
        }
        let [a, b] = self.sums.each_ref().map(|sum| sum.pixels.iter().map(|p| p.as_dvec3()));
        let pixels = a.zip(b).zip(&mean.pixels).filter(|(_, mean)| mean.is_finite());
        let sums = pixels.map(|((a, b), mean)| ((a / m - b / n).length_squared(), mean.as_dvec3().length_squared()));
        let (squared, norm) = sums.fold((0.0, 0.0), |sum, (s, n)| (sum.0 + s, sum.1 + n));
        let share = 1.0 / ((m + n) * (1.0 / m + 1.0 / n));
        Some(if norm > 0.0 { (share * squared / norm).sqrt() } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A gradient with gray noise of `sigma`.
    fn noisy(rng: &mut fastrand::Rng, sigma: f32) -> Image {
        // Unit variance.
        let mut noise = || 12.0_f32.sqrt() * (rng.f32() - 0.5);
        Image::from_fn([80, 80], |x, _| Vec3::splat(1.0 + x as f32 / 80.0 + sigma * noise()))
    }

    #[test]
    fn noise_is_found_for_any_number_of_passes() {
        let mut rng = fastrand::Rng::with_seed(1);
        for (passes, pattern) in [(2, 1), (3, 1), (16, 4), (21, 4)] {
            let mut halves = Halves::new([80, 80], pattern);
            (0..passes).for_each(|_| halves.add(&noisy(&mut rng, 0.3)));
            let picture = halves.picture();
            // The root mean square of the gradient is 1.521, and the noise adds to the picture's.
            let sigma = 0.3 / f64::from(passes).sqrt();
            let (expected, found) = (sigma / 1.521_f64.hypot(sigma), picture.noise.unwrap());
            assert!((found / expected - 1.0).abs() < 0.05, "{passes}: {found} for {expected}");
            assert_eq!(picture.passes, passes);
        }
    }

    #[test]
    fn what_the_pattern_of_a_pixel_changes_is_no_noise() {
        let noise = |pattern| {
            let mut halves = Halves::new([80, 80], pattern);
            (0..8).for_each(|i| halves.add(&Image::filled([80, 80], Vec3::splat(if i % 2 == 0 { 1.0 } else { 3.0 }))));
            halves.picture().noise.unwrap()
        };
        assert_eq!(noise(2), 0.0);
        assert!(noise(1) > 0.1, "negative control: each half sees one sample of the pattern only");
    }

    #[test]
    fn a_pixel_that_is_not_finite_has_no_part_in_the_noise() {
        let mut rng = fastrand::Rng::with_seed(2);
        let mut halves = Halves::new([80, 80], 1);
        for _ in 0..4 {
            let mut pass = noisy(&mut rng, 0.3);
            pass.pixels[9].y = f32::NAN;
            halves.add(&pass);
        }
        let noise = halves.picture().noise.unwrap();
        assert!((noise / (0.15 / 1.521_f64.hypot(0.15)) - 1.0).abs() < 0.05, "{noise}");
    }

    #[test]
    fn one_half_tells_nothing() {
        let mut halves = Halves::new([2, 1], 4);
        assert_eq!(halves.picture(), PathPicture { image: Image::filled([2, 1], Vec3::ZERO), passes: 0, noise: None });
        halves.add(&Image::filled([2, 1], Vec3::ONE));
        assert_eq!(halves.picture().noise, None);
    }
}
