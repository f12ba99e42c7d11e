//! Slow work of the window on its own threads: rendering, loading, watching files, thumbnails.

pub mod budget;
mod imported;
pub mod kept_bakes;
pub mod load;
pub mod opening;
pub mod render_thread;
pub mod thumbnails;
pub mod watch;

pub use imported::Imported;
