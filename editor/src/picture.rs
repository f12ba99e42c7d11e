//! The picture on the screen: what it was asked for by, and the files that it is written to.

mod files;
mod requests;
mod state;

pub use state::Picture;
