//! The vertices of a scene: sides on which light arrives, density, sample points, and visibility from there.

pub mod pilot;
pub mod points;
pub mod sampler;
pub mod side;
pub mod sidedness;
mod spread;
pub mod tessellate;
pub mod tracing;
mod until_failure;
pub mod visibility;
pub mod z_order;
