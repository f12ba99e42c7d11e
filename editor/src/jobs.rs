//! Slow work that the window needs beside the studies, on threads of its own: rendering, loading, baking, watching files, and
//! pictures for the library.

pub mod bake;
pub mod budget;
mod imported;
pub mod load;
pub mod render_thread;
pub mod thumbnails;
pub mod watch;

pub use imported::Imported;
