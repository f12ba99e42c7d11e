//! Which lights shine alike, and how many.

use lapidary_core::lights::{Emission, Light};
use std::collections::HashMap;

/// Bits of every property that affects a light's irradiance.
pub(crate) type LightKey = [u32; 12];

/// Number of lights of each kind, regardless of names.
pub(crate) struct LightCounts(HashMap<LightKey, usize>);

impl LightCounts {
    /// Counts these lights.
    pub fn of<'a>(lights: impl Iterator<Item = &'a Light>) -> Self {
        let mut counts = HashMap::new();
        lights.for_each(|light| *counts.entry(light_key(light)).or_default() += 1);
        Self(counts)
    }

    /// Whether all lights are taken.
    pub fn is_empty(&self) -> bool {
        self.0.values().all(|&count| count == 0)
    }

    /// Takes all of `lights`, or none if one is missing.
    pub fn take(&mut self, lights: &[LightKey]) -> bool {
        for (i, light) in lights.iter().enumerate() {
            let Some(count) = self.0.get_mut(light).filter(|count| **count > 0) else {
                lights[..i].iter().for_each(|taken| *self.0.entry(*taken).or_default() += 1);
                return false;
            };
            *count -= 1;
        }
        true
    }
}

/// Equal for lights that shine alike.
pub(crate) fn light_key(light: &Light) -> LightKey {
    let [kind, a, b] = match light.emission {
        Emission::Point => [0.0; 3],
        Emission::Spot { cone_degrees, penumbra_degrees } => [1.0, cone_degrees, penumbra_degrees],
        Emission::Directional { angle_degrees } => [2.0, angle_degrees, 0.0],
        Emission::Rectangle { width, height } => [3.0, width, height],
    };
    let ([px, py, pz], [tx, ty, tz], [r, g, blue]) =
        (light.position.to_array(), light.target.to_array(), light.intensity.to_array());
    [kind, a, b, px, py, pz, tx, ty, tz, r, g, blue].map(f32::to_bits)
}
