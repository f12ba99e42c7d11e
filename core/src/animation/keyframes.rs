//! Keyframes and their interpolation (glTF 2.0, section 3.11 and appendix C).

use super::nodes::unit_rotation;

/// Interpolation between keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The value is constant until the next keyframe.
    Step,
    /// Linear in time; rotations along the shortest arc.
    Linear,
    /// A cubic spline with a tangent into and out of each keyframe.
    CubicSpline,
}

impl Interpolation {
    /// Number of values stored per keyframe: for a spline the in-tangent, the value and the out-tangent.
    pub fn values_per_key(self) -> usize {
        if self == Self::CubicSpline { 3 } else { 1 }
    }
}

/// A sampler of an animation. Values have `width` numbers each.
#[derive(Clone, Debug)]
pub struct Keyframes {
    times: Vec<f32>,
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
}

/// A position between two keyframes.
struct Between {
    key: usize,
    /// 0 at the keyframe, up to 1 at the next.
    share: f32,
    /// Duration to the next keyframe.
    seconds: f32,
}

impl Keyframes {
    /// `times` are in seconds; each has values of `width` numbers, as many as the interpolation stores.
    ///
    /// # Errors
    /// A description of the problem.
    pub fn new(times: Vec<f32>, values: Vec<f32>, width: usize, interpolation: Interpolation) -> Result<Self, String> {
        let keys = times.len();
        let expected = keys * width * interpolation.values_per_key();
        if keys == 0 {
            return Err("it has no keyframes".into());
        }
        if values.len() != expected {
            return Err(format!("it has {} numbers for {keys} keyframes, which need {expected}", values.len()));
        }
        if let Some(key) = times.iter().position(|time| !(0.0..f32::INFINITY).contains(time)) {
            return Err(format!("the time of keyframe {key} is {}; it must be a number from 0 on", times[key]));
        }
        if let Some(key) = (1..keys).find(|&key| times[key] < times[key - 1]) {
            return Err(format!(
                "keyframe {key} is at {} s, before the one ahead of it; times must ascend",
                times[key]
            ));
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            let key = index / (width * interpolation.values_per_key()).max(1);
            return Err(format!("the value of keyframe {key} is not a finite number"));
        }
        Ok(Self { times, values, width, interpolation })
    }

    /// Time of the last keyframe, in seconds.
    pub fn end(&self) -> f32 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The values of the keyframes, without tangents.
    pub fn values(&self) -> impl Iterator<Item = &[f32]> {
        (0..self.times.len()).map(|key| self.value(key))
    }

    /// The value at a time in seconds, clamped to the first and last keyframe.
    pub fn sample(&self, seconds: f32) -> Vec<f32> {
        let Between { key, share, seconds } = self.between(seconds);
        match self.interpolation {
            _ if share == 0.0 => self.value(key).to_vec(),
            Interpolation::Step => self.value(key).to_vec(),
            Interpolation::Linear => {
                let ends = self.value(key).iter().zip(self.value(key + 1));
                ends.map(|(a, b)| a + (b - a) * share).collect()
            }
            Interpolation::CubicSpline => self.spline(key, share, seconds),
        }
    }

    /// [`Self::sample`] of rotations, normalized.
    pub fn sample_rotation(&self, seconds: f32) -> glam::Quat {
        let Between { key, share, .. } = self.between(seconds);
        let rotation = |value: &[f32]| unit_rotation([value[0], value[1], value[2], value[3]]);
        if self.interpolation == Interpolation::Linear && share > 0.0 {
            let [from, to] = [key, key + 1].map(|key| rotation(self.value(key)));
            return if from == to { from } else { from.slerp(to, share).normalize() };
        }
        rotation(&self.sample(seconds))
    }

    fn between(&self, seconds: f32) -> Between {
        let after = self.times.partition_point(|&time| time <= seconds);
        let key = after.saturating_sub(1);
        if after == 0 || after == self.times.len() {
            return Between { key, share: 0.0, seconds: 0.0 };
        }
        let length = self.times[after] - self.times[key];
        Between { key, share: (seconds - self.times[key]) / length, seconds: length }
    }

    fn value(&self, key: usize) -> &[f32] {
        self.stored(key, usize::from(self.interpolation == Interpolation::CubicSpline))
    }

    /// A stored value of a keyframe.
    fn stored(&self, key: usize, which: usize) -> &[f32] {
        let first = (key * self.interpolation.values_per_key() + which) * self.width;
        &self.values[first..first + self.width]
    }

