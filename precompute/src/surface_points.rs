//! Points scattered over the surfaces that light can reach (meshless basis paper, 2.3), found by ray casts alone:
//! candidates by importance tracing, Poisson-disk sets of them by dart throwing, and the area that each point stands for.

mod areas;
mod candidates;
mod cells;
mod disk;
mod spacing;
mod viewpoint;

pub use areas::sample_areas;
pub use candidates::Candidates;
pub use disk::{Darts, poisson_count, poisson_disk, poisson_levels};
pub use spacing::Spacing;
pub use viewpoint::{Surroundings, find_viewpoint};

#[cfg(test)]
mod tests;
