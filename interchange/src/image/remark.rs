//! What of a picture's header is left out.

use super::open_exr::listed;
use lapidary_core::{image::ImageError, texture::ColorSpace};
use std::path::Path;

/// What of a header cannot be used.
#[derive(Debug)]
pub(super) enum Remark {
    /// What the colors are, as a sentence. It does not matter where a color space is given.
    Colors(String),
    /// What scales the colors, as a sentence.
    Scale(String),
    /// The file shows none of its layers by default. The first of these is shown.
    Layers(Vec<String>),
}

impl Remark {
    /// The sentence for a picture that is shown all the same.
    pub fn text(&self) -> String {
        match self {
            Self::Colors(text) | Self::Scale(text) => text.clone(),
            Self::Layers(names) => {
                let (first, other) = (&names[0], names.get(1).unwrap_or(&names[0]));
                let has = listed(names);
                format!(
                    "it has no R, G, B or Y, but {has}; {first} is shown, and another is chosen as in FILE.exr#{other}"
                )
            }
        }
    }

    /// Whether it is of no matter to colors in this space.
    pub fn is_settled_by(&self, color_space: ColorSpace) -> bool {
        matches!(self, Self::Colors(_)) && color_space != ColorSpace::Srgb
    }

    /// The error for a picture that is not read without it.
    pub fn refusal(&self, path: &Path) -> ImageError {
        let reason = match self {
            Self::Colors(text) | Self::Scale(text) => text.clone(),
            Self::Layers(names) => {
                let (has, first) = (listed(names), &names[0]);
                format!(
                    "it has no R, G, B or Y, but {has}; choose one by its name after the file, as in FILE.exr#{first}"
                )
            }
        };
        super::read::damaged(path, reason)
    }
}
