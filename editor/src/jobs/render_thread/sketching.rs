//! Progress of a picture's first sample: the next tiles and lattice, and when to show it.

use crate::jobs::budget::Pace;
use glam::Vec2;
use lapidary_render::{STRIDES, Tiles, share_of_lattice};
use std::time::{Duration, Instant};

/// Most milliseconds of tiles computed at once: short enough to drop everything for a new request.
const STEP_MS: f64 = 45.0;

/// Measured speed of sketches, by kind of work.
#[derive(Clone, Copy, Debug, Default)]
pub struct SketchPace {
    /// The coarsest lattice, with the first hits of all pixels.
    first: Pace,
    /// Pixels shaded by finer lattices.
    finer: Pace,
    /// Filling and display.
    show: Pace,
    /// All pixels of full pictures of which nothing was kept.
    whole: Pace,
}

/// Share of the frame time in which a whole picture must have been done: the next one may take longer.
const WHOLE_SHARE: f32 = 0.5;

impl SketchPace {
    /// Records that it took `millis` milliseconds to show a sketch of `pixels` pixels, of which `shaded` were shaded for it.
    pub fn shown(&mut self, pixels: u64, shaded: u32, millis: f64) {
        let shading = self.finer.millis(shaded.into()).unwrap_or(0.0);
        self.show.measured(pixels, (millis - shading).max(0.0));
    }

    /// The largest picture whose coarsest lattice is shown in `budget_ms`.
    pub fn reduced_size(&self, full: [u32; 2], budget_ms: f32) -> [u32; 2] {
        self.first.and(self.show).reduced_size(full, budget_ms)
    }

    /// Records that a full picture of `pixels` pixels took `millis` milliseconds, if nothing of it was kept.
    pub fn whole_done(&mut self, pixels: u64, millis: f64) {
        self.whole.measured(pixels, millis);
    }

    /// Whether a full picture of `pixels` pixels was done soon enough that it is made at once in `budget_ms`.
    pub fn shows_whole(&self, pixels: u64, budget_ms: f32) -> bool {
        let millis = self.whole.and(self.show).millis(pixels);
        millis.is_some_and(|millis| millis <= f64::from(WHOLE_SHARE * budget_ms))
    }

    /// Pixels shaded in `millis` milliseconds.
    pub fn pixels_within(&self, millis: f64) -> u32 {
        self.finer.times_within(millis, 1.0).unwrap_or(0).min(u32::MAX as usize) as u32
    }
}

/// The first sample in the making.
#[derive(Debug)]
pub struct Sketching {
    size: [u32; 2],
    /// Tiles in the order in which each lattice takes them.
    order: Vec<u32>,
    /// Index into [`STRIDES`] of the current lattice.
    level: usize,
    /// Tiles of `order` with the current lattice.
    done: usize,
    /// When the sketch began.
    since: Instant,
    /// Complete lattices when it was last shown.
    shown: usize,
    /// Whether all pixels are taken at once, without lattices.
    is_whole: bool,
}

impl Sketching {
    /// For a picture of `size`, with the tiles near `place` first.
    pub fn new(size: [u32; 2], place: Vec2) -> Self {
        let order = Tiles::of(size).nearest_first(place);
        Self { size, order, level: 0, done: 0, since: Instant::now(), shown: 0, is_whole: false }
    }

    /// The same picture without coarse lattices, where all its pixels should be done in time.
    pub fn whole(self) -> Self {
        Self { level: STRIDES.len() - 1, is_whole: true, ..self }
    }

    /// Pixels of the picture.
    pub fn pixels(&self) -> u64 {
        self.size.map(u64::from).iter().product()
    }

    /// Whether the sample is complete.
    pub fn is_complete(&self) -> bool {
        self.level == STRIDES.len()
    }

    /// Whether it was shown.
    pub fn is_shown(&self) -> bool {
        self.shown > 0
    }

    /// Stride of the finest complete lattice.
    pub fn stride(&self) -> Option<u32> {
        self.level.checked_sub(1).map(|level| STRIDES[level])
    }

    /// The next stride and tiles, as many as fit the rest of `budget_ms`.
    pub fn next(&self, pace: &SketchPace, budget_ms: f32) -> (u32, &[u32]) {
        let stride = STRIDES[self.level];
        let left = &self.order[self.done..];
        let pixels = self.share() * Tiles::MOST_PIXELS as f64;
        let threads = rayon::current_num_threads();
        let wanted = match self.is_whole {
            true => pace.whole.times_within(STEP_MS, pixels),
            false => self.pace(pace).times_within(self.millis_left(pace, budget_ms), pixels),
        };
        let wanted = wanted.unwrap_or(0);
        (stride, &left[..wanted.max(threads).min(left.len())])
    }

