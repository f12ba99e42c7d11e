//! The vertices of a scene: the sides on which light arrives, the density of vertices, the points where they sample,
//! and what they see from there.

pub mod pilot;
pub mod points;
pub mod sampler;
pub mod side;
pub mod sidedness;
mod spread;
pub mod tessellate;
pub mod tracing;
pub mod visibility;
pub mod z_order;
