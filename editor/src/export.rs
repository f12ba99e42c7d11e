//! Finished pictures for files, from the window and the command line alike: rendering them, their layers, and what the
//! files say about them.

mod layers;
mod metadata;
mod studio;

pub use layers::{LayerKind, LayerList, take_layers};
pub use metadata::{layered, settings};
pub use studio::{Studio, Taken};
