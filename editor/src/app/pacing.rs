//! How often the window is drawn where graphics are emulated: the processor's time is then the renderer's loss.

use super::EditorState;
use std::{
    thread::sleep,
    time::{Duration, Instant},
};

/// Keeps frames of the window apart.
pub(super) struct Pacing {
    last: Instant,
}

impl Pacing {
    pub fn new() -> Self {
        Self { last: Instant::now() }
    }

    /// Waits until `interval` has passed since the last frame, if there is to be one.
    pub fn wait(&mut self, interval: Option<Duration>) {
        sleep(interval.unwrap_or_default().saturating_sub(self.last.elapsed()));
        self.last = Instant::now();
    }
}

impl EditorState {
    /// The least time from one frame of the window to the next, as long as the renderer is at work: twice as many frames as
    /// pictures are more than are seen, and each event is three frames to the toolkit.
    pub(super) fn frame_interval(&self) -> Option<Duration> {
        let is_at_work = self.pictures.shown().is_some_and(|frame| frame.samples < frame.of_samples);
        let half_of_budget = Duration::from_secs_f32(0.5e-3 * self.document.view.frame_budget_ms.clamp(0.0, 200.0));
        is_at_work.then_some(half_of_budget)
    }
}
