//! Errors of settings.

use crate::setting::{Naming, Setting};
use lapidary_core::{bounds::MOST_COORDINATE, camera::field_of_view_range, light_tree::LightCountError};
use std::fmt;
use thiserror::Error;

/// Invalid settings.
#[derive(Debug, Error, PartialEq)]
pub enum SettingsError {
    /// Invalid number of lights.
    Lights(#[from] LightCountError),
    /// Invalid number of surface sources.
    Sources(usize),
    /// A shot, counted from 1, with a camera without a direction.
    Shot(usize),
    /// A number outside its range.
    Range {
        /// The setting.
        setting: Setting,
        /// Its value.
        value: f64,
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
    },
}

impl SettingsError {
    /// The message, with settings named by `name`.
    pub fn text(&self, name: Naming) -> String {
        match self {
            Self::Lights(error) => error.to_string(),
            Self::Sources(count) => format!(
                "{count} surface sources make no complete binary tree; use a power of two from 2 to 32768 for {}",
                name(Setting::Sources)
            ),
            Self::Shot(number) => format!(
                "shot {number} looks nowhere; give an eye, another place to look at, both within {MOST_COORDINATE:e} m of the \
                 origin, a field of view of {} and a width over height above 0",
                field_of_view_range()
            ),
            Self::Range { setting, value, low, high } => {
                format!("{} is {value}, but must lie between {low} and {high}", name(*setting))
            }
        }
    }
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Setting::name))
    }
}
