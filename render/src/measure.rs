//! How much two pictures differ, and where the difference comes from.

pub mod compare;
pub(crate) mod cut_light;
pub(crate) mod explain;
pub(crate) mod lettering;
pub(crate) mod predict;
mod region;
pub(crate) mod split;
