//! Time left in the current phase of a bake, at its latest pace while nothing else wants the cores. Beside a rendering picture a
//! bake of low priority barely advances: at that pace a bake of two minutes would be said to take hours.

use super::BakeProgress;
use lapidary_precompute::Phase;
use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

/// The pace of the current phase.
pub struct PhasePace {
    phase: Option<Phase>,
    since: Instant,
    /// Time the bake had been on hold when the phase began.
    waited_before: Duration,
    /// The last progress: seconds of work, and units.
    last: (f64, u64),
    /// Seconds and units beside other work.
    disturbed: (f64, u64),
    pace: Pace,
}

impl Default for PhasePace {
    fn default() -> Self {
        Self {
            phase: None,
            since: Instant::now(),
            waited_before: Duration::ZERO,
            last: (0.0, 0),
            disturbed: (0.0, 0),
            pace: Pace::default(),
        }
    }
}

impl PhasePace {
    /// Records the progress of a bake that has been on hold for `waited`. Of what it did beside other work since the last call the
    /// pace knows nothing.
    pub fn follow(&mut self, progress: BakeProgress, waited: Duration, is_disturbed: bool) {
        if progress.phase != self.phase {
            *self = Self { phase: progress.phase, waited_before: waited, ..Self::default() };
        }
        let worked = self.since.elapsed().saturating_sub(waited.saturating_sub(self.waited_before));
        self.advance(worked.as_secs_f64(), progress.done, is_disturbed);
    }

    fn advance(&mut self, secs: f64, done: u64, is_disturbed: bool) {
        let (secs_before, done_before) = std::mem::replace(&mut self.last, (secs, done));
        if is_disturbed {
            self.disturbed.0 += secs - secs_before;
            self.disturbed.1 += done.saturating_sub(done_before);
        } else {
            self.pace.note(secs - self.disturbed.0, done.saturating_sub(self.disturbed.1));
        }
    }

    /// Estimated seconds left, if known.
    pub fn left(&self, done: u64, total: u64) -> Option<f64> {
        self.pace.left(done, total)
    }
}

/// Progress of a phase at several times.
#[derive(Clone, Debug, Default)]
struct Pace {
    /// Seconds of work on the phase, and units completed by then.
    marks: VecDeque<(f64, u64)>,
}

impl Pace {
    /// Seconds over which pace is measured.
    const SPAN: f64 = 8.0;
    /// Seconds between two marks.
    const BETWEEN: f64 = 0.25;
    /// Share of a phase to complete before its pace is known.
    const KNOWN_AFTER: f64 = 0.02;

    /// Records the completed units after `secs` seconds of a phase.
    fn note(&mut self, secs: f64, done: u64) {
        if self.marks.back().is_some_and(|&(before, had)| secs < before || done < had) {
            self.marks.clear();
        }
        if self.marks.back().is_none_or(|&(before, _)| secs - before >= Self::BETWEEN) {
            self.marks.push_back((secs, done));
        }
        while self.marks.get(1).is_some_and(|&(second, _)| secs - second >= Self::SPAN) {
            self.marks.pop_front();
        }
    }

    /// Estimated seconds left, if known.
    fn left(&self, done: u64, total: u64) -> Option<f64> {
        let (&(begun, had), &(secs, has)) = self.marks.front().zip(self.marks.back())?;
        // Some steps have a little work left after all units are done.
        let is_known = done as f64 > Self::KNOWN_AFTER * total as f64 && done < total && has > had;
        is_known.then(|| (total - done) as f64 * (secs - begun) / (has - had) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pace with one of these values per second.
    fn pace(done: impl IntoIterator<Item = u64>) -> Pace {
        let mut pace = Pace::default();
        done.into_iter().enumerate().for_each(|(second, done)| pace.note(second as f64, done));
        pace
    }

    #[test]
    fn the_rest_takes_what_the_latest_part_took() {
        assert_eq!(pace([0, 10, 20]).left(20, 100), Some(8.0));
        // Slow for a minute beside a picture, then at full pace.
        let slow = (0..60).map(|second| second / 4);
        let fast = (1..=12).map(|second| 14 + 10 * second);
        let left = pace(slow.clone().chain(fast)).left(134, 234).unwrap();
        assert!((left - 10.0).abs() < 0.1, "{left}");
        assert!(pace(slow).left(14, 234).unwrap() > 300.0, "negative control: before");
    }

    #[test]
    fn work_beside_a_picture_does_not_count() {
        let left = |disturbed: bool| {
            let mut pace = PhasePace::default();
            // Ten units a second alone, then one in ten seconds beside a picture.
            (0..=4).for_each(|second| pace.advance(f64::from(second), 10 * second as u64, false));
            (0..=6).for_each(|tens| pace.advance(f64::from(4 + 10 * tens), 40 + tens as u64, disturbed));
            pace.left(46, 100).unwrap()
        };
        assert!((left(true) - 5.4).abs() < 1e-6, "{}", left(true));
        assert!(left(false) > 300.0, "negative control: {}", left(false));
    }

    #[test]
    fn what_is_not_known_is_not_told() {
        assert_eq!(Pace::default().left(5, 10), None);
        assert_eq!(pace([0, 1]).left(1, 100), None, "too little is done");
        assert_eq!(pace([0, 50]).left(100, 100), None, "all is done");
        assert_eq!(pace([50, 50]).left(50, 100), None, "nothing moves");
        assert_eq!(pace([0, 50]).left(5, 0), None, "nobody knows the whole");
        assert_eq!(pace([0, 50, 3]).left(3, 100), None, "another phase begins");
    }
}
