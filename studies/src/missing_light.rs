//! Light that is missing because bounces end too early, in sentences for the window and the command line.

use lapidary_core::transport::BounceEnergy;
use lapidary_render::Solution;

/// Share of the light above which it is said that bounces are missing: a few percent are not seen.
const MUCH_MISSING: f32 = 0.1;

/// Energy of the bounces in a picture, from that of the bounces in the meshless basis: cuts gather one bounce more than the basis
/// has, the next of the same geometric series.
pub fn in_picture(energy: BounceEnergy, solution: Solution) -> BounceEnergy {
    if solution == Solution::CutsMeshless { gathered(energy) } else { energy }
}

/// What to do if much light is left when the bounces end.
pub fn remark(energy: BounceEnergy) -> Option<String> {
    let missing = energy.missing_share;
    if missing <= MUCH_MISSING {
        return None;
    }
    let text = if missing < 1.0 {
        format!("About {} of the light is missing, for it would bounce on.", percent(missing))
    } else {
        "The light would bounce on without end: surfaces reflect all of it.".into()
    };
    Some(format!("{text} Lower the base color of the brightest materials, below 0.8, to see it all."))
}

/// A share as percent.
pub fn percent(share: f32) -> String {
    let percent = 100.0 * share;
    if percent < 10.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

fn gathered(energy: BounceEnergy) -> BounceEnergy {
    let BounceEnergy { bounces, last_share: last, missing_share } = energy;
    let bounces = bounces + 1;
    if last <= 0.0 || missing_share >= 1.0 {
        return BounceEnergy { bounces, ..energy };
    }
    // Of the light so far: what is missing is last * kept / (1 - kept).
    let missing = missing_share / (1.0 - missing_share);
    let next = last * missing / (last + missing);
    BounceEnergy { bounces, last_share: next / (1.0 + next), missing_share: (missing - next) / (1.0 + missing) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gathered_bounce_goes_on_with_the_series() {
        // 16, 8, 4, and then 2, 1 and so on.
        let energy = BounceEnergy { bounces: 2, last_share: 4.0 / 28.0, missing_share: 4.0 / 32.0 };
        let BounceEnergy { bounces, last_share, missing_share } = in_picture(energy, Solution::CutsMeshless);
        assert_eq!(bounces, 3);
        assert!((last_share - 2.0 / 30.0).abs() < 1e-6 && (missing_share - 2.0 / 32.0).abs() < 1e-6);
        assert_eq!(in_picture(energy, Solution::Meshless), energy);
        let endless = BounceEnergy { bounces: 4, last_share: 0.2, missing_share: 1.0 };
        assert_eq!(gathered(endless), BounceEnergy { bounces: 5, ..endless });
    }

    #[test]
    fn much_missing_light_is_told_and_little_is_not() {
        let missing = |missing_share| remark(BounceEnergy { bounces: 4, last_share: 0.1, missing_share });
        assert_eq!(missing(0.05), None);
        assert!(missing(0.25).is_some_and(|text| text.contains("25 %") && text.contains("base color")));
        assert!(missing(1.0).is_some_and(|text| text.contains("without end")));
    }
}
