//! From a pixel sample to the light that its surface reflects: camera ray, surface point, merge of the cuts.

pub(crate) mod background;
pub(crate) mod bumps;
pub(crate) mod differentials;
pub(crate) mod direct;
pub(crate) mod merge;
mod merged;
pub mod mirror;
pub(crate) mod mirrors;
pub(crate) mod node_field;
pub(crate) mod painter;
pub(crate) mod pixel_sampler;
pub(crate) mod point_shader;
pub(crate) mod refine;
pub(crate) mod seen_scene;
pub(crate) mod surface;
pub(crate) mod unoccluded;
pub(crate) mod wireframe;
