//! Parts of light transport that a bake prepares.

use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};
use thiserror::Error;

macro_rules! bake_parts {
    ($($(#[doc = $doc:literal])* $part:ident($has:ident) = $key:literal, $noun:literal;)*) => {
        /// A part of a bake; each can be baked without the others.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum BakePart {
            $($(#[doc = $doc])* $part,)*
        }

        impl BakePart {
            /// All parts, in the order of baking.
            pub const ALL: &'static [Self] = &[$(Self::$part,)*];

            /// Its name in files and options.
            pub const fn key(self) -> &'static str {
                match self { $(Self::$part => $key,)* }
            }

            /// Its noun for messages.
            pub const fn noun(self) -> &'static str {
                match self { $(Self::$part => $noun,)* }
            }
        }

        impl BakeParts {
            $(
                #[doc = concat!("Whether [`BakePart::", stringify!($part), "`] is baked.")]
                pub fn $has(self) -> bool {
                    self.has(BakePart::$part)
                }
            )*
        }
    };
}

// A new part needs a line here, and one in each table of its users: [`super::stored`] for the file, `precompute` for
// the bake, `studies` for its options, `editor` for its controls.
bake_parts! {
    /// Visibility of distant light.
    Environment(environment) = "environment", "visibility of the environment";
    /// Surface sources and the vertices' cuts over them.
    Sources(sources) = "indirect", "surface sources";
    /// The meshless basis and its transport operator.
    Meshless(meshless) = "meshless", "meshless basis";
    /// Functions of each object, for light that is solved anew after a move.
    ObjectBases(object_bases) = "radiosity", "bases of objects";
    /// Wavelet transport between quads.
    Wavelet(wavelet) = "wavelet", "wavelet transport";
}

impl BakePart {
    /// Whether it belongs to bounced light.
    pub fn bounces(self) -> bool {
        self != Self::Environment
    }
}

/// A set of bake parts, empty only for [`Self::NONE`]. Parts that are not baked are dark: their cuts are one node
/// without visibility.
///
/// In files and options a set has a name, or the comma-separated names of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct BakeParts {
    /// Bit `i` for part `i` of [`BakePart::ALL`].
    bits: u8,
}

impl BakeParts {
    /// No part: parts missing from a dataset, or its bounced light.
    pub const NONE: Self = Self { bits: 0 };
    /// Visibility of distant light.
    pub const ENVIRONMENT: Self = Self::only(BakePart::Environment);
    /// Surface sources and the vertices' cuts over them.
    pub const INDIRECT: Self = Self::only(BakePart::Sources);
    /// Both, with the sources' cuts over the environment: all light that cuts gather.
    pub const CUTS: Self = Self::ENVIRONMENT.with(Self::INDIRECT);
    /// The meshless basis and its transport operator.
    pub const MESHLESS: Self = Self::only(BakePart::Meshless);
    /// Functions of each object.
    pub const RADIOSITY: Self = Self::only(BakePart::ObjectBases);
    /// Wavelet transport between quads.
    pub const WAVELET: Self = Self::only(BakePart::Wavelet);
    /// Visibility of distant light and the meshless basis, without surface sources.
    pub const ENVIRONMENT_MESHLESS: Self = Self::ENVIRONMENT.with(Self::MESHLESS);
    /// Environment, sources and basis: the meaning of `all` in files, which stays when there are more parts.
    pub const ALL: Self = Self::CUTS.with(Self::MESHLESS);

    /// Named sets of more than one part. Others are written as the names of their parts.
    const NAMED: [(&str, Self); 2] = [("cuts", Self::CUTS), ("all", Self::ALL)];

    /// One part.
    pub const fn only(part: BakePart) -> Self {
        Self { bits: 1 << part as u8 }
    }

    /// Whether a part is baked.
    pub const fn has(self, part: BakePart) -> bool {
        self.bits & Self::only(part).bits != 0
    }

    /// Whether all parts of another set are baked.
    pub const fn has_all(self, other: Self) -> bool {
        self.bits & other.bits == other.bits
    }

    /// The union of both sets.
    pub const fn with(self, other: Self) -> Self {
        Self { bits: self.bits | other.bits }
    }

    /// The parts of this set that are not in the other.
    pub const fn without(self, other: Self) -> Self {
        Self { bits: self.bits & !other.bits }
    }

    /// Its parts, in the order of baking.
    pub fn parts(self) -> impl Iterator<Item = BakePart> {
        BakePart::ALL.iter().copied().filter(move |part| self.has(*part))
    }

    /// Whether a part of bounced light is baked.
    pub fn bounces(self) -> bool {
        self.parts().any(BakePart::bounces)
    }

    /// The set called `name`.
    fn named(name: &str) -> Option<Self> {
        let of_part = BakePart::ALL.iter().find(|part| part.key() == name).map(|part| Self::only(*part));
        of_part.or(Self::NAMED.into_iter().find(|(known, _)| *known == name).map(|(_, parts)| parts))
    }
}

impl Default for BakeParts {
    fn default() -> Self {
        Self::ENVIRONMENT
    }
}

/// A text that does not name parts of a bake.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("\"{0}\" is not a part of a bake; use {names}, or some of these with commas between", names = names())]
pub struct PartsError(String);

/// All names, listed as in a sentence.
fn names() -> String {
    let of_parts = BakePart::ALL.iter().map(|part| part.key());
    of_parts.chain(BakeParts::NAMED.map(|(name, _)| name)).collect::<Vec<_>>().join(", ")
}

impl FromStr for BakeParts {
    type Err = PartsError;

    fn from_str(text: &str) -> Result<Self, PartsError> {
        let parts = text.split(',').map(|name| Self::named(name.trim())).collect::<Option<Vec<_>>>();
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
        let names: Vec<&str> = self.parts().map(BakePart::key).collect();
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
        (1..32).map(|bits| BakeParts { bits })
    }

    #[test]
    fn sets_have_the_parts_that_they_are_made_of() {
        for (a, b) in all().flat_map(|a| all().map(move |b| (a, b))) {
            for has in BakePart::ALL.iter().map(|&part| move |parts: BakeParts| parts.has(part)) {
                assert_eq!(has(a.with(b)), has(a) || has(b), "{a} with {b}");
                assert_eq!(has(a.without(b)), has(a) && !has(b), "{a} without {b}");
            }
            assert_eq!(a.has_all(b), b.without(a) == BakeParts::NONE);
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
        assert_eq!(BakeParts::INDIRECT.to_string(), "indirect");
        assert_eq!("environment,indirect".parse(), Ok(BakeParts::CUTS));
        assert_eq!(" meshless, environment".parse(), Ok(BakeParts::ENVIRONMENT_MESHLESS));
        assert_eq!(BakeParts::ENVIRONMENT_MESHLESS.to_string(), "environment,meshless");
        for bad in ["", "sun", "all,", "environment meshless"] {
            assert_eq!(bad.parse::<BakeParts>(), Err(PartsError(bad.into())));
        }
    }
}
