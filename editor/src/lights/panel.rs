//! Local lights: the components in the picture, the list of lights, and the numbers of the selected one.

mod buried;
mod components;
mod list;
mod properties;
#[cfg(test)]
mod tests;

pub use components::environment_hint;
pub use list::add_menu;

use crate::{
    actions::Action,
    document::{Document, lights::IntensityUnit},
    look::view_of,
    widgets::section,
};
use egui::{RichText, Ui};
use lapidary_core::{dataset::BakeParts, lights::Light, transport::BounceEnergy};
use lapidary_render::Baked;

/// Input of the panel.
pub struct LightsContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// The selected light.
    pub selected: Option<usize>,
    /// Parts of the shown bake that bounce light; `None` without a bake.
    pub bounces: Option<BakeParts>,
    /// Parts of the shown bake.
    pub baked: Option<BakeParts>,
    /// Light carried by the bounces in the picture, if known.
    pub energy: Option<BounceEnergy>,
    /// The scene in which lights may be buried.
    pub scene: Option<&'a Baked>,
    /// Size of the picture in pixels.
    pub size: [u32; 2],
    /// Whether there is a scene to bake.
    pub can_bake: bool,
    /// The suns of the environment's map, whether or not they are switched on.
    pub suns: &'a [Light],
}

/// State of the panel between frames.
pub struct LightsPanel {
    /// Whether the next click into the viewport aims the selected light.
    pub aiming: bool,
    /// Whether lights are drawn in the viewport.
    pub in_viewport: bool,
    /// Unit of intensities.
    pub unit: IntensityUnit,
    /// Whether clusters of bounced light are drawn there.
    pub shows_clusters: bool,
    buried: buried::Buried,
    renaming: Option<list::Renaming>,
}

impl Default for LightsPanel {
    fn default() -> Self {
        let buried = buried::Buried::default();
        let unit = IntensityUnit::default();
        Self { aiming: false, in_viewport: true, unit, shows_clusters: false, buried, renaming: None }
    }
}

impl LightsPanel {
    /// Another document is open.
    pub fn forget_document(&mut self) {
        (self.aiming, self.renaming) = (false, None);
    }
}

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut LightsPanel, context: &LightsContext, actions: &mut Vec<Action>) {
    section(ui, "In the picture", true, |ui| components::show(ui, state, context, actions));
    section(ui, "Lights", true, |ui| list::show(ui, state, context, actions));
    if let Some((index, light)) = context.selected.and_then(|i| Some((i, context.document.lights.get(i)?))) {
        let view = view_of(context.document, context.size);
        let is_buried = state.buried.contains(context.scene, index, light);
        let is_useless = !is_buried && light.shines() && state.buried.lights_nothing(context.scene, light, &view);
        section(ui, "Selected light", true, |ui| {
            if is_buried {
                ui.label(RichText::new(buried::NOTICE).color(ui.visuals().warn_fg_color));
            }
            if is_useless {
                ui.label(RichText::new(buried::LIGHTS_NOTHING).color(ui.visuals().warn_fg_color));
            }
            properties::show(ui, state, index, light, &context.document.camera, actions);
        });
    }
}
