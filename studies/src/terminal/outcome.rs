//! Exit codes of commands.

use lapidary_precompute::BakeError;
use std::{error::Error, fmt, process::ExitCode};

/// Ctrl-C without anything to keep.
#[derive(Debug)]
pub struct Interrupted;

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("stopped by Ctrl-C")
    }
}

impl Error for Interrupted {}

/// How a command ended; 2 is clap's, for invalid options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Success.
    Done = 0,
    /// A failure to read, write or compute.
    Failed = 1,
    /// `compare` or `bench --against` found a figure outside the given bounds.
    OutOfBounds = 3,
    /// Ctrl-C; 128 plus the signal number, as in shells.
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
