//! The ladder of cut sizes: pictures of growing cuts against a reference.

pub mod panel;
mod state;
mod window;

pub use state::LadderWindow;
