//! Local lights that a path vertex samples: all of a few, or one of many.

use lapidary_core::lights::Light;

/// Up to this many lights are all sampled.
const ALL_OF: usize = 8;

/// Share of the choice that ignores power: power bounds may be far off, and every light needs a chance.
const UNIFORM: f64 = 0.1;

/// The lights that shine, with their sampling probabilities.
pub struct LightChoice<'a> {
    lights: Vec<&'a Light>,
    /// Probability of each light; 1 for each of a few.
    probability: Vec<f32>,
    /// Running sums of the probabilities.
    running: Vec<f64>,
}

impl<'a> LightChoice<'a> {
    /// For a scene within a sphere of `radius` meters.
    pub fn new(lights: &'a [Light], radius: f32) -> Self {
        let lights: Vec<&Light> = lights.iter().filter(|light| light.shines()).collect();
        let count = lights.len() as f64;
        let powers: Vec<f64> = lights.iter().map(|light| f64::from(light.power_bound(radius))).collect();
        let total: f64 = powers.iter().sum();
        let share = |power: f64| {
            let by_power = if total > 0.0 && total.is_finite() { power / total } else { 1.0 / count };
            UNIFORM / count + (1.0 - UNIFORM) * by_power
        };
        let shares: Vec<f64> = powers.into_iter().map(share).collect();
        let mut sum = 0.0;
        let running = shares.iter().map(|share| {
            sum += share;
            sum
        });
        let running = running.collect();
        let probability = shares.iter().map(|&share| if lights.len() <= ALL_OF { 1.0 } else { share as f32 }).collect();
        Self { lights, probability, running }
    }

    /// All lights with their probabilities.
    pub fn all(&self) -> impl Iterator<Item = (&'a Light, f32)> {
        self.lights.iter().copied().zip(self.probability.iter().copied())
    }

    /// The lights to sample for a number `u` in [0, 1), with their probabilities.
    pub fn asked(&self, u: f32) -> impl Iterator<Item = (&'a Light, f32)> {
        let count = self.lights.len();
        let range = if count <= ALL_OF {
            0..count
        } else {
            let target = f64::from(u) * self.running[count - 1];
            let chosen = self.running.partition_point(|&r| r <= target).min(count - 1);
            chosen..chosen + 1
        };
        range.map(|i| (self.lights[i], self.probability[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lapidary_core::lights::Emission;

    fn lights(count: usize) -> Vec<Light> {
        let light = |i: usize| Light {
            name: String::new(),
            enabled: i != 1,
            emission: Emission::Point,
            position: Vec3::ZERO,
            target: Vec3::ZERO,
            intensity: Vec3::splat((i * i) as f32 + 1.0),
        };
        (0..count).map(light).collect()
    }

    #[test]
    fn few_lights_are_all_asked_and_dark_ones_never() {
        let lights = lights(5);
        let choice = LightChoice::new(&lights, 1.0);
        assert_eq!(choice.asked(0.7).map(|(_, p)| p).collect::<Vec<_>>(), [1.0; 4]);
        assert_eq!(LightChoice::new(&[], 1.0).asked(0.2).count(), 0);
    }

    #[test]
    fn one_of_many_is_asked_as_often_as_its_probability_says() {
        let lights = lights(40);
        let choice = LightChoice::new(&lights, 1.0);
        let n = 100_000;
        let mut counts = [0_u32; 40];
        for i in 0..n {
            let asked: Vec<_> = choice.asked((i as f32 + 0.5) / n as f32).collect();
            assert_eq!(asked.len(), 1);
            let index = lights.iter().position(|l| std::ptr::eq(l, asked[0].0)).unwrap();
            counts[index] += 1;
        }
        for (light, probability) in choice.all() {
            let index = lights.iter().position(|l| std::ptr::eq(l, light)).unwrap();
            assert!((counts[index] as f32 / n as f32 - probability).abs() < 1e-4, "{index}");
        }
        assert!((choice.all().map(|(_, p)| p).sum::<f32>() - 1.0).abs() < 1e-5);
        assert!(counts[39] > 5 * counts[2] && counts[0] > 0 && counts[1] == 0);
    }

    #[test]
    fn powers_beyond_measure_are_chosen_evenly() {
        let mut lights = lights(20);
        lights[3].intensity = Vec3::splat(f32::MAX);
        assert!(LightChoice::new(&lights, 1.0).all().all(|(_, p)| p.is_finite() && p > 0.0));
    }
}
