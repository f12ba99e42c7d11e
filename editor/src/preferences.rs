//! How the window looks, kept between runs and apart from sessions.

use serde::{Deserialize, Serialize};

/// How the window looks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Dark or light.
    pub theme: Theme,
    /// Scale of the interface; 1 is 96 points an inch.
    pub ui_scale: f32,
}

/// Dark or light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Theme {
    /// Light text on dark grey: keeps the eye on the picture.
    #[default]
    Dark,
    /// Dark text on light grey.
    Light,
}

impl Default for Preferences {
    fn default() -> Self {
        Self { theme: Theme::default(), ui_scale: 1.0 }
    }
}
