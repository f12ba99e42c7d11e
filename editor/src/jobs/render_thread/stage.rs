//! Stage of a picture, and restarts of lost devices.

use std::time::{Duration, Instant};

/// Time without changes before the full picture begins.
const SETTLE: Duration = Duration::from_millis(120);

/// Time between looks whether shaders are compiled.
const COMPILER_WAIT: Duration = Duration::from_millis(4);

/// Time after which the window says that they are not.
pub const COMPILER_SILENCE: Duration = Duration::from_millis(300);

/// Stage of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureStage {
    /// The picture is complete, or there is nothing to show.
    Rest,
    /// The next picture is about to begin.
    Begin,
    /// It has begun, and its shaders are being compiled on other threads. The last picture stays.
    Compile,
    /// Its first sample is being computed.
    Sketch,
    /// A reduced picture is shown; the full one follows if nothing changes for a while.
    Settle {
        /// When it was shown.
        since: Instant,
    },
    /// Rows of further samples are added to the full picture.
    Full {
        /// The sample that is added.
        sample: u32,
        /// The first missing row.
        row: u32,
    },
}

impl PictureStage {
    /// How long to wait for a message before the next step; `None` if only a message can bring one.
    pub fn patience(self, now: Instant) -> Option<Duration> {
        match self {
            Self::Rest => None,
            Self::Compile => Some(COMPILER_WAIT),
            Self::Settle { since } => Some((since + SETTLE).saturating_duration_since(now)),
            Self::Begin | Self::Sketch | Self::Full { .. } => Some(Duration::ZERO),
        }
    }

    /// Whether the full picture may begin.
    pub fn settled(self, now: Instant) -> bool {
        matches!(self, Self::Settle { .. }) && self.patience(now) == Some(Duration::ZERO)
    }
}

/// Restarts of the renderer.
#[derive(Debug, Default)]
pub struct Restarts(Vec<Instant>);

impl Restarts {
    /// Most restarts within [`Self::PERIOD`], so that a failing driver does not keep the machine busy.
    pub const MOST: usize = 3;
    const PERIOD: Duration = Duration::from_secs(60);

    /// Whether one more restart is allowed; counts it if so.
    pub fn allow(&mut self, now: Instant) -> bool {
        self.0.retain(|&then| now.saturating_duration_since(then) < Self::PERIOD);
        let allowed = self.0.len() < Self::MOST;
        if allowed {
            self.0.push(now);
        }
        allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_full_picture_waits_for_rest() {
        let since = Instant::now();
        let stage = PictureStage::Settle { since };
        assert_eq!(stage.patience(since), Some(SETTLE));
        assert!(stage.settled(since + SETTLE) && !stage.settled(since + SETTLE / 2));
        assert!(!PictureStage::Begin.settled(since));
        assert_eq!(PictureStage::Rest.patience(since), None);
    }

    #[test]
    fn three_restarts_a_minute_are_allowed() {
        let start = Instant::now();
        let at = |secs| start + Duration::from_secs(secs);
        let mut restarts = Restarts::default();
        assert!([0, 10, 20].into_iter().all(|secs| restarts.allow(at(secs))));
        assert!(!restarts.allow(at(59)));
        assert!(restarts.allow(at(61)), "the first is a minute ago");
        assert!(!restarts.allow(at(62)));
    }
}
