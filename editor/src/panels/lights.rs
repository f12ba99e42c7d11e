//! Local lights: which light is in the picture, the list of lights, and the numbers of the selected one.

mod components;
mod list;
mod properties;
#[cfg(test)]
mod tests;

pub use list::add_menu;

use super::widgets::section;
use crate::{
    actions::Action,
    document::{Bounces, Document},
};
use egui::Ui;

/// What the panel shows.
pub struct LightsContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// The selected light.
    pub selected: Option<usize>,
    /// What the bake that is shown has for bounced light; `None` without a bake.
    pub bounces: Option<Bounces>,
    /// Whether there is a scene to bake.
    pub can_bake: bool,
}

/// What the panel keeps between frames.
pub struct LightsPanel {
    /// Whether the next click into the viewport aims the selected light.
    pub aiming: bool,
    /// Whether lights are drawn in the viewport.
    pub in_viewport: bool,
    renaming: Option<list::Renaming>,
}

impl Default for LightsPanel {
    fn default() -> Self {
        Self { aiming: false, in_viewport: true, renaming: None }
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
    section(ui, "In the picture", true, |ui| components::show(ui, context, actions));
    section(ui, "Lights", true, |ui| list::show(ui, state, context, actions));
    if let Some((index, light)) = context.selected.and_then(|i| Some((i, context.document.lights.get(i)?))) {
        section(ui, "Selected light", true, |ui| {
            properties::show(ui, state, index, light, &context.document.camera, actions);
        });
    }
}
