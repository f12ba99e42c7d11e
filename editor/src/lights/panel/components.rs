//! The parts of the light in the picture, and the method of bounced light.

use super::{LightsContext, LightsPanel};
use crate::{
    actions::{Action, BakeAction},
    document::{Component, ComponentSettings, Document, Edit},
    widgets::{Edited, check_box, edit_row, entries::combo_row, note, row},
};
use egui::{Button, RichText, Ui};
use lapidary_core::{dataset::BakeParts, transport::BounceEnergy};
use lapidary_render::{Solution, ViewMode};
use lapidary_studies::missing_light;

/// Shows switches, solo buttons and the solution.
pub fn show(ui: &mut Ui, state: &mut LightsPanel, context: &LightsContext, actions: &mut Vec<Action>) {
    for component in Component::ALL {
        edit_row(actions, "Light in the picture", &context.document.components, Edit::Components, |settings| {
            component_row(ui, component, settings)
        });
    }
    match context.bounces {
        Some(bounces) if bounces != BakeParts::NONE => {
            let now = Solution::closest_to(context.document.solution, bounces);
            solution(ui, bounces, context.document.solution, actions);
            bounce_energy(ui, context.energy);
            if bounces.sources() {
                clusters(ui, &mut state.shows_clusters, no_clusters(context.document, now));
            }
        }
        Some(_) => bounce_hint(ui, "This bake has no bounced light.", context, actions),
        None => bounce_hint(ui, "Nothing is baked yet.", context, actions),
    }
    if context.document.components.shows(Component::Environment) {
        environment_hint(ui, context.baked, context.document.bake.mode, context.can_bake, actions);
    }
}

/// The switch of the clusters, or why it has no effect now.
fn clusters(ui: &mut Ui, shown: &mut bool, obstacle: Option<&str>) {
    let help = "Draws the surface sources, colored by cluster. Cuts gather light cluster by cluster";
    ui.add_enabled_ui(obstacle.is_none(), |ui| {
        let switch = check_box(ui, shown, "Show clusters in the viewport").on_hover_text(help);
        switch.on_disabled_hover_text(obstacle.unwrap_or_default());
    });
}

fn no_clusters(document: &Document, solution: Option<Solution>) -> Option<&'static str> {
    if !document.components.shows(Component::Indirect) {
        Some("Bounced light is off: switch it on above")
    } else if solution.is_some_and(|solution| !solution.needs().sources()) {
        Some("Only cuts use clusters: choose another method above")
    } else if document.view.mode != ViewMode::Shaded {
        Some("Clusters are drawn over the lit picture: choose the view mode Shaded")
    } else {
        None
    }
}

/// Hints that the bake has no environment light, with a button to bake it.
pub fn environment_hint(
    ui: &mut Ui,
    baked: Option<BakeParts>,
    wanted: BakeParts,
    can_bake: bool,
    actions: &mut Vec<Action>,
) {
    let Some(baked) = baked.filter(|mode| !mode.environment()) else { return };
    let mode = baked.with(wanted).with(BakeParts::ENVIRONMENT);
    let text = "This bake has no environment light.";
    hint(ui, text, "Bake with the environment", mode, can_bake, actions);
}

/// Light carried by the bounces, and advice if much is missing.
fn bounce_energy(ui: &mut Ui, energy: Option<BounceEnergy>) {
    let Some(energy) = energy else { return };
    let BounceEnergy { bounces, last_share, .. } = energy;
    let text = format!("Bounces: {bounces}, the last carries {} of the light.", missing_light::percent(last_share));
    ui.label(RichText::new(text).weak().small());
    if let Some(remark) = missing_light::remark(energy) {
        ui.label(RichText::new(remark).color(ui.visuals().warn_fg_color));
    }
}

fn texts(component: Component) -> (&'static str, &'static str) {
    match component {
        Component::Environment => {
            ("Environment", "Direct light of the environment, and the environment as background.")
        }
        Component::Direct => ("Lights", "Direct light of the lights below, with shadows."),
        Component::Indirect => ("Bounce", "Light that surfaces reflect onto each other."),
    }
}

fn component_row(ui: &mut Ui, component: Component, settings: &mut ComponentSettings) -> Edited {
    let (label, help) = texts(component);
    row(ui, label, help, false, |ui, name, _| {
        let before = *settings;
        // A part that is not soloed is grayed, whatever its switch says.
        ui.scope(|ui| {
            if settings.solo.is_some_and(|solo| solo != component) {
                ui.set_opacity(0.5);
            }
            name.of(check_box(ui, settings.switch_mut(component), "")).on_hover_text(help);
        });
        let is_solo = settings.solo == Some(component);
        let solo = ui.add(Button::new("Solo").selected(is_solo).small()).accessible_name(format!("Solo {}", name.full));
        if solo.on_hover_text("Shows only this part of the light; click again to show all enabled parts").clicked() {
            settings.solo = (!is_solo).then_some(component);
        }
        Edited::at_once(*settings != before)
    })
}

fn solution(ui: &mut Ui, bounces: BakeParts, wanted: Solution, actions: &mut Vec<Action>) {
    let solutions = Solution::of(bounces);
    let Some(now) = Solution::closest_to(wanted, bounces) else { return };
    let choices: Vec<_> = solutions.iter().map(|&s| (s, s.label(), s.summary())).collect();
    edit_row(actions, "Bounce method", &now, Edit::Solution, |solution| {
        combo_row(ui, "Bounce method", "Method that computes bounced light.", solution, &choices)
    });
    note(ui, now.summary());
}

/// Hints at bounced light, with a button to bake it and all present parts.
fn bounce_hint(ui: &mut Ui, text: &str, context: &LightsContext, actions: &mut Vec<Action>) {
    let asked = context.document.bake.mode;
    let wanted = context.baked.map_or(asked, |baked| asked.with(baked));
    let has_bounces = wanted.bounces();
    let mode = if has_bounces { wanted } else { wanted.with(BakeParts::INDIRECT) };
    hint(ui, text, "Bake with bounced light", mode, context.can_bake, actions);
}

fn hint(ui: &mut Ui, text: &str, button: &str, mode: BakeParts, can_bake: bool, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.weak(text);
        let button = ui.add_enabled(can_bake, Button::new(button));
        let button = button.on_hover_text("Opens the bake settings with this type chosen");
        if button.on_disabled_hover_text("Open the scene file to bake it").clicked() {
            actions.push(Action::Bake(BakeAction::Choose(mode)));
        }
    });
}
