//! The components of a picture's light.

use serde::{Deserialize, Serialize};
use std::{fmt, str::FromStr};

/// Parts of a picture's light. Pictures of single parts sum to the whole picture.
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
    /// All components.
    pub const ALL: Self = Self { environment: true, direct: true, indirect: true };
    /// No component.
    pub const NONE: Self = Self { environment: false, direct: false, indirect: false };
    /// All but bounced light.
    pub const UNBOUNCED: Self = Self { indirect: false, ..Self::ALL };
}

impl FromStr for Components {
    type Err = String;

    /// Parses a comma-separated list of `environment`, `direct` and `indirect`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut components = Self::NONE;
        for name in text.split(',').map(str::trim) {
            match name {
                "environment" => components.environment = true,
                "direct" => components.direct = true,
                "indirect" => components.indirect = true,
                _ => return Err(format!("\"{name}\" is not a component; list environment, direct or indirect")),
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
}
