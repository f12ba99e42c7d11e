//! Which cut size is enough? Pictures of growing cuts against a reference.

pub mod panel;
mod state;
mod window;

pub use state::LadderWindow;
