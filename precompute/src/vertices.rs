//! The vertices of a scene: which sides of it are lit, where vertices go, where they sample, and what they see from there.

pub mod pilot;
pub mod points;
pub mod sampler;
pub mod side;
pub mod sidedness;
mod spread;
pub mod tessellate;
pub mod visibility;
