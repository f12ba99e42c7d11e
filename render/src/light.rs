//! The light of a picture: the environment on its tree, local lights, and the bounced light of both.

pub(crate) mod bounce;
pub(crate) mod buried;
pub(crate) mod components;
pub(crate) mod direct;
pub(crate) mod environment;
pub(crate) mod local;
