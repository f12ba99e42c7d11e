//! Texture coordinates outside 0 to 1.

use serde::{Deserialize, Serialize};

/// What texture coordinates outside 0 to 1 show of a picture, along one axis, as the samplers of glTF. Twin of `folded` in
/// `shaders/materials.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// The picture again, every other one mirrored.
    Mirror,
    /// The texels at its edge.
    Clamp,
}

impl Wrap {
    /// All of them, in the order of the shaders' numbers.
    pub const ALL: [Self; 3] = [Self::Repeat, Self::Mirror, Self::Clamp];

    /// Display name.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Repeat => "Repeat",
            Self::Mirror => "Mirror",
            Self::Clamp => "Clamp",
        }
    }

    /// The coordinate within 0 to 1 that shows the same.
    #[inline]
    fn folded(self, t: f32) -> f32 {
        match self {
            Self::Repeat => t - t.floor(),
            Self::Mirror => {
                let within_two = t - 2.0 * (0.5 * t).floor();
                within_two.min(2.0 - within_two)
            }
            Self::Clamp => t.clamp(0.0, 1.0),
        }
    }

    /// The derivative of [`Self::folded`]: -1 where the picture is mirrored, 0 beyond its edges.
    pub(super) fn slope(self, t: f32) -> f32 {
        match self {
            Self::Repeat => 1.0,
            Self::Mirror => 1.0 - 2.0 * (t.floor().rem_euclid(2.0)),
            Self::Clamp => f32::from(u8::from((0.0..=1.0).contains(&t))),
        }
    }

    /// The two texels of a row of `size` around a coordinate, and the weight of the second.
    #[inline]
    pub(super) fn neighbors(self, t: f32, size: u32) -> ([usize; 2], f32) {
        let p = self.folded(t) * size as f32 - 0.5;
        let (base, blend) = (p.floor(), p - p.floor());
        let last = size as usize - 1;
        let repeats = self == Self::Repeat;
        // The coordinate may round to the size.
        let low = match (base < 0.0, repeats) {
            (true, true) => last,
            (true, false) => 0,
            (false, true) => base as usize % size as usize,
            (false, false) => (base as usize).min(last),
        };
        let high = match (low == last, repeats) {
            (true, true) => 0,
            (true, false) => last,
            (false, _) => low + 1,
        };
        // Before the first texel both are the first one.
        ([low, if base < 0.0 && !repeats { low } else { high }], blend)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The coordinates of a row of four texels, which hold 0 to 3, read with linear interpolation.
    fn read(wrap: Wrap, t: f32) -> f32 {
        let ([low, high], blend) = wrap.neighbors(t, 4);
        low as f32 * (1.0 - blend) + high as f32 * blend
    }

    #[test]
    fn edges_are_repeated_mirrored_and_held() {
        // Texel centers are at 1/8, 3/8, 5/8 and 7/8.
        for (wrap, expected) in [
            (Wrap::Repeat, [3.0, 1.5, 0.0, 1.5, 1.0, 1.5]),
            (Wrap::Mirror, [0.0, 0.0, 3.0, 3.0, 2.0, 0.0]),
            (Wrap::Clamp, [0.0, 0.0, 3.0, 3.0, 3.0, 0.0]),
        ] {
            let found = [-0.125, 0.0, 1.125, 1.0, 1.375, -2.0].map(|t| read(wrap, t));
            assert_eq!(found, expected, "{wrap:?}");
        }
        for wrap in Wrap::ALL {
            assert_eq!([0.125, 0.5, 0.75].map(|t| read(wrap, t)), [0.0, 1.5, 2.5], "{wrap:?}");
            for t in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e-9, 0.99999994] {
                let ([low, high], _) = wrap.neighbors(t, 4);
                assert!(low < 4 && high < 4, "{wrap:?} {t}");
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_folded_coordinate() {
        for wrap in Wrap::ALL {
            for t in [-1.7, -0.3, 0.2, 0.8, 1.4, 2.6] {
                let step = 1.0 / 64.0;
                let change = (wrap.folded(t + step) - wrap.folded(t - step)) / (2.0 * step);
                assert!((change - wrap.slope(t)).abs() < 1e-4, "{wrap:?} {t}: {change}");
            }
        }
    }
}
