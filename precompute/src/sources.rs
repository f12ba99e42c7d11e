//! Points scattered over the surfaces that light can reach (meshless basis paper, 2.3), found by ray casts alone:
//! candidates by importance tracing, Poisson-disk sets of them by dart throwing, and the area that each point stands for.
//! And the surface sources made of them: their places, their tree, and what a bake point sees of them.

mod areas;
pub mod candidates;
mod cells;
pub mod disk;
pub mod order;
pub mod placement;
pub mod sampler;
mod spacing;
pub mod viewpoint;

#[cfg(test)]
mod tests;
