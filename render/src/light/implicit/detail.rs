//! How finely the light of posed objects is found.

use lapidary_core::implicit::BinLayout;

/// Surfels, bins and bounces of implicit visibility, from what a slow machine finds while an object is dragged to what a picture at
/// rest has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ImplicitDetail {
    /// Leaves of the surfel forest.
    surfels: u32,
    /// Bins along an edge of the square of a leaf.
    side: u16,
    /// Most bounces that are followed.
    bounces: u16,
}

impl ImplicitDetail {
    /// From the coarsest to the finest. Each is less exact than the next and takes less time, measured in the color box
    /// (`docs/results.md`).
    pub const LADDER: [Self; 5] = [
        Self { surfels: 4096, side: 14, bounces: 1 },
        Self { surfels: 8192, side: 14, bounces: 2 },
        Self { surfels: 16_384, side: 14, bounces: 3 },
        Self { surfels: 16_384, side: 20, bounces: 3 },
        Self { surfels: 32_768, side: 20, bounces: 3 },
    ];
    /// Of the first drag, before any was measured.
    pub const OF_A_DRAG: Self = Self::LADDER[1];
    /// Of pictures that nobody waits for.
    pub const FINEST: Self = Self::LADDER[4];

    /// Leaves of the surfel forest.
    pub fn surfels(self) -> u32 {
        self.surfels
    }

    /// The bins of each leaf.
    pub fn layout(self) -> BinLayout {
        BinLayout::new(self.side.into())
    }

    /// Most bounces that are followed.
    pub fn bounces(self) -> u32 {
        self.bounces.into()
    }

    /// The finest that takes at most `budget` milliseconds where this one takes `millis`, or the coarsest. Time is taken to grow
    /// with the number of bins. Part of it does not: so what is coarser may take longer than foretold, but never what is finer, and
    /// the choice does not go to and fro.
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
