//! One file for each command; `info` and `verify` lie in `lapidary_precompute::cli`, the demonstration in `demo`.

pub mod bake;
pub mod bench;
pub mod bounces;
pub mod compare;
pub mod edit;
pub mod explain;
pub mod export;
pub mod ladder;
pub mod predict;
pub mod reference;
pub mod render;
pub mod sequence;
