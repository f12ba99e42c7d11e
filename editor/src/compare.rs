//! The comparison with a reference: its strip, the pointer over both pictures, and the requests that follow the picture.

mod follow;
pub mod panel;
mod pointer;
mod state;

pub use pointer::interact;
pub use state::Comparison;
