//! Output besides results: warnings and notes on standard error, summaries on standard output.

use super::print_out;
use anyhow::Result;
use std::fmt::Display;

/// Prints unless quiet.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    /// Print nothing.
    pub quiet: bool,
}

impl Console {
    /// Reports a repair or omission.
    pub fn warning(self, message: impl Display) {
        if !self.quiet {
            eprintln!("warning: {message}");
        }
    }

    /// Reports other information.
    pub fn note(self, message: impl Display) {
        if !self.quiet {
            eprintln!("note: {message}");
        }
    }

    /// Reports the result.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn summary(self, text: impl Display) -> Result<()> {
        if self.quiet { Ok(()) } else { print_out(&format!("{text}\n")) }
    }
}
