//! MaterialX documents (Academy Software Foundation, version 1.39 and back to 1.38): the surfaces `open_pbr_surface`,
//! `standard_surface` and `gltf_pbr`, with values and pictures, to and from materials of the model `openpbr`.
//!
//! `open_pbr_surface` is read and written name by name. The others follow the translations published with MaterialX
//! (`libraries/bxdf/translation`) with four exceptions. A coat stays on a metal, and its color tints once. The width of a
//! stretched lobe is kept, not its anisotropy; see [`stretch`]. The coat's darkening is the effect of the coat on colors.
//!
//! Texture coordinates begin at the bottom of a picture in MaterialX, and at the top here; `placement` converts them.

mod candidates;
mod color_spaces;
mod estimate;
mod graph;
mod include;
mod nearest;
mod placement;
mod places;
mod read;
pub mod stretch;
mod surface;
#[cfg(test)]
mod tests;
mod write;

pub(crate) use estimate::without_file;
pub(crate) use include::{Expanded, Library, expanded};
pub(crate) use nearest::nearest;
pub(crate) use read::read_expanded;
pub use read::{MaterialXError, ReadMaterial, names, read};
pub use surface::Surface;
pub use write::{Written, write};
