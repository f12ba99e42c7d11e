//! How a command ended, as scripts see it.

use lapidary_precompute::BakeError;
use std::{error::Error, fmt, process::ExitCode};

/// Ctrl-C, where there is nothing to keep.
#[derive(Debug)]
pub struct Interrupted;

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("stopped by Ctrl-C")
    }
}

impl Error for Interrupted {}

/// How a command ended; 2 is clap's, for options that make no sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All was done.
    Done = 0,
    /// Something could not be read, written or computed.
    Failed = 1,
    /// `compare` or `bench --against` found a figure outside the given bounds.
    OutOfBounds = 3,
    /// Ctrl-C; the number is 128 and the signal's, as shells have it.
    Interrupted = 130,
}

impl Outcome {
    /// Ctrl-C or failure.
    pub fn of_error(error: &anyhow::Error) -> Self {
        let cancelled = matches!(error.downcast_ref(), Some(BakeError::Cancelled));
        if cancelled || error.is::<Interrupted>() { Self::Interrupted } else { Self::Failed }
    }
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(outcome as u8)
    }
}
