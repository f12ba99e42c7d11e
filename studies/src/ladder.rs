//! The ladder: one picture at growing illumination cuts (paper, Fig. 7), and one with lit cuts, each held against ray tracing. It
//! says which size is enough for a shot, and what lit cuts cost and gain.
//!
//! [`climb()`] makes the pictures and traces the truth, and hands each result on as it comes; command, demonstration and window
//! share it. [`write_picture`], [`sheet()`] and [`page()`] show what came of it.

mod climb;
mod cuts;
mod files;
mod page;
mod truth;

pub use climb::{Found, Ladder, Rung, Settings, Step, climb, time_frames};
pub use cuts::Cuts;
pub use files::{Summary, sheet, write_picture};
pub use page::{charts, page, pictures};
pub use truth::{BOUNCES_AS_BAKED, Truth, every_sample};

/// Sizes of the illumination cut, from the light as one lump to what the paper found to be enough for glossy surfaces.
pub const SIZES: [u32; 6] = [1, 32, 64, 128, 256, 512];

#[cfg(test)]
mod tests;
