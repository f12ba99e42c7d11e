//! The phases of a bake, a file each, and what makes their chunks and packs them.

pub mod bounces;
mod chunks;
pub mod environment;
pub mod fit;
pub mod geometry;
pub mod light_tree;
mod meshless;
pub mod pack;
mod sources;
