//! What is done with baked scenes beside editing them: pictures, sequences, references, comparisons and measurements, as
//! commands and for the window alike.
//!
//! [`commands`] has a file for each command, [`args`] the options that several of them share, [`terminal`] what they say,
//! [`outputs`] what is checked before they write. What they say of one part of a bake is in a file of `bake_parts`.
//! Each study is a folder: [`ladder`] (which size of the illumination cut is enough), [`sequence`] (turntables and sweeps),
//! bounces (how far solutions of bounced light are from light paths), evidence (the paper's figures measured anew), [`export`]
//! (pictures with layers, scenes for Mitsuba), [`demo`].

pub mod args;
mod bake_parts;
mod bounces;
pub mod bundled;
pub mod commands;
pub mod demo;
mod evidence;
pub mod export;
pub mod jobs;
pub mod ladder;
pub mod missing_light;
pub mod outputs;
pub mod report;
pub mod sequence;
pub mod sheet;
pub mod terminal;
pub mod values;
