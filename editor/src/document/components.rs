//! The parts of the light in the picture.

use lapidary_core::{dataset::Dataset, lights::Light};
use lapidary_render::Components;
use serde::{Deserialize, Serialize};

/// A part of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Component {
    /// Direct light of the environment, and the environment as the background.
    Environment,
    /// Direct light of local lights.
    Direct,
    /// Bounced light of both.
    Indirect,
}

impl Component {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Environment, Self::Direct, Self::Indirect];
}

/// The switches of the parts, and the solo part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ComponentSettings {
    /// See [`Component::Environment`].
    pub environment: bool,
    /// See [`Component::Direct`].
    pub direct: bool,
    /// See [`Component::Indirect`].
    pub indirect: bool,
    /// Only this part is shown, whatever its switch says.
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

/// Why a picture is black with any material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unlit {
    /// The bake has no light of the environment, and the scene has no lights.
    NoLights,
    /// There is light, but all of it is switched off.
    SwitchedOff,
}

impl Unlit {
    /// Why these lights, emissive surfaces and components leave a dataset in the dark; `None` if they do not.
    pub fn of(lights: &[Light], shines: bool, components: ComponentSettings, dataset: &Dataset) -> Option<Self> {
        let (shown, environment) = (components.shown(), dataset.settings.mode.environment());
        let bounces = shown.indirect && dataset.has_bounces();
        let by_environment = environment && (shown.environment || bounces);
        let by_lights = (shines || lights.iter().any(Light::shines)) && (shown.direct || bounces);
        match (by_environment || by_lights, lights.is_empty() && !shines && !environment) {
            (true, _) => None,
            (false, true) => Some(Self::NoLights),
            (false, false) => Some(Self::SwitchedOff),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{cut::packed::PackedCuts, dataset::BakeParts, sources::IndirectBake, test_scenes};

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
        let mut dataset = test_scenes::dataset(&["a"], &[]);
        let shows = |solo| ComponentSettings { solo, ..Default::default() };
        let off = ComponentSettings { environment: false, direct: false, indirect: false, solo: None };
        let unlit = |dataset: &Dataset, lights: &[Light], components| Unlit::of(lights, false, components, dataset);
        assert_eq!(unlit(&dataset, &[], shows(None)), None, "by the environment");
        assert_eq!(unlit(&dataset, &[], shows(Some(Component::Direct))), Some(Unlit::SwitchedOff));
        assert_eq!(unlit(&dataset, &[], off), Some(Unlit::SwitchedOff));
        dataset.settings.mode = BakeParts::MESHLESS;
        assert_eq!(unlit(&dataset, &[], shows(None)), Some(Unlit::NoLights));
        let shining = |components| Unlit::of(&[], true, components, &dataset);
        assert_eq!([shining(shows(None)), shining(off)], [None, Some(Unlit::SwitchedOff)], "a surface that shines");
        let lamp = test_scenes::light();
        assert_eq!(unlit(&dataset, std::slice::from_ref(&lamp), shows(None)), None);
        let bounce_alone = shows(Some(Component::Indirect));
        assert_eq!(unlit(&dataset, std::slice::from_ref(&lamp), bounce_alone), Some(Unlit::SwitchedOff));
        let (sources, cuts, environment_cuts) = (Vec::new(), PackedCuts::default(), PackedCuts::default());
        dataset.indirect = Some(IndirectBake { sources, cuts, environment_cuts });
        assert_eq!(unlit(&dataset, std::slice::from_ref(&lamp), bounce_alone), None, "by the bounce alone");
        let broken = Light { enabled: false, ..lamp };
        assert_eq!(unlit(&dataset, &[broken], shows(None)), Some(Unlit::SwitchedOff));
    }
}
