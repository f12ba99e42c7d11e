//! What is said besides results: warnings and notes on standard error, summaries on standard output.

use super::print_out;
use anyhow::Result;
use std::fmt::Display;

/// Says something unless it is to be quiet.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    /// Say nothing.
    pub quiet: bool,
}

impl Console {
    /// Something was repaired or left out.
    pub fn warning(self, message: impl Display) {
        if !self.quiet {
            eprintln!("warning: {message}");
        }
    }

    /// Something worth knowing.
    pub fn note(self, message: impl Display) {
        if !self.quiet {
            eprintln!("note: {message}");
        }
    }

    /// What was done.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn summary(self, text: impl Display) -> Result<()> {
        if self.quiet { Ok(()) } else { print_out(&format!("{text}\n")) }
    }
}
