//! Runs work in its own thread pool, to leave some cores to other programs.

use std::time::Duration;

/// Runs `work` with its parallel parts on `threads` threads, or on the shared pool if the system has no more threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

/// Measures the CPU time of the calling thread where the system reports it, excluding other load on its core.
pub struct CoreClock(Duration);

impl CoreClock {
    /// Starts measuring.
    pub fn begin() -> Self {
        Self(time_of_thread())
    }

    /// Seconds since the start.
    pub fn secs(&self) -> f64 {
        time_of_thread().saturating_sub(self.0).as_secs_f64()
    }
}

#[cfg(target_os = "linux")]
fn time_of_thread() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

#[cfg(not(target_os = "linux"))]
fn time_of_thread() -> Duration {
    static BEGAN: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    BEGAN.get_or_init(std::time::Instant::now).elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_core_clock_counts_work() {
        let clock = CoreClock::begin();
        let mut rng = fastrand::Rng::with_seed(1);
        let sum = (0..20_000_000).fold(0_u64, |sum, _| sum.wrapping_add(rng.u64(..)));
        assert!(std::hint::black_box(sum) > 0 && (1e-4..60.0).contains(&clock.secs()), "{}", clock.secs());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn waiting_is_no_work() {
        let clock = CoreClock::begin();
        std::thread::sleep(Duration::from_millis(200));
        assert!(clock.secs() < 0.1);
    }

    #[test]
    fn the_pool_has_as_many_threads_as_asked_for() {
        assert_eq!(on_threads(3, rayon::current_num_threads), 3);
    }
}
