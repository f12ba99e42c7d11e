//! Progress of a reference on standard error.

use super::{ProgressReporter, phase_bar};
use indicatif::ProgressBar;
use lapidary_precompute::Observer;
use lapidary_render::Progress;
use std::io::IsTerminal;

/// A bar with rate and time left, and the flag set by Ctrl-C.
pub struct StepProgress<'a> {
    bar: ProgressBar,
    interrupt: &'a ProgressReporter,
}

impl<'a> StepProgress<'a> {
    /// A step that counts in `unit`; `interrupt` stops it.
    pub fn new(name: &str, unit: &str, interrupt: &'a ProgressReporter, quiet: bool) -> Self {
        let shown = !quiet && std::io::stderr().is_terminal();
        let bar = if shown { phase_bar(name, 1, unit) } else { ProgressBar::hidden() };
        Self { bar, interrupt }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for StepProgress<'_> {
    fn advanced(&self, done: u64, total: u64) {
        self.bar.set_length(total);
        self.bar.set_position(done);
    }

    fn cancelled(&self) -> bool {
        self.interrupt.cancelled()
    }
}
