//! Measured times.

use std::time::Duration;

/// Median in milliseconds; the upper one of an even number.
///
/// # Panics
/// Without any time.
pub fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    1e3 * times[times.len() / 2].as_secs_f64()
}
