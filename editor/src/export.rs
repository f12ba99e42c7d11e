//! Finished pictures for files, from the window and the command line alike: what decides them, rendering them, their layers,
//! and what the files say about them.

mod layers;
mod look;
mod metadata;
mod studio;

pub use layers::{LayerKind, LayerList, take_layers};
pub use look::Look;
pub use metadata::{layered, settings};
pub use studio::{Studio, Taken};
