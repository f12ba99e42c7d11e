//! Importance sampling of a latitude-longitude map by the luminance of its texels.

use glam::{Vec2, Vec3};
use lapidary_core::{
    color::luminance,
    environment::{direction_from_uv, texel_solid_angle, uv_from_direction},
    image::Image,
};

/// Texels by energy: piecewise constant in solid angle.
pub struct EnvironmentDistribution {
    size: [u32; 2],
    /// Running sums of texel energies over the whole map, row by row; the last is the total.
    running: Vec<f64>,
    /// Solid angle of a texel in each row.
    solid_angle: Vec<f32>,
}

impl EnvironmentDistribution {
    /// Builds the distribution over the texels of `map`.
    pub fn new(map: &Image) -> Self {
        let solid_angle: Vec<f32> = (0..map.size[1]).map(|row| texel_solid_angle(row, map.size)).collect();
        let mut sum = 0.0;
        let running = (0..map.pixels.len()).map(|i| {
            let (x, y) = (i % map.width(), i / map.width());
            sum += f64::from(mean_luminance(map, x, y)) * f64::from(solid_angle[y]);
            sum
        });
        Self { size: map.size, running: running.collect(), solid_angle }
    }

    fn total(&self) -> f64 {
        self.running.last().copied().unwrap_or(0.0)
    }

    /// Density per solid angle inside a texel.
    fn texel_pdf(&self, texel: usize) -> f32 {
        let before = if texel == 0 { 0.0 } else { self.running[texel - 1] };
        let row = texel / self.size[0] as usize;
        ((self.running[texel] - before) / self.total()) as f32 / self.solid_angle[row]
    }

    /// A direction in the map's frame and its density per solid angle; `None` for a black map.
    pub fn sample(&self, u: f32, v: f32) -> Option<(Vec3, f32)> {
        if !(self.total() > 0.0) {
            return None;
        }
        let target = f64::from(u) * self.total();
        let texel = self.running.partition_point(|&r| r <= target).min(self.running.len() - 1);
        let before = if texel == 0 { 0.0 } else { self.running[texel - 1] };
        // The remainder of the first number is uniform inside the texel.
        let within = ((target - before) / (self.running[texel] - before).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) as f32;
        let [width, height] = self.size.map(|s| s as f32);
        let (column, row) = (texel % self.size[0] as usize, texel / self.size[0] as usize);
        // Uniform in the cosine of the polar angle: the density is constant in solid angle.
        let edge = |r: f32| (std::f32::consts::PI * r / height).cos();
        let cos = edge(row as f32) + (edge(row as f32 + 1.0) - edge(row as f32)) * v;
        let uv = Vec2::new((column as f32 + within) / width, cos.clamp(-1.0, 1.0).acos() / std::f32::consts::PI);
        let pdf = self.texel_pdf(texel);
        (pdf > 0.0).then(|| (direction_from_uv(uv), pdf))
    }

    /// Density per solid angle of [`Self::sample`] at a direction in the map's frame.
    pub fn pdf(&self, direction: Vec3) -> f32 {
        if !(self.total() > 0.0) {
            return 0.0;
        }
        let p = uv_from_direction(direction) * Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let column = (p.x as usize).min(self.size[0] as usize - 1);
        let row = (p.y as usize).min(self.size[1] as usize - 1);
        self.texel_pdf(row * self.size[0] as usize + column)
    }
}

/// Mean luminance over a texel of the bilinear interpolation between texel centers. A bright texel reaches into its neighbors;
/// without this they would give fireflies.
fn mean_luminance(map: &Image, x: usize, y: usize) -> f32 {
    const TENT: [(isize, f32); 3] = [(-1, 0.125), (0, 0.75), (1, 0.125)]; // integrals of the tent over three texels
    let (width, height) = (map.width() as isize, map.height() as isize);
    let texel = |dx: isize, dy: isize| {
        map.at((x as isize + dx).rem_euclid(width) as usize, (y as isize + dy).clamp(0, height - 1) as usize)
    };
    TENT.iter()
        .flat_map(|&(dy, wy)| TENT.iter().map(move |&(dx, wx)| (dx, dy, wx * wy)))
        .map(|(dx, dy, w)| w * luminance(texel(dx, dy)))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_carry_their_density_and_estimate_the_energy() {
        let map = Image::from_fn([16, 8], |x, y| Vec3::splat(((x * 5 + y * 3) % 7) as f32));
        let distribution = EnvironmentDistribution::new(&map);
        let mut rng = fastrand::Rng::with_seed(5);
        let mut solid_angle = 0.0;
        let n = 20_000;
        for _ in 0..n {
            let (direction, pdf) = distribution.sample(rng.f32(), rng.f32()).unwrap();
            assert!((distribution.pdf(direction) / pdf - 1.0).abs() < 1e-3);
            solid_angle += 1.0 / f64::from(pdf) / f64::from(n);
        }
        let lit: f64 = (0..128).map(|i| f64::from(texel_solid_angle(i as u32 / 16, map.size))).sum();
        assert!((solid_angle / lit - 1.0).abs() < 0.02, "{solid_angle} of {lit}");
    }

    #[test]
    fn a_black_map_gives_no_samples() {
        let distribution = EnvironmentDistribution::new(&Image::filled([4, 2], Vec3::ZERO));
        assert!(distribution.sample(0.3, 0.3).is_none());
        assert_eq!(distribution.pdf(Vec3::Y), 0.0);
    }
}
