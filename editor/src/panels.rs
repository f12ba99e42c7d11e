//! The panels around the viewport. They read the document and say what they want done as actions.

pub mod material;
pub mod presets;
pub mod widgets;
