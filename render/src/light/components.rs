//! The components of a picture's light, and how bounced light is computed.

use lapidary_core::{dataset::Dataset, meshless::SolveSettings};
use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

/// The parts of a picture's light. Pictures of single parts sum to the picture of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Components {
    /// Direct light of the environment, and the environment as the background.
    pub environment: bool,
    /// Direct light of local lights.
    pub direct: bool,
    /// All bounced light, of local lights and of the environment.
    pub indirect: bool,
}

impl Default for Components {
    fn default() -> Self {
        Self::ALL
    }
}

impl Components {
    /// Everything.
    pub const ALL: Self = Self { environment: true, direct: true, indirect: true };
    /// Nothing.
    pub const NONE: Self = Self { environment: false, direct: false, indirect: false };
    /// Everything but bounced light.
    pub const UNBOUNCED: Self = Self { indirect: false, ..Self::ALL };
}

impl FromStr for Components {
    type Err = String;

    /// A comma list of `environment`, `direct` and `indirect`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut components = Self::NONE;
        for name in text.split(',').map(str::trim) {
            match name {
                "environment" => components.environment = true,
                "direct" => components.direct = true,
                "indirect" => components.indirect = true,
                _ => return Err(format!("\"{name}\" is no component; list environment, direct or indirect")),
            }
        }
        Ok(components)
    }
}

impl fmt::Display for Components {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let names = [("environment", self.environment), ("direct", self.direct), ("indirect", self.indirect)];
        let wanted: Vec<&str> = names.into_iter().filter(|(_, wanted)| *wanted).map(|(name, _)| name).collect();
        f.write_str(&wanted.join(","))
    }
}

/// How bounced light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Solution {
    /// One bounce, gathered per pixel by cuts over surface sources.
    #[default]
    #[serde(rename = "cuts")]
    Cuts,
    /// Four diffuse bounces in the meshless basis.
    #[serde(rename = "meshless")]
    Meshless,
    /// Meshless bounces added to the sources, whose light the cuts gather.
    #[serde(rename = "cuts+meshless")]
    CutsMeshless,
}

impl Solution {
    /// Bounces between surfaces that a picture by this solution contains.
    pub fn bounces(self) -> u32 {
        let solved = SolveSettings::default().bounces;
        match self {
            Self::Cuts => 1,
            Self::Meshless => solved,
            Self::CutsMeshless => solved + 1,
        }
    }
}

impl fmt::Display for Solution {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Cuts => "cuts",
            Self::Meshless => "meshless",
            Self::CutsMeshless => "cuts+meshless",
        })
    }
}

/// The means of bounced light that a dataset has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounces {
    /// Surface samples and their visibility cuts.
    pub cuts: bool,
    /// A meshless basis and its transport.
    pub meshless: bool,
}

impl Bounces {
    /// Those of a dataset.
    pub fn of(dataset: &Dataset) -> Self {
        Self { cuts: dataset.indirect.is_some(), meshless: dataset.meshless.is_some() }
    }

    /// Whether there are any.
    pub fn any(self) -> bool {
        self.cuts || self.meshless
    }

    /// The solutions that can be chosen.
    pub fn solutions(self) -> Vec<Solution> {
        let all = [
            (Solution::Cuts, self.cuts),
            (Solution::Meshless, self.meshless),
            (Solution::CutsMeshless, self.cuts && self.meshless),
        ];
        all.into_iter().filter(|(_, has)| *has).map(|(solution, _)| solution).collect()
    }

    /// The wanted solution, or else one that there is.
    pub fn closest_to(self, wanted: Solution) -> Option<Solution> {
        let solutions = self.solutions();
        solutions.iter().find(|&&s| s == wanted).or(solutions.first()).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_and_written() {
        let both: Components = "indirect, environment".parse().unwrap();
        assert_eq!(both, Components { direct: false, ..Components::ALL });
        assert_eq!(both.to_string(), "environment,indirect");
        assert_eq!("environment,direct,indirect".parse(), Ok(Components::ALL));
        for bad in ["", "sun", "direct,,indirect", "Direct"] {
            assert!(bad.parse::<Components>().is_err(), "{bad}");
        }
    }

    #[test]
    fn only_what_is_baked_can_be_chosen() {
        let bounces = |cuts, meshless| Bounces { cuts, meshless };
        assert!(bounces(false, false).solutions().is_empty());
        assert_eq!(bounces(false, false).closest_to(Solution::Cuts), None);
        assert_eq!(bounces(true, false).closest_to(Solution::CutsMeshless), Some(Solution::Cuts));
        assert_eq!(bounces(false, true).solutions(), [Solution::Meshless]);
        assert_eq!(bounces(true, true).closest_to(Solution::CutsMeshless), Some(Solution::CutsMeshless));
    }
}
