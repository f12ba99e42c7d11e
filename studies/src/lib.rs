//! Work on baked scenes other than editing: pictures, sequences, references, comparisons and measurements, as commands and for the
//! window.
//!
//! [`commands`] has a file for each command, [`args`] their shared options, [`terminal`] their output, [`outputs`] the checks
//! before writing. Texts and options of one part of a bake are in a file of `bake_parts`. Each study is a folder: [`ladder`] (the
//! sufficient size of the illumination cut), [`sequence`] (turntables and sweeps), bounces (errors of solutions of bounced light
//! against light paths), evidence (the paper's figures measured anew), [`export`] (pictures with layers, scenes for Mitsuba),
//! [`demo`].

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
mod timing;
pub mod values;
