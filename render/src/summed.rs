//! Contents of a picture's sums, on either renderer.

use crate::{
    light::light_counts::{LightCounts, light_key},
    sampling::BrdfSampling,
    stale::{LightPart, Marks, Pixels, Stale},
    view::View,
    view_mode::ViewMode,
};
use lapidary_core::lights::Light;

/// The picture of the sums, and its complete samples.
pub(crate) struct Summed {
    /// View of the picture.
    pub view: View,
    /// BRDF sampling of the picture.
    pub sampling: BrdfSampling,
    /// The local lights in the sums.
    pub lights: SummedLights,
    /// Samples that all pixels have of every part.
    pub complete: u32,
}

impl Summed {
    /// Starts with empty sums.
    pub fn new(view: &View, sampling: BrdfSampling) -> Self {
        Self { view: view.clone(), sampling, lights: SummedLights::default(), complete: 0 }
    }

    /// Whether samples stay valid for a picture after edits. Modes without parts of the light lose all samples by any edit.
    pub fn stays(&self, view: &View, sampling: BrdfSampling, stale: &Stale) -> bool {
        let is_lost = stale.surfaces || (view.mode != ViewMode::Shaded && stale.any());
        (&self.view, self.sampling) == (view, sampling) && !is_lost
    }

    /// Whether a picture, from another camera or of another size, shows the same surfaces in the same light.
    pub fn has_light_of(&self, view: &View, sampling: BrdfSampling, stale: &Stale, lights: &[Light]) -> bool {
        (self.view.is_same_but_seen_from(view), self.sampling) == (true, sampling)
            && !stale.any()
            && self.lights.clone().update(lights, false) == DirectStep::Keep
    }

    /// Whether all pixels have all samples.
    pub fn is_complete(&self) -> bool {
        self.complete >= self.view.aa.max(1)
    }
}

/// Local lights whose direct light is in the sums.
#[derive(Clone, Debug, Default)]
pub(crate) struct SummedLights {
    /// Lights in [`LightPart::Direct`].
    pub direct: Vec<Light>,
    /// Lights in [`LightPart::Added`].
    pub added: Vec<Light>,
}

/// Change of the sums of local lights' direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DirectStep {
    /// Keep both.
    Keep,
    /// Restart [`LightPart::Added`].
    Add,
    /// Add [`LightPart::Added`] to [`LightPart::Direct`] and restart it.
    MergeAndAdd,
    /// Restart both.
    Anew,
}

impl DirectStep {
    /// The pixels that lose their samples of a part by this step and by edits, in a scene with these mirrors.
    pub fn forgets(self, stale: &Stale, part: LightPart, mirrors: Marks) -> Pixels {
        let begins_anew = match part {
            LightPart::Environment | LightPart::Bounce => false,
            LightPart::Direct => self == Self::Anew,
            LightPart::Added | LightPart::Mirrors => self != Self::Keep,
        };
        match stale.pixels(part).and(Pixels::all_if(begins_anew)) {
            // Pixels that showed mirrors before have a changed material.
            Pixels::All if part == LightPart::Mirrors => Pixels::Showing(mirrors).and(stale.environment),
            pixels => pixels,
        }
    }
}

impl SummedLights {
    /// Replaces the lights by `wanted`. Added lights stay separate until all pixels have all samples (`complete`) and further
    /// lights are added.
    pub fn update(&mut self, wanted: &[Light], complete: bool) -> DirectStep {
        let wanted: Vec<Light> = wanted.iter().filter(|light| light.shines()).cloned().collect();
        let Some(rest) = without(&wanted, &self.direct).filter(|_| !self.direct.is_empty()) else {
            let same = wanted.is_empty() && self.direct.is_empty();
            *self = Self { direct: wanted, added: Vec::new() };
            return if same { DirectStep::Keep } else { DirectStep::Anew };
        };
        match without(&rest, &self.added) {
            Some(others) if others.is_empty() => DirectStep::Keep,
            Some(others) if complete && !self.added.is_empty() => {
                self.direct.append(&mut self.added);
                self.added = others;
                DirectStep::MergeAndAdd
            }
            _ => {
                self.added = rest;
                DirectStep::Add
            }
        }
    }
}

/// `lights` without each of `taken`; `None` if one of those is missing.
fn without(lights: &[Light], taken: &[Light]) -> Option<Vec<Light>> {
    let mut taken = LightCounts::of(taken.iter());
    let rest = lights.iter().filter(|light| !taken.take(&[light_key(light)])).cloned().collect();
    taken.is_empty().then_some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::point_light;
    use glam::Vec3;

    #[test]
    fn lights_that_are_added_stay_by_themselves_and_others_begin_anew() {
        let lamp = |x: f32| point_light(Vec3::new(x, 1.0, 0.0), 1.0);
        let lamps = |xs: &[f32]| xs.iter().map(|&x| lamp(x)).collect::<Vec<_>>();
        let mut summed = SummedLights::default();
        let mut step = |xs: &[f32], complete| summed.update(&lamps(xs), complete);
        assert_eq!(step(&[], true), DirectStep::Keep);
        assert_eq!(step(&[1.0, 2.0], true), DirectStep::Anew, "there were no lights");
        assert_eq!(step(&[2.0, 1.0], true), DirectStep::Keep, "the order makes no difference");
        assert_eq!(step(&[1.0, 2.0, 3.0], true), DirectStep::Add);
        assert_eq!(step(&[1.0, 2.0, 3.5], true), DirectStep::Add, "the added one moves");
        assert_eq!(step(&[1.0, 2.0, 3.5, 4.0], false), DirectStep::Add, "both again: the first is not complete");
        assert_eq!(step(&[1.0, 2.0, 3.5, 4.0, 5.0], true), DirectStep::MergeAndAdd);
        assert_eq!(step(&[1.0, 2.0, 3.5, 4.0], true), DirectStep::Add, "off again: the added part is empty");
        assert_eq!(step(&[1.0, 2.0, 3.5], true), DirectStep::Anew);
        let mut named = lamps(&[1.0, 2.0, 3.5]);
        named[1].name = "renamed".into();
        named.push(Light { enabled: false, ..lamp(7.0) });
        assert_eq!(summed.update(&named, true), DirectStep::Keep);
        assert_eq!(summed.update(&lamps(&[1.0]), true), DirectStep::Anew);
    }
}
