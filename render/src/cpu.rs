//! Pictures on the cores of this machine.

pub(crate) mod backend;
pub(crate) mod display;
pub(crate) mod picture;
pub(crate) mod sketch;
pub(crate) mod surface_layers;
