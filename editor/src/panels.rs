//! The panels around the viewport. They read the document and return their requests as actions.

pub mod comparison;
pub mod environment;
pub mod explain;
pub mod ladder;
pub mod lights;
pub mod material;
pub mod scene;
pub mod timeline;
pub mod view;
