//! The light of a picture: the environment on its tree, local lights, and the bounced light of both.

pub(crate) mod bounce;
pub(crate) mod buried;
pub(crate) mod components;
pub(crate) mod drift;
pub(crate) mod environment;
pub(crate) mod implicit;
pub(crate) mod in_view;
pub(crate) mod light_counts;
pub(crate) mod local;
pub(crate) mod mirrored_map;
pub(crate) mod node_row;
pub(crate) mod sent;
pub(crate) mod situation;
pub(crate) mod sky;
pub(crate) mod solver;
pub(crate) mod tree_light;
