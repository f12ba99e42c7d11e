//! The picture on the screen: its request, and the files to which it is written.

mod backplate;
mod files;
mod requests;
mod state;

pub use state::Picture;
