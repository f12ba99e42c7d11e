//! The ladder: one picture at growing illumination cuts (paper, Fig. 7), and one with lit cuts, each compared with ray tracing. It
//! shows the sufficient size for a shot, and the cost and benefit of lit cuts.
//!
//! [`climb()`] renders the pictures, traces the reference, and passes on each result; command, demonstration and window share it.
//! [`write_picture`], [`sheet()`] and [`page()`] present the results.

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

/// Sizes of the illumination cut, from a single node to the size that the paper found sufficient for glossy surfaces.
pub const SIZES: [u32; 6] = [1, 32, 64, 128, 256, 512];

#[cfg(test)]
mod tests;
