//! Broken inputs for all that reads files: scenes, pictures, datasets, checkpoints, sessions, lights, materials.
//!
//! A [`Target`](targets::Target) makes an input of [`Choices`](choices::Choices), which are bytes, and reads it. An input
//! is a finding if reading it panics, aborts, takes longer than [`MOST_SECS`] or more memory than [`MOST_BYTES`], if
//! something that is not finite comes out, or if the error does not name the file. [`driver`] tries many inputs on all
//! cores; `tests/targets.rs` hands the same functions to bolero, and so to libFuzzer and AFL.

pub mod choices;
pub mod driver;
pub mod mutate;
pub mod targets;
mod worker;

use cap::Cap;
use std::alloc::System;

/// Seconds that an input may take.
pub const MOST_SECS: f64 = 10.0;

/// Bytes that a process may have beside what it has before its first input.
pub const MOST_BYTES: usize = 512 << 20;

/// Counts the memory in use. Beyond the limit there is none, as on a machine without more.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, usize::MAX);

/// Limits memory to what is in use and [`MOST_BYTES`].
pub fn limit_memory() {
    let limit = MEMORY.allocated() + MOST_BYTES;
    assert!(MEMORY.set_limit(limit).is_ok(), "more is in use than is allowed");
}
