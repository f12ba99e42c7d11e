//! Points on the surfaces that light can reach (meshless basis paper, 2.3), found by ray casts alone: candidates by importance
//! tracing, Poisson-disk sets of them by dart throwing, and the area that each point represents.
//!
//! Also the surface sources made of them: their positions, their tree, and their solid angles from a bake point.

pub mod areas;
pub mod candidates;
mod cells;
pub mod disk;
pub mod error;
pub mod order;
pub mod placement;
pub mod sampler;
mod spacing;
pub mod viewpoint;

#[cfg(test)]
mod tests;
