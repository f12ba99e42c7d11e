//! Bakes and studies on threads of their own, so that a window never waits for them: the comparison with a reference, the ladder
//! of cut sizes, explanations of pixels, exports.
//!
//! Each takes typed requests and gives typed messages, which the window collects once a frame. [`Wake`] makes it look when there
//! are some.

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

/// Tells the window that there is something to collect: its `request_repaint`.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// What a panic said, for a report.
pub fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason was given")
}

/// Runs `work`; a panic in it becomes an error that says so, since a thread that ends in silence leaves the window
/// waiting.
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
/// If the system has no thread left.
pub fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> std::thread::JoinHandle<()> {
    let thread = std::thread::Builder::new().name(name.into()).spawn(work);
    thread.expect("the system refuses another thread")
}

#[cfg(any(test, feature = "testing"))]
pub mod testing {
    //! What the tests of all jobs share.

    use super::Wake;
    use std::{
        sync::Arc,
        time::{Duration, Instant},
    };

    /// A wake that nobody hears.
    pub fn silent() -> Wake {
        Arc::new(|| ())
    }

    /// How long an answer may take: far longer than it does, since other tests keep the cores busy.
    const PATIENCE: Duration = Duration::from_secs(90);

    /// Asks again and again until there is an answer.
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
