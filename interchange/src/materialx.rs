//! MaterialX documents (Academy Software Foundation, version 1.39 and back to 1.38): the surfaces `open_pbr_surface`,
//! `standard_surface` and `gltf_pbr`, with values and pictures, to and from materials of the model `openpbr`.
//!
//! `open_pbr_surface` is read and written name by name. The others follow the translations that MaterialX publishes
//! (`libraries/bxdf/translation`) but for four things. A coat stays on a metal, and its color tints once. The width of a
//! stretched lobe is kept, not the number that stretches it; see [`stretch`]. The coat's darkening is what the coat does to colors.
//!
//! Coordinates of MaterialX begin at the bottom of a picture, here at the top; `placement` converts them.

mod candidates;
mod estimate;
mod graph;
mod nearest;
mod placement;
mod read;
pub mod stretch;
mod surface;
#[cfg(test)]
mod tests;
mod write;

pub(crate) use estimate::without_file;
pub(crate) use nearest::nearest;
pub use read::{MaterialXError, ReadMaterial, names, read};
pub use surface::Surface;
pub use write::{Written, write};
