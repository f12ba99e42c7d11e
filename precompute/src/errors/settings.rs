//! Why no bake can be made with some settings.

use lapidary_core::light_tree::LightCountError;
use thiserror::Error;

/// Settings that no bake can be made with.
#[derive(Debug, Error, PartialEq)]
pub enum SettingsError {
    /// Number of lights.
    #[error(transparent)]
    Lights(#[from] LightCountError),
    /// Number of surface sources.
    #[error("{0} surface sources make no complete binary tree; use a power of two from 2 to 32768 for --sources")]
    Sources(usize),
    /// A shot of a camera that looks nowhere.
    #[error(
        "shot {0} looks nowhere; give an eye, another place to look at, a field of view between 0 and 180 degrees and a \
         width over height above 0"
    )]
    Shot(usize),
    /// A number outside its range.
    #[error("{name} is {value}, but must lie between {low} and {high}")]
    Range {
        /// Which option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
    },
}