    /// Hermite's spline. The values' part is written as a difference, so that equal values stay unchanged.
    fn spline(&self, key: usize, t: f32, seconds: f32) -> Vec<f32> {
        let (out_of, into) = (self.stored(key, 2), self.stored(key + 1, 0));
        let (from, to) = (self.value(key), self.value(key + 1));
        let rise = t * t * (3.0 - 2.0 * t);
        let (leave, arrive) = (t * (1.0 - t) * (1.0 - t) * seconds, t * t * (t - 1.0) * seconds);
        let value = |i: usize| from[i] + (to[i] - from[i]) * rise + leave * out_of[i] + arrive * into[i];
        (0..self.width).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

    fn keys(values: &[f32], interpolation: Interpolation) -> Keyframes {
        let keys = values.len() / interpolation.values_per_key();
        Keyframes::new((0..keys).map(|key| 1.0 + 2.0 * key as f32).collect(), values.to_vec(), 1, interpolation)
            .unwrap()
    }

    #[test]
    fn steps_stay_lines_rise_evenly_and_the_ends_hold() {
        let at = |keys: &Keyframes, seconds: &[f32]| seconds.iter().map(|&s| keys.sample(s)[0]).collect::<Vec<_>>();
        let seconds = [-1.0, 0.0, 1.0, 1.5, 3.0, 4.0, 5.0, 90.0];
        assert_eq!(at(&keys(&[2.0, 6.0, 4.0], Interpolation::Linear), &seconds), [2., 2., 2., 3., 6., 5., 4., 4.]);
        assert_eq!(at(&keys(&[2.0, 6.0, 4.0], Interpolation::Step), &seconds), [2., 2., 2., 2., 6., 6., 4., 4.]);
    }

    #[test]
    fn a_spline_through_the_keyframes_of_a_cubic_is_that_cubic() {
        let cubic = |t: f32| 0.5 * t * t * t - t * t + 2.0;
        let slope = |t: f32| 1.5 * t * t - 2.0 * t;
        let stored: Vec<f32> = [1.0, 3.0, 5.0].iter().flat_map(|&t| [slope(t), cubic(t), slope(t)]).collect();
        let keys = keys(&stored, Interpolation::CubicSpline);
        for t in [1.0, 1.3, 2.0, 2.9, 3.0, 4.7, 5.0] {
            assert!((keys.sample(t)[0] - cubic(t)).abs() < 1e-4, "{t}: {} {}", keys.sample(t)[0], cubic(t));
        }
        let linear = Keyframes::new(vec![1.0, 3.0], vec![cubic(1.0), cubic(3.0)], 1, Interpolation::Linear).unwrap();
        assert!((linear.sample(2.0)[0] - cubic(2.0)).abs() > 0.5, "negative control");
    }

    #[test]
    fn rotations_take_the_shortest_arc_at_an_even_pace() {
        let turns: Vec<f32> = [0.0, FRAC_PI_2].iter().flat_map(|&a| Quat::from_rotation_z(a).to_array()).collect();
        let mut long_way = turns.clone();
        long_way[4..].iter_mut().for_each(|x| *x = -*x);
        for values in [turns, long_way] {
            let keys = Keyframes::new(vec![0.0, 1.0], values, 4, Interpolation::Linear).unwrap();
            let at = |seconds| keys.sample_rotation(seconds);
            assert!(at(0.5).angle_between(Quat::from_rotation_z(FRAC_PI_4)) < 1e-3);
            assert!(at(0.25).angle_between(Quat::from_rotation_z(0.5 * FRAC_PI_4)) < 1e-3);
            assert!(at(0.25).angle_between(at(0.5)) > 0.3, "negative control");
        }
    }

    #[test]
    fn what_are_no_keyframes_is_told() {
        let of = |times: &[f32], values: &[f32]| {
            Keyframes::new(times.to_vec(), values.to_vec(), 1, Interpolation::Linear).err().unwrap_or_default()
        };
        assert_eq!(of(&[0.0, 1.0], &[1.0, 2.0]), "");
        assert_eq!(of(&[0.0, 1.0, 1.0], &[1.0; 3]), "", "two at one time are a step");
        for (times, values, said) in [
            (&[][..], &[][..], "no keyframes"),
            (&[0.0, 1.0], &[1.0], "1 numbers for 2 keyframes"),
            (&[0.0, -1.0], &[1.0, 2.0], "from 0 on"),
            (&[0.0, f32::NAN], &[1.0, 2.0], "NaN"),
            (&[2.0, 1.0], &[1.0, 2.0], "must ascend"),
            (&[0.0, 1.0], &[1.0, f32::INFINITY], "keyframe 1 is not a finite number"),
        ] {
            assert!(of(times, values).contains(said), "{}", of(times, values));
        }
    }
}
