//! Signals from the window to the tracing thread.

use std::{
    sync::{
        Condvar, Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering::SeqCst},
    },
    time::{Duration, Instant},
};

/// State shared by both.
#[derive(Default)]
pub struct Control {
    /// Number of the current comparison.
    wanted: AtomicU64,
    paused: AtomicBool,
    /// Whether other work needs the cores.
    held: AtomicBool,
    /// Wakes threads that wait for the end of a pause.
    resumed: Condvar,
    /// Whether the tracing thread is waiting.
    waiting: Mutex<bool>,
    /// Units of work: completed and total.
    done: AtomicU64,
    total: AtomicU64,
}

impl Control {
    /// Abandons the current work, resumes after a pause, and returns the number of the next comparison.
    pub fn begin(&self) -> u64 {
        self.advanced(0, 0);
        let number = self.wanted.fetch_add(1, SeqCst) + 1;
        self.pause(false);
        number
    }

    /// The number of the current comparison.
    pub fn wanted(&self) -> u64 {
        self.wanted.load(SeqCst)
    }

    /// Pauses or resumes.
    pub fn pause(&self, paused: bool) {
        self.paused.store(paused, SeqCst);
        self.wake();
    }

    /// Yields the cores to other work, or resumes.
    pub fn hold(&self, held: bool) {
        if self.held.swap(held, SeqCst) != held {
            self.wake();
        }
    }

    fn wake(&self) {
        let _waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        self.resumed.notify_all();
    }

    /// Whether it is paused.
    pub fn is_paused(&self) -> bool {
        self.paused.load(SeqCst)
    }

    /// Whether it yields the cores.
    pub fn is_held(&self) -> bool {
        self.held.load(SeqCst)
    }

    /// Waits while held or paused, unless `number` is no longer the current comparison. Returns the time waited.
    pub fn wait(&self, number: u64) -> Duration {
        let start = Instant::now();
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        while (self.is_paused() || self.is_held()) && self.wanted() == number {
            *waiting = true;
            waiting = self.resumed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
        *waiting = false;
        start.elapsed()
    }

    /// Whether the tracing thread has reached the end of its pass and waits.
    #[cfg(test)]
    pub fn is_waiting(&self) -> bool {
        *self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores the progress of the reference.
    pub fn advanced(&self, done: u64, total: u64) {
        self.done.store(done, SeqCst);
        self.total.store(total, SeqCst);
    }

    /// Completed share, 0 to 1.
    pub fn progress(&self) -> f32 {
        let total = self.total.load(SeqCst);
        if total == 0 { 0.0 } else { self.done.load(SeqCst) as f32 / total as f32 }
    }
}
