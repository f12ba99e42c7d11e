//! Which parts of the light are in the picture, and which solutions of bounced light a dataset has.

use lapidary_core::{dataset::Dataset, lights::Light};
use lapidary_render::{Components, Solution};
use serde::{Deserialize, Serialize};

/// A part of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Component {
    /// What comes straight from the environment, and the environment behind the scene.
    Environment,
    /// What comes straight from local lights.
    Direct,
    /// What was reflected at least once, of either.
    Indirect,
}

impl Component {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Environment, Self::Direct, Self::Indirect];
}

/// The switches of the parts, and the one that is looked at alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ComponentSettings {
    /// See [`Component::Environment`].
    pub environment: bool,
    /// See [`Component::Direct`].
    pub direct: bool,
    /// See [`Component::Indirect`].
    pub indirect: bool,
    /// Only this one is shown, whatever its switch says.
    pub solo: Option<Component>,
}

impl Default for ComponentSettings {
    fn default() -> Self {
        Self { environment: true, direct: true, indirect: true, solo: None }
    }
}

impl ComponentSettings {
    /// The switch of a component.
    pub fn switch_mut(&mut self, component: Component) -> &mut bool {
        match component {
            Component::Environment => &mut self.environment,
            Component::Direct => &mut self.direct,
            Component::Indirect => &mut self.indirect,
        }
    }

    /// Whether a component is shown.
    pub fn shows(mut self, component: Component) -> bool {
        self.solo.map_or_else(|| *self.switch_mut(component), |solo| solo == component)
    }

    /// The components that are shown.
    pub fn shown(self) -> Components {
        let [environment, direct, indirect] = Component::ALL.map(|component| self.shows(component));
        Components { environment, direct, indirect }
    }
}

/// Why a picture is black whatever the materials are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unlit {
    /// The bake has no light of the environment, and the scene has no lights.
    NoLights,
    /// There is light, and none of it is switched on.
    SwitchedOff,
}

impl Unlit {
    /// Why lights and what is shown of them leave a dataset in the dark; `None` where they do not.
    pub fn of(lights: &[Light], components: ComponentSettings, dataset: &Dataset) -> Option<Self> {
        let (shown, environment) = (components.shown(), dataset.settings.mode.environment());
        let bounces = shown.indirect && Bounces::of(dataset).any();
        let by_environment = environment && (shown.environment || bounces);
        let by_lights = lights.iter().any(Light::shines) && (shown.direct || bounces);
        match (by_environment || by_lights, lights.is_empty() && !environment) {
            (true, _) => None,
            (false, true) => Some(Self::NoLights),
            (false, false) => Some(Self::SwitchedOff),
        }
    }
}

/// The means of bounced light that a dataset has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounces {
    /// Surface samples and their visibility cuts.
    pub cuts: bool,
    /// A meshless basis and its transport.
    pub meshless: bool,
}

impl Bounces {
    /// Those of a dataset.
    pub fn of(dataset: &Dataset) -> Self {
        Self { cuts: dataset.indirect.is_some(), meshless: dataset.meshless.is_some() }
    }

    /// Whether there are any.
    pub fn any(self) -> bool {
        self.cuts || self.meshless
    }

    /// The solutions that can be chosen.
    pub fn solutions(self) -> Vec<Solution> {
        let all = [
            (Solution::Cuts, self.cuts),
            (Solution::Meshless, self.meshless),
            (Solution::CutsMeshless, self.cuts && self.meshless),
        ];
        all.into_iter().filter(|(_, has)| *has).map(|(solution, _)| solution).collect()
    }

    /// The wanted solution, or else one that there is.
    pub fn closest_to(self, wanted: Solution) -> Option<Solution> {
        let solutions = self.solutions();
        solutions.iter().find(|&&s| s == wanted).or(solutions.first()).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::test_data;
    use lapidary_core::{cut::packed::PackedCuts, dataset::BakeParts, indirect::IndirectBake};

    #[test]
    fn solo_shows_one_component_even_if_it_is_switched_off() {
        let mut settings = ComponentSettings { direct: false, ..Default::default() };
        let all = settings.shown();
        assert_eq!(all, Components { environment: true, direct: false, indirect: true });
        settings.solo = Some(Component::Direct);
        assert_eq!(settings.shown(), Components { environment: false, direct: true, indirect: false });
        settings.solo = None;
        assert_eq!(settings.shown(), all, "the switches are as they were");
    }

    #[test]
    fn a_picture_is_unlit_where_nothing_that_shines_is_shown() {
        let mut dataset = test_data::dataset(&["a"], &[]);
        let shows = |solo| ComponentSettings { solo, ..Default::default() };
        let off = ComponentSettings { environment: false, direct: false, indirect: false, solo: None };
        let unlit = |dataset: &Dataset, lights: &[Light], components| Unlit::of(lights, components, dataset);
        assert_eq!(unlit(&dataset, &[], shows(None)), None, "by the environment");
        assert_eq!(unlit(&dataset, &[], shows(Some(Component::Direct))), Some(Unlit::SwitchedOff));
        assert_eq!(unlit(&dataset, &[], off), Some(Unlit::SwitchedOff));
        dataset.settings.mode = BakeParts::MESHLESS;
        assert_eq!(unlit(&dataset, &[], shows(None)), Some(Unlit::NoLights));
        let lamp = test_data::light();
        assert_eq!(unlit(&dataset, std::slice::from_ref(&lamp), shows(None)), None);
        let bounce_alone = shows(Some(Component::Indirect));
        assert_eq!(unlit(&dataset, std::slice::from_ref(&lamp), bounce_alone), Some(Unlit::SwitchedOff));
        let (sources, cuts, environment_cuts) = (Vec::new(), PackedCuts::default(), PackedCuts::default());
        dataset.indirect = Some(IndirectBake { sources, cuts, environment_cuts });
        assert_eq!(unlit(&dataset, std::slice::from_ref(&lamp), bounce_alone), None, "by the bounce alone");
        let broken = Light { enabled: false, ..lamp };
        assert_eq!(unlit(&dataset, &[broken], shows(None)), Some(Unlit::SwitchedOff));
    }

    #[test]
    fn only_what_is_baked_can_be_chosen() {
        let bounces = |cuts, meshless| Bounces { cuts, meshless };
        assert!(bounces(false, false).solutions().is_empty());
        assert_eq!(bounces(false, false).closest_to(Solution::Cuts), None);
        assert_eq!(bounces(true, false).closest_to(Solution::CutsMeshless), Some(Solution::Cuts));
        assert_eq!(bounces(false, true).solutions(), [Solution::Meshless]);
        assert_eq!(bounces(true, true).closest_to(Solution::CutsMeshless), Some(Solution::CutsMeshless));
    }
}
