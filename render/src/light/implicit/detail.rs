//! ImplicitDetail levels for the light of posed objects.

use lapidary_core::implicit::BinLayout;

/// Surfels, bins and bounces of implicit visibility: from a drag on a slow machine to a picture at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ImplicitDetail {
    /// Leaves of the surfel forest.
    surfels: u32,
    /// Bins along one edge of a leaf's square.
    side: u16,
    /// Most bounces to follow.
    bounces: u16,
}

impl ImplicitDetail {
    /// Levels from coarsest to finest, each less exact and faster than the next, as measured in the color box (`docs/results.md`).
    pub const LADDER: [Self; 5] = [
        Self { surfels: 4096, side: 14, bounces: 1 },
        Self { surfels: 8192, side: 14, bounces: 2 },
        Self { surfels: 16_384, side: 14, bounces: 3 },
        Self { surfels: 16_384, side: 20, bounces: 3 },
        Self { surfels: 32_768, side: 20, bounces: 3 },
    ];
    /// Level of the first drag, before any measurement.
    pub const OF_A_DRAG: Self = Self::LADDER[1];
    /// Level for pictures at rest.
    pub const FINEST: Self = Self::LADDER[4];

    /// Leaves of the surfel forest.
    pub fn surfels(self) -> u32 {
        self.surfels
    }

    /// Bin layout of each leaf.
    pub fn layout(self) -> BinLayout {
        BinLayout::new(self.side.into())
    }

    /// Most bounces to follow.
    pub fn bounces(self) -> u32 {
        self.bounces.into()
    }

    /// The finest level that takes at most `budget` milliseconds if this one takes `millis`, else the coarsest. Time is assumed
    /// proportional to the number of bins. Actual growth is sub-linear: a coarser level may take longer than predicted, a finer one
    /// never does, and the choice does not oscillate.
    pub fn within(self, millis: f64, budget: f64) -> Self {
        let bins = |detail: &Self| f64::from(detail.surfels) * f64::from(detail.side).powi(2);
        let fits = |detail: &Self| bins(detail) / bins(&self) * millis <= budget;
        Self::LADDER.into_iter().rev().find(fits).unwrap_or(Self::LADDER[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_of_the_ladder_is_finer_than_the_last() {
        let bins = |detail: ImplicitDetail| detail.surfels() as usize * detail.layout().cells.len();
        assert!(ImplicitDetail::LADDER.is_sorted_by(|a, b| a < b && bins(*a) < bins(*b) && a.bounces() <= b.bounces()));
        assert!(
            ImplicitDetail::LADDER.contains(&ImplicitDetail::OF_A_DRAG)
                && ImplicitDetail::LADDER.last() == Some(&ImplicitDetail::FINEST)
        );
    }

    #[test]
    fn what_takes_too_long_is_coarser_and_what_takes_little_finer() {
        let [coarsest, second, third, ..] = ImplicitDetail::LADDER;
        assert_eq!(second.within(60.0, 60.0), second);
        assert_eq!(second.within(61.0, 60.0), coarsest);
        assert_eq!(second.within(30.0, 60.0), third);
        assert_eq!(second.within(1.0, 60.0), ImplicitDetail::FINEST);
        assert_eq!(ImplicitDetail::FINEST.within(1e9, 60.0), coarsest, "negative control: nothing fits");
    }

    #[test]
    fn the_choice_does_not_go_to_and_fro() {
        let millis =
            |detail: ImplicitDetail| 20.0 + 8e-6 * f64::from(detail.surfels()) * detail.layout().cells.len() as f64;
        for budget in [10.0, 40.0, 60.0, 100.0, 1000.0] {
            let mut detail = ImplicitDetail::OF_A_DRAG;
            let mut step = || {
                detail = detail.within(millis(detail), budget);
                detail
            };
            let settled = (0..8).map(|_| step()).last();
            assert_eq!(Some(step()), settled, "{budget} ms");
        }
    }
}
