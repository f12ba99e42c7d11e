//! Broken inputs for all readers: scenes, pictures, datasets, checkpoints, sessions, lights, materials.
//!
//! A [`Target`](targets::Target) makes an input from [`Choices`](choices::Choices), which are bytes, and reads it. An
//! input is a finding if its reader panics, aborts, takes longer than [`MOST_SECS`] or more memory than [`MOST_BYTES`],
//! if a result is not finite, or if the error does not name the file. [`driver`] tries many inputs on all cores;
//! `tests/targets.rs` passes the same functions to bolero, and so to libFuzzer and AFL.

pub mod choices;
pub mod driver;
pub mod mutate;
pub mod targets;
mod worker;

use cap::Cap;
use std::alloc::System;

/// Time limit of an input in seconds.
pub const MOST_SECS: f64 = 10.0;

/// Memory limit of a process in bytes, beyond its use before the first input.
pub const MOST_BYTES: usize = 512 << 20;

/// Counts the memory in use. Allocations beyond the limit fail, as on a machine without more.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, usize::MAX);

/// Limits memory to the current use plus [`MOST_BYTES`].
pub fn limit_memory() {
    let limit = MEMORY.allocated() + MOST_BYTES;
    assert!(MEMORY.set_limit(limit).is_ok(), "more is in use than is allowed");
}
