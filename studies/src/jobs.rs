//! Bakes and studies on their own threads, so that the window never waits: comparison with a reference, the ladder of cut sizes,
//! explanations of pixels, exports.
//!
//! Each takes typed requests and sends typed messages, which the window collects once per frame. [`Wake`] notifies it of new ones.

pub mod bake;
pub mod comparison;
pub mod explain;
pub mod export;
mod guest;
pub mod ladder;
pub mod measure;
mod shared_progress;

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
};

/// Notifies the window of new messages: its `request_repaint`.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// Message of a panic, for a report.
pub fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason was given")
}

/// Runs `work`; a panic becomes an error, because a thread that ends silently leaves the window waiting.
pub fn guarded<T>(what: &str, work: impl FnOnce() -> anyhow::Result<T>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(error)) => Err(crate::terminal::error_text(&error)),
        Err(panic) => Err(format!(
            "{what} failed by a mistake in Lapidary ({}); please report it, and save the session",
            panic_text(&*panic)
        )),
    }
}

/// Starts a thread with a name that debuggers show.
///
/// # Panics
/// If the system cannot start another thread.
pub fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> std::thread::JoinHandle<()> {
    let thread = std::thread::Builder::new().name(name.into()).spawn(work);
    thread.expect("the system refuses another thread")
}

#[cfg(any(test, feature = "testing"))]
pub mod testing {
    //! Shared helpers for the tests of all jobs.

    use super::Wake;
    use std::{
        sync::Arc,
        time::{Duration, Instant},
    };

    /// A wake without effect.
    pub fn silent() -> Wake {
        Arc::new(|| ())
    }

    /// Timeout for an answer: far longer than usual, because other tests keep the cores busy.
    const PATIENCE: Duration = Duration::from_secs(90);

    /// Polls until there is an answer.
    ///
    /// # Panics
    /// If there is none within [`PATIENCE`].
    pub fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if let Some(answer) = ask() {
                return answer;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        panic!("waited in vain for {what}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_and_panics_become_text() {
        assert_eq!(guarded("it", || Ok(7)), Ok(7));
        assert_eq!(guarded::<()>("it", || anyhow::bail!("no such file")), Err("no such file".into()));
        let panicked = guarded::<()>("loading", || panic!("index {}", 3)).unwrap_err();
        assert!(panicked.contains("loading failed") && panicked.contains("index 3"), "{panicked}");
    }
}
