//! Reference pictures, which trace rays instead of using cuts.

mod direct;
pub(crate) mod path;
pub(crate) mod samples;
