//! Which parts of light transport a bake prepares.

use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};
use thiserror::Error;

/// The parts of a bake, at least one. Parts that are not baked are dark: their cuts are one node without visibility.
///
/// In files and options a set has a name, or the names of its parts with commas between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct BakeParts {
    environment: bool,
    sources: bool,
    meshless: bool,
}

impl BakeParts {
    /// Visibility of distant light.
    pub const ENVIRONMENT: Self = Self { environment: true, sources: false, meshless: false };
    /// Surface sources, and what the vertices see of them.
    pub const INDIRECT: Self = Self { environment: false, sources: true, meshless: false };
    /// Both, and the sources' cuts over the environment: all light that cuts gather.
    pub const CUTS: Self = Self { environment: true, sources: true, meshless: false };
    /// The meshless basis and its transport operator.
    pub const MESHLESS: Self = Self { environment: false, sources: false, meshless: true };
    /// Visibility of distant light and the meshless basis, without surface sources.
    pub const ENVIRONMENT_MESHLESS: Self = Self { environment: true, sources: false, meshless: true };
    /// All of these.
    pub const ALL: Self = Self { environment: true, sources: true, meshless: true };

    /// The sets with a name of their own. Others are written as the names of their parts.
    const NAMED: [(&str, Self); 5] = [
        ("environment", Self::ENVIRONMENT),
        ("indirect", Self::INDIRECT),
        ("cuts", Self::CUTS),
        ("meshless", Self::MESHLESS),
        ("all", Self::ALL),
    ];

    /// Whether visibility of distant light is baked.
    pub fn environment(self) -> bool {
        self.environment
    }

    /// Whether surface sources are baked.
    pub fn sources(self) -> bool {
        self.sources
    }

    /// Whether the meshless basis is baked.
    pub fn meshless(self) -> bool {
        self.meshless
    }

    /// The union of both sets.
    pub fn with(self, other: Self) -> Self {
        Self {
            environment: self.environment || other.environment,
            sources: self.sources || other.sources,
            meshless: self.meshless || other.meshless,
        }
    }
}

impl Default for BakeParts {
    fn default() -> Self {
        Self::ENVIRONMENT
    }
}

/// A text that names no parts of a bake.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "\"{0}\" is not a part of a bake; use environment, indirect, cuts, meshless, all, or some of these with commas between"
)]
pub struct PartsError(String);

impl FromStr for BakeParts {
    type Err = PartsError;

    fn from_str(text: &str) -> Result<Self, PartsError> {
        let named = |part: &str| Self::NAMED.into_iter().find(|(name, _)| *name == part.trim()).map(|(_, parts)| parts);
        let parts = text.split(',').map(named).collect::<Option<Vec<_>>>();
        parts.and_then(|parts| parts.into_iter().reduce(Self::with)).ok_or_else(|| PartsError(text.into()))
    }
}

impl TryFrom<String> for BakeParts {
    type Error = PartsError;

    fn try_from(text: String) -> Result<Self, PartsError> {
        text.parse()
    }
}

impl fmt::Display for BakeParts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Some((name, _)) = Self::NAMED.iter().find(|(_, parts)| parts == self) {
            return f.write_str(name);
        }
        let parts = [(self.environment, "environment"), (self.sources, "indirect"), (self.meshless, "meshless")];
        let names: Vec<&str> = parts.into_iter().filter(|(is_in, _)| *is_in).map(|(_, name)| name).collect();
        f.write_str(&names.join(","))
    }
}

impl From<BakeParts> for String {
    fn from(parts: BakeParts) -> Self {
        parts.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All sets.
    fn all() -> impl Iterator<Item = BakeParts> {
        (1..8).map(|bits| BakeParts { environment: bits & 1 != 0, sources: bits & 2 != 0, meshless: bits & 4 != 0 })
    }

    #[test]
    fn a_union_has_all_parts_of_both_and_no_other() {
        for (a, b) in all().flat_map(|a| all().map(move |b| (a, b))) {
            for has in [BakeParts::environment, BakeParts::sources, BakeParts::meshless] {
                assert_eq!(has(a.with(b)), has(a) || has(b), "{a} with {b}");
            }
        }
        assert_eq!(BakeParts::ENVIRONMENT.with(BakeParts::INDIRECT), BakeParts::CUTS);
    }

    #[test]
    fn every_set_is_read_as_it_is_written_and_named_ones_as_ever() {
        for parts in all() {
            assert_eq!(parts.to_string().parse(), Ok(parts));
            let json = serde_json::to_string(&parts).unwrap();
            assert_eq!(json, format!("\"{parts}\""));
            assert_eq!(serde_json::from_str::<BakeParts>(&json).unwrap(), parts);
        }
        for (name, parts) in BakeParts::NAMED {
            assert_eq!(parts.to_string(), name);
        }
        assert_eq!("environment,indirect".parse(), Ok(BakeParts::CUTS));
        assert_eq!(" meshless, environment".parse(), Ok(BakeParts::ENVIRONMENT_MESHLESS));
        assert_eq!(BakeParts::ENVIRONMENT_MESHLESS.to_string(), "environment,meshless");
        for bad in ["", "sun", "all,", "environment meshless"] {
            assert_eq!(bad.parse::<BakeParts>(), Err(PartsError(bad.into())));
        }
    }
}
