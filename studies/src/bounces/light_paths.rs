//! Light paths as the reference, and the effect of their noise on a measured error.

use anyhow::Result;
use lapidary_core::{color::luminance, image::Image};
use lapidary_render::{PathPicture, compare::compare};
use serde::Serialize;

/// A picture of light paths and its noise.
pub struct LightPaths {
    /// The mean of all paths.
    pub image: Image,
    /// Relative RMSE of [`Self::image`] against a noise-free picture, estimated from its halves.
    pub noise: f64,
}

/// Error of a picture against light paths.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Figures {
    /// Relative RMSE without the paths' noise.
    pub error: f64,
    /// Relative RMSE as measured.
    pub rel_rmse: f64,
    /// Relative RMSE of the light paths themselves.
    pub noise: f64,
    /// Ratio of the mean luminances.
    pub energy: f64,
}

impl From<PathPicture> for LightPaths {
    /// Takes zero noise if it is unknown.
    fn from(picture: PathPicture) -> Self {
        Self { image: picture.image, noise: picture.noise.unwrap_or(0.0) }
    }
}

impl LightPaths {
    /// Compares a picture of the same size with this one. Noise is independent of the picture, so its square is part of the
    /// measured square.
    ///
    /// # Errors
    /// Pictures that cannot be compared.
    pub fn against(&self, test: &Image) -> Result<Figures> {
        let rel_rmse = compare(test, &self.image)?.rel_rmse;
        let mean = |image: &Image| image.pixels.iter().map(|&p| f64::from(luminance(p))).sum::<f64>();
        let error = (rel_rmse * rel_rmse - self.noise * self.noise).max(0.0).sqrt();
        Ok(Figures { error, rel_rmse, noise: self.noise, energy: mean(test) / mean(&self.image) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A gradient with noise of `sigma` per component.
    fn noisy(rng: &mut fastrand::Rng, sigma: f32) -> Image {
        // Unit variance.
        let mut noise = || 12.0_f32.sqrt() * (rng.f32() - 0.5);
        let pixels = (0..6400).map(|i| Vec3::splat(1.0 + (i % 80) as f32 / 80.0 + sigma * noise())).collect();
        Image { size: [80, 80], pixels }
    }

    #[test]
    fn noise_is_taken_off() {
        let mut rng = fastrand::Rng::with_seed(1);
        // The root mean square of the gradient is 1.521, and the noise adds to the picture's.
        let noise = 0.2 / 1.521_f64.hypot(0.2);
        let truth = LightPaths { image: noisy(&mut rng, 0.2), noise };
        let exact = truth.against(&noisy(&mut rng, 0.0)).unwrap();
        assert!(exact.error < 0.03 && exact.rel_rmse > 0.13, "{exact:?}");
        let mut brighter = noisy(&mut rng, 0.0);
        brighter.pixels.iter_mut().for_each(|p| *p *= 1.1);
        let figures = truth.against(&brighter).unwrap();
        assert!((figures.error - 0.1).abs() < 0.02 && (figures.energy - 1.1).abs() < 0.01, "{figures:?}");
    }
}
