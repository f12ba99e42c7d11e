//! How many workgroups a kernel runs at once, by the times of its earlier dispatches.

use std::time::Duration;

/// Time of a slice: a desktop on the same adapter still draws its pictures between two.
const SLICE: Duration = Duration::from_millis(4);
/// Workgroups of the first slice, which no time is known of.
const FIRST: u32 = 64;
/// Most workgroups of a dispatch by WebGPU's default limits.
const MOST: u32 = 65_535;

/// What is known of a kernel's speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pace {
    secs_per_workgroup: Option<f64>,
}

impl Pace {
    /// Workgroups of the next slice, one or more.
    pub fn next(&self) -> u32 {
        let fitting = |secs: f64| (SLICE.as_secs_f64() / secs.max(f64::MIN_POSITIVE)) as u32;
        self.secs_per_workgroup.map_or(FIRST, |secs| fitting(secs).clamp(1, MOST))
    }

    /// Notes how long some workgroups took. A short last slice tells more of the wait for it than of the work, and counts only if
    /// it was faster.
    pub fn took(&mut self, workgroups: u32, time: Duration) {
        let secs = time.as_secs_f64() / f64::from(workgroups);
        let is_whole = workgroups == self.next();
        let slower = self.secs_per_workgroup.is_some_and(|known| secs > known);
        if is_whole || !slower {
            self.secs_per_workgroup = Some(secs);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slices of some work that takes a microsecond a workgroup, and 50 for each dispatch.
    fn slices(pace: &mut Pace, mut left: u32) -> Vec<u32> {
        let mut slices = Vec::new();
        while left > 0 {
            let some = pace.next().min(left);
            pace.took(some, Duration::from_micros(50 + u64::from(some)));
            slices.push(some);
            left -= some;
        }
        slices
    }

    #[test]
    fn slices_begin_small_and_come_to_four_milliseconds() {
        let mut pace = Pace::default();
        let first = slices(&mut pace, 50_000);
        assert_eq!(first[0], FIRST);
        assert!(first[1] > 1000 && first[first.len() - 2].abs_diff(3950) < 10, "{first:?}");
        assert!(slices(&mut pace, 50_000)[0].abs_diff(3950) < 10, "it is known from before");
    }

    #[test]
    fn short_work_does_not_make_later_slices_short() {
        let mut pace = Pace::default();
        slices(&mut pace, 50_000);
        let before = pace.next();
        slices(&mut pace, 3);
        assert_eq!(pace.next(), before);
        pace.took(before, Duration::from_millis(40));
        assert!(pace.next() <= before / 9, "negative control: a whole slice that was slow");
    }

    #[test]
    fn a_slice_is_never_empty_nor_beyond_the_limit() {
        let mut pace = Pace::default();
        pace.took(FIRST, Duration::from_secs(10));
        assert_eq!(pace.next(), 1);
        pace.took(1, Duration::ZERO);
        assert_eq!(pace.next(), MOST);
    }
}