    /// Records that the first `tiles` of the next tiles took `millis` milliseconds.
    pub fn advance(&mut self, tiles: usize, pace: &mut SketchPace, millis: f64) {
        let taken = &self.order[self.done..self.done + tiles];
        let pixels: u64 = taken.iter().map(|&tile| Tiles::of(self.size).region(tile).pixels()).sum();
        let slot = if self.level == 0 { &mut pace.first } else { &mut pace.finer };
        if !self.is_whole {
            slot.measured((pixels as f64 * self.share()).ceil() as u64, millis);
        }
        self.done += tiles;
        if self.done == self.order.len() {
            (self.level, self.done) = (self.level + 1, 0);
        }
    }

    /// Whether to show the picture now: first when `budget_ms` is spent, then once for each lattice.
    pub fn is_due(&self, pace: &SketchPace, budget_ms: f32) -> bool {
        match self.shown {
            0 => self.level > 0 && !self.is_whole && !(self.millis_left(pace, budget_ms) > 0.0),
            shown => self.level > shown,
        }
    }

    /// Records that it was shown.
    pub fn set_shown(&mut self) {
        self.shown = self.level;
    }

    /// Pixels that a tile's part of the lattice adds, per pixel of the tile.
    fn share(&self) -> f64 {
        // The coarsest lattice traces all pixels.
        if self.level == 0 || self.is_whole { 1.0 } else { share_of_lattice(STRIDES[self.level]) }
    }

    fn pace<'p>(&self, pace: &'p SketchPace) -> &'p Pace {
        if self.level == 0 { &pace.first } else { &pace.finer }
    }

    /// Milliseconds until it is first shown, or the longest step after that.
    fn millis_left(&self, pace: &SketchPace, budget_ms: f32) -> f64 {
        if self.is_shown() {
            return STEP_MS;
        }
        let passed = 1e3 * Duration::as_secs_f64(&self.since.elapsed());
        let show = pace.show.millis(self.pixels()).unwrap_or(0.0);
        (f64::from(budget_ms) - passed - show).min(STEP_MS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes all steps; returns the strides with their numbers of tiles.
    fn steps(sketching: &mut Sketching, pace: &mut SketchPace) -> Vec<(u32, usize)> {
        let mut steps = Vec::new();
        while !sketching.is_complete() {
            let (stride, tiles) = sketching.next(pace, 1e3);
            let (count, tile) = (tiles.len(), tiles[0]);
            assert!(tile < Tiles::of(sketching.size).count());
            steps.push((stride, count));
            sketching.advance(count, pace, 1.0);
        }
        steps
    }

    #[test]
    fn each_lattice_takes_all_tiles_once() {
        let mut sketching = Sketching::new([500, 300], Vec2::splat(0.5));
        let steps = steps(&mut sketching, &mut SketchPace::default());
        for stride in STRIDES {
            let tiles: usize = steps.iter().filter(|step| step.0 == stride).map(|step| step.1).sum();
            assert_eq!(tiles, 8 * 5, "{stride}");
        }
        assert!(steps.windows(2).all(|s| s[1].0 <= s[0].0));
    }

    #[test]
    fn without_lattices_all_pixels_are_taken_at_once() {
        let mut pace = SketchPace::default();
        pace.shown(1000, 0, 4.0);
        assert!(!pace.shows_whole(1000, 1e9), "an unknown speed is taken for slow");
        pace.whole_done(1000, 6.0);
        assert!(pace.shows_whole(1000, 20.1) && !pace.shows_whole(1000, 19.9) && !pace.shows_whole(1100, 20.1));
        let sketching = || Sketching::new([500, 300], Vec2::splat(0.5)).whole();
        assert!(!sketching().is_due(&pace, 0.0), "nothing to show");
        pace.whole = Pace::default();
        pace.whole_done(1_000_000, 1.0);
        assert_eq!(steps(&mut sketching(), &mut pace), [(1, 8 * 5)], "at once");
        assert!(pace.first.millis(1).is_none() && pace.finer.millis(1).is_none(), "they tell nothing of lattices");
        pace.whole_done(1, 1e9);
        assert!(steps(&mut sketching(), &mut pace).len() > 1, "a step that takes too long is parted");
    }

    #[test]
    fn it_is_shown_when_its_time_is_over_and_then_for_each_lattice() {
        let mut pace = SketchPace::default();
        let mut sketching = Sketching::new([60, 60], Vec2::ZERO);
        assert!(!sketching.is_due(&pace, 0.0), "nothing to show");
        sketching.advance(1, &mut pace, 1.0);
        assert!(sketching.is_due(&pace, 0.0) && !sketching.is_due(&pace, 1e6));
        pace.shown(3600, 0, 2e6);
        assert!(sketching.is_due(&pace, 1e6), "the time to show it counts");
        sketching.set_shown();
        assert!(!sketching.is_due(&pace, 0.0) && sketching.stride() == Some(8));
        sketching.advance(1, &mut pace, 1.0);
        assert!(sketching.is_due(&pace, 1e6) && sketching.stride() == Some(4));
    }
}
