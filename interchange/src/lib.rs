//! Reads and writes formats of other programs.
//!
//! File contents become the data of `lapidary-core`, which is independent of these formats.
//!
//! * [`formats`]: the lists of all formats; [`features`]: what is read of each
//! * [`import`]: scenes and materials; [`export`]: materials of a scene
//! * [`materialx`]: materials in and out of MaterialX documents
//! * [`animation`]: clips, skins and morph targets of glTF files
//! * [`image`]: picture files; [`environment`]: environments by file name or formula

pub mod animation;
pub mod environment;
pub mod export;
pub mod features;
mod file_format;
pub mod formats;
mod fresnel;
pub mod image;
pub mod import;
mod material_file;
pub mod materialx;
mod names;
