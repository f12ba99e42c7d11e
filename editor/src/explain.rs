//! A window that explains a pixel of the picture, and splits the error around it.

pub mod panel;
mod state;
mod window;

pub use state::ExplainWindow;
