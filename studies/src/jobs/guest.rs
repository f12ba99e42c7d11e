//! Background work beside the picture: it runs at low priority and waits during drags.

use std::{
    sync::{Arc, Condvar, Mutex, PoisonError},
    time::{Duration, Instant},
};

/// Nice value, from -20 to 19: two such threads take 2 % of the core that renders a picture.
#[cfg(target_os = "linux")]
const NICE: i32 = 19;

/// Lowers the priority of this thread and its children, if the system allows it.
pub fn lower_priority() {
    // Linux sets priority per thread.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, NICE);
}

/// A checkpoint that work passes often; while held, work waits there.
#[derive(Clone, Default)]
pub struct Door(Arc<(Mutex<State>, Condvar)>);

#[derive(Default)]
struct State {
    /// Start of the current hold.
    held: Option<Instant>,
    /// Duration of earlier holds.
    waited: Duration,
}

impl Door {
    /// Holds or releases the door.
    pub fn hold(&self, hold: bool) {
        let (state, changed) = &*self.0;
        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
        if hold == state.held.is_some() {
            return;
        }
        if let Some(since) = state.held.take() {
            state.waited += since.elapsed();
        }
        state.held = hold.then(Instant::now);
        changed.notify_all();
    }

    /// Waits while it is held and `go_on` returns true.
    pub fn pass(&self, go_on: impl Fn() -> bool) {
        const LOOK: Duration = Duration::from_millis(50);
        let (state, changed) = &*self.0;
        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
        while state.held.is_some() && !go_on() {
            state = changed.wait_timeout(state, LOOK).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Total time it has been held.
    pub fn waited(&self) -> Duration {
        let state = self.0.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.waited + state.held.map_or(Duration::ZERO, |since| since.elapsed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering::SeqCst};

    #[test]
    fn work_waits_while_it_is_held_and_goes_on_after() {
        let (door, steps) = (Door::default(), AtomicU32::new(0));
        let reached = |count| {
            let start = Instant::now();
            while steps.load(SeqCst) < count && start.elapsed() < Duration::from_secs(60) {
                std::thread::sleep(Duration::from_millis(1));
            }
            steps.load(SeqCst) >= count
        };
        std::thread::scope(|threads| {
            threads.spawn(|| {
                while steps.load(SeqCst) < 1_000_000 {
                    door.pass(|| false);
                    steps.fetch_add(1, SeqCst);
                    std::thread::sleep(Duration::from_micros(100));
                }
            });
            assert!(reached(5));
            door.hold(true);
            std::thread::sleep(Duration::from_millis(20));
            let held = steps.load(SeqCst);
            std::thread::sleep(Duration::from_millis(200));
            assert!(steps.load(SeqCst) <= held + 1, "it waits");
            door.hold(false);
            assert!(reached(held + 10), "it goes on");
            let waited = door.waited();
            assert!(waited >= Duration::from_millis(200), "{waited:?}");
            assert_eq!(door.waited(), waited, "not any more");
            steps.store(1_000_000, SeqCst);
        });
    }

    #[test]
    fn who_is_to_stop_does_not_wait() {
        let door = Door::default();
        door.hold(true);
        let start = Instant::now();
        door.pass(|| true);
        assert!(start.elapsed() < Duration::from_secs(30));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_a_guest_starts_is_a_guest() {
        let nice = || rustix::process::getpriority_process(None).unwrap();
        let before = nice();
        let of_started = std::thread::spawn(move || {
            lower_priority();
            std::thread::spawn(nice).join().unwrap()
        });
        assert_eq!(of_started.join().unwrap(), NICE);
        assert_eq!(nice(), before, "negative control: others stay as they are");
    }
}
