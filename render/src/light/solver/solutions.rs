//! The list of all solutions. Add one as a file beside this one and a line here.

use super::{
    BounceSolver, cuts::CutsSolver, cuts_over_gloss::CutsOverGloss, cuts_over_meshless::CutsOverMeshless,
    cuts_over_radiosity::CutsOverRadiosity, meshless::MeshlessSolver, radiosity::RadiositySolver,
    wavelet::WaveletSolver,
};
use lapidary_core::dataset::BakeParts;
use serde::{Deserialize, Serialize};
use std::fmt;

#[cfg(test)]
use super::even::Even;

/// A solver with its texts for lists.
pub trait Described: BounceSolver + Default + 'static {
    /// Display name.
    const LABEL: &'static str;
    /// Summary of its strength, in one sentence.
    const SUMMARY: &'static str;
    /// Method, for the command line.
    const METHOD: &'static str;
    /// Bounces between surfaces in its pictures.
    const BOUNCES: u32;
    /// Dataset parts that it needs.
    const NEEDS: BakeParts;
    /// Whether its light is that of the posed scene, so that nothing is added for objects that moved.
    const FOLLOWS_POSES: bool = false;
}

macro_rules! solutions {
    ($($(#[$attribute:meta])* $variant:ident($solver:ty) = $key:literal,)*) => {
        /// How bounced light is computed.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum Solution {
            $($(#[$attribute])* #[doc = concat!("`", $key, "`, see [`Self::method`].")] #[serde(rename = $key)] $variant,)*
        }

        impl Solution {
            /// All solutions in list order. The first is the default.
            pub const ALL: &'static [Self] = &[$($(#[$attribute])* Self::$variant,)*];

            /// Name in files and on the command line.
            pub const fn key(self) -> &'static str {
                match self { $($(#[$attribute])* Self::$variant => $key,)* }
            }

            /// Display name.
            pub const fn label(self) -> &'static str {
                match self { $($(#[$attribute])* Self::$variant => <$solver as Described>::LABEL,)* }
            }

            /// Summary of its strength, in one sentence.
            pub const fn summary(self) -> &'static str {
                match self { $($(#[$attribute])* Self::$variant => <$solver as Described>::SUMMARY,)* }
            }

            /// Method, for the command line.
            pub const fn method(self) -> &'static str {
                match self { $($(#[$attribute])* Self::$variant => <$solver as Described>::METHOD,)* }
            }

            /// Bounces between surfaces in its pictures.
            pub const fn bounces(self) -> u32 {
                match self { $($(#[$attribute])* Self::$variant => <$solver as Described>::BOUNCES,)* }
            }

            /// Dataset parts that it needs.
            pub const fn needs(self) -> BakeParts {
                match self { $($(#[$attribute])* Self::$variant => <$solver as Described>::NEEDS,)* }
            }

            /// Whether its light is that of the posed scene.
            pub const fn follows_poses(self) -> bool {
                match self { $($(#[$attribute])* Self::$variant => <$solver as Described>::FOLLOWS_POSES,)* }
            }

            /// Its solver before the first step.
            pub(crate) fn solver(self) -> Box<dyn BounceSolver> {
                match self { $($(#[$attribute])* Self::$variant => Box::new(<$solver>::default()),)* }
            }
        }
    };
}

solutions! {
    Cuts(CutsSolver) = "cuts",
    Meshless(MeshlessSolver) = "meshless",
    CutsMeshless(CutsOverMeshless) = "cuts+meshless",
    CutsGloss(CutsOverGloss) = "cuts+gloss",
    Radiosity(RadiositySolver) = "radiosity",
    CutsRadiosity(CutsOverRadiosity) = "cuts+radiosity",
    Wavelet(WaveletSolver) = "wavelet",
    #[cfg(test)]
    Even(Even) = "even",
}

impl Solution {
    /// Solutions available with these baked parts.
    pub fn of(baked: BakeParts) -> Vec<Self> {
        Self::ALL.iter().copied().filter(|solution| baked.has_all(solution.needs())).collect()
    }

    /// The wanted solution if available, else another available one.
    pub fn closest_to(wanted: Self, baked: BakeParts) -> Option<Self> {
        let solutions = Self::of(baked);
        solutions.iter().find(|&&s| s == wanted).or(solutions.first()).copied()
    }
}

impl Default for Solution {
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl fmt::Display for Solution {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.key())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_baked_can_be_chosen() {
        const BOTH: BakeParts = BakeParts::INDIRECT.with(BakeParts::MESHLESS);
        assert!(Solution::of(BakeParts::ENVIRONMENT).is_empty());
        assert_eq!(Solution::closest_to(Solution::Cuts, BakeParts::NONE), None);
        assert_eq!(Solution::closest_to(Solution::CutsMeshless, BakeParts::INDIRECT), Some(Solution::Cuts));
        assert_eq!(Solution::of(BakeParts::MESHLESS), [Solution::Meshless]);
        assert_eq!(Solution::closest_to(Solution::CutsMeshless, BOTH), Some(Solution::CutsMeshless));
    }

    #[test]
    fn names_are_those_of_files() {
        for &solution in Solution::ALL {
            let text = serde_json::to_string(&solution).unwrap();
            assert_eq!(text, format!("\"{solution}\""));
            assert_eq!(serde_json::from_str::<Solution>(&text).unwrap(), solution);
        }
        assert_eq!(Solution::default(), Solution::Cuts);
    }
}
