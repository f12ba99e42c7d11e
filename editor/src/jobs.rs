//! Slow work of the window beside the studies, on its own threads: rendering, loading, baking, watching files, and
//! pictures for the library.

pub mod bake;
pub mod budget;
mod guest;
mod imported;
pub mod kept_bakes;
pub mod load;
pub mod render_thread;
pub mod thumbnails;
pub mod watch;

pub use imported::Imported;
