//! Forwards the messages of a bake to the observer, and keeps warnings about its result for the report.

use crate::observer::{Event, Observer};
use std::sync::{Mutex, PoisonError};

/// Forwards all messages, and keeps warnings about the result.
pub(super) struct Remarks<'a> {
    observer: &'a dyn Observer,
    warnings: Mutex<Vec<String>>,
}

impl<'a> Remarks<'a> {
    pub fn before(observer: &'a dyn Observer) -> Self {
        Self { observer, warnings: Mutex::default() }
    }

    /// The warnings so far.
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Observer for Remarks<'_> {
    fn event(&self, event: Event) {
        if let Event::Warning { message } = &event
            && !message.is_about_resuming()
        {
            let (mut warnings, text) =
                (self.warnings.lock().unwrap_or_else(PoisonError::into_inner), message.to_string());
            // A device that has no room says so in each phase.
            if warnings.contains(&text) {
                return;
            }
            warnings.push(text);
        }
        self.observer.event(event);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}
