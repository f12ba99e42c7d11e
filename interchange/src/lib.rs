//! Formats of other programs, in and out.
//!
//! What a file holds becomes the data of `lapidary-core`, which knows none of these formats.
//!
//! * [`formats`]: the lists of all formats
//! * [`import`]: scenes and materials; [`export`]: materials of a scene, back to their formats
//! * [`materialx`]: materials in and out of MaterialX documents
//! * [`animation`]: clips, skins and morph targets of glTF files
//! * [`image`]: files of pictures; [`environment`]: environments by the name of a file or of a formula

pub mod animation;
pub mod environment;
pub mod export;
mod file_format;
pub mod formats;
pub mod image;
pub mod import;
mod material_file;
pub mod materialx;
mod names;
