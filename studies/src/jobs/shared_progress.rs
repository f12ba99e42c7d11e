//! State shared by the window and a worker: progress and cancellation.

use super::Wake;
use lapidary_render::Progress;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::SeqCst};

/// Shared by both; keep it in an `Arc`.
pub struct SharedProgress {
    wake: Wake,
    cancelled: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
}

impl SharedProgress {
    /// Starts at zero; `wake` notifies the window.
    pub fn new(wake: Wake) -> Self {
        Self { wake, cancelled: false.into(), done: 0.into(), total: 0.into() }
    }

    /// Notifies the window.
    pub fn wake(&self) {
        (self.wake)();
    }

    /// Asks the worker to stop.
    pub fn cancel(&self) {
        self.cancelled.store(true, SeqCst);
    }

    /// Completed and total units of work; 0 while unknown.
    pub fn counts(&self) -> (u64, u64) {
        (self.done.load(SeqCst), self.total.load(SeqCst))
    }

    /// Completed share, 0 to 1.
    pub fn share(&self) -> f32 {
        let (done, total) = self.counts();
        if total == 0 { 0.0 } else { done as f32 / total as f32 }
    }
}

impl Progress for SharedProgress {
    fn advanced(&self, done: u64, total: u64) {
        self.done.store(done, SeqCst);
        self.total.store(total, SeqCst);
        self.wake();
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(SeqCst)
    }

    fn abandoned(&self) -> bool {
        self.cancelled()
    }
}
