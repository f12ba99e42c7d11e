//! The phases of a bake, one file each, and computing and packing their chunks.

mod audit;
pub mod bounces;
pub mod chunks;
pub mod environment;
pub mod fit;
pub mod geometry;
pub mod light_tree;
mod meshless;
mod object_bases;
pub mod pack;
pub mod point_cuts;
mod sources;
