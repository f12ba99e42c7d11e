//! What lights a picture: the environment on its tree, local lights, and what both bounce.

pub(crate) mod bounce;
pub(crate) mod buried;
pub(crate) mod components;
pub(crate) mod direct;
pub(crate) mod environment;
pub(crate) mod local;
