//! Pictures that trace rays where the renderer uses cuts.

mod direct;
pub(crate) mod path;
pub(crate) mod samples;
