//! Finished pictures for files, from the window and the command line: rendering, layers, and metadata.

pub mod backplate;
mod files;
mod layers;
pub mod materials;
mod metadata;
pub mod mitsuba;
mod studio;

pub use files::{Finished, check_pictures, has_extension, is_exr, wanted_layers, write_pictures};
pub use layers::{LayerKind, LayerList, take_layers};
pub use metadata::{layered, settings};
pub use studio::{Studio, Taken};
