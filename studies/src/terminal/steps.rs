//! Step messages of a long command on standard error, and its interruption.

use super::{Console, Interrupted, ProgressReporter, StepProgress};
use anyhow::Result;
use lapidary_precompute::Observer;

/// Prints steps and watches for Ctrl-C.
pub struct Steps {
    console: Console,
    /// Shows the bake and holds the Ctrl-C flag.
    pub reporter: ProgressReporter,
}

impl Steps {
    /// Watches for Ctrl-C from here on.
    pub fn new(console: Console) -> Self {
        Self { console, reporter: ProgressReporter::interruptible(console) }
    }

    /// Begins a step.
    pub fn begin(&self, what: &str) {
        self.console.note(what);
    }

    /// A bar for a step that counts in `unit`.
    pub fn progress(&self, name: &str, unit: &str) -> StepProgress<'_> {
        StepProgress::new(name, unit, &self.reporter, self.console.quiet)
    }

    /// Stops after Ctrl-C.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn check(&self) -> Result<()> {
        if self.reporter.cancelled() { Err(Interrupted.into()) } else { Ok(()) }
    }
}
