//! Pictures on the cores of this machine, whole or in steps.

pub(crate) mod backend;
pub(crate) mod display;
mod picture;
pub(crate) mod render;
pub(crate) mod surface_layers;
