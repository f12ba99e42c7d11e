//! Remarks on light that is missing because bounces end too early.

use lapidary_core::transport::BounceEnergy;

/// Share of missing light above which a remark is made: a few percent are invisible.
const MUCH_MISSING: f32 = 0.1;

/// A remark with a remedy, if much light is left when the bounces end.
pub fn remark(energy: BounceEnergy) -> Option<String> {
    let missing = energy.missing_share;
    if missing <= MUCH_MISSING {
        return None;
    }
    let text = if missing < 1.0 {
        format!("About {} of the light is missing: it would bounce on.", percent(missing))
    } else {
        "The light would bounce on without end: surfaces reflect all of it.".into()
    };
    Some(format!("{text} Lower the base color of the brightest materials, below 0.8, to see it all."))
}

/// A share as a percentage.
pub fn percent(share: f32) -> String {
    let percent = 100.0 * share;
    if percent < 10.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn much_missing_light_is_told_and_little_is_not() {
        let missing = |missing_share| remark(BounceEnergy { bounces: 4, last_share: 0.1, missing_share });
        assert_eq!(missing(0.05), None);
        assert!(missing(0.25).is_some_and(|text| text.contains("25 %") && text.contains("base color")));
        assert!(missing(1.0).is_some_and(|text| text.contains("without end")));
    }
}
