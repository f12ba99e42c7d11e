//! Limits how often the window is drawn where graphics are emulated, since drawing takes cores from the renderer.

use std::{
    thread::sleep,
    time::{Duration, Instant},
};

/// The least time from one frame to the next while the renderer works: two frames for each picture of a drag. Without it
/// the toolkit draws three for each movement of the pointer.
const INTERVAL: Duration = Duration::from_millis(50);

/// Keeps frames of the window apart.
pub(super) struct Pacing {
    last: Instant,
}

impl Pacing {
    pub fn new() -> Self {
        Self { last: Instant::now() }
    }

    /// Waits for the time of the next frame, if the renderer works.
    pub fn wait(&mut self, renderer_works: bool) {
        if renderer_works {
            sleep(INTERVAL.saturating_sub(self.last.elapsed()));
        }
        self.last = Instant::now();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_apart_while_the_renderer_works() {
        let mut pacing = Pacing::new();
        let start = Instant::now();
        pacing.wait(true);
        pacing.wait(true);
        assert!(start.elapsed() >= INTERVAL, "at least the second one waits in full");
        let idle = Instant::now();
        (0..10).for_each(|_| pacing.wait(false));
        assert!(idle.elapsed() < INTERVAL);
    }
}
