//! Which parts of the light are in the picture, and how bounced light is computed.

use super::LightsContext;
use crate::{
    actions::Action,
    document::{Bounces, Component, ComponentSettings, Edit},
    panels::{
        edit_row,
        entries::combo_row,
        widgets::{Edited, check_box, row},
    },
};
use egui::{Button, RichText, Ui};
use lapidary_core::dataset::BakeMode;
use lapidary_render::Solution;

/// Shows switches, solo buttons and the solution.
pub fn show(ui: &mut Ui, context: &LightsContext, actions: &mut Vec<Action>) {
    for component in Component::ALL {
        edit_row(actions, "Light in the picture", &context.document.components, Edit::Components, |settings| {
            component_row(ui, component, settings)
        });
    }
    match context.bounces {
        Some(bounces) if bounces.any() => solution(ui, bounces, context.document.solution, actions),
        Some(_) => hint(ui, "This bake has no bounce light.", context.can_bake, actions),
        None => hint(ui, "Nothing is baked yet.", context.can_bake, actions),
    }
}

fn texts(component: Component) -> (&'static str, &'static str) {
    match component {
        Component::Environment => {
            ("Environment", "Light that comes straight from the environment, and the environment behind the scene.")
        }
        Component::Direct => ("Lights", "Light that comes straight from the lights below, with their shadows."),
        Component::Indirect => {
            ("Bounce", "Light that surfaces send on to each other, of the lights and of the environment.")
        }
    }
}

fn component_row(ui: &mut Ui, component: Component, settings: &mut ComponentSettings) -> Edited {
    let (label, help) = texts(component);
    row(ui, label, help, false, |ui, name, _| {
        let before = *settings;
        // What is soloed elsewhere does not show here, whatever the switch says.
        ui.scope(|ui| {
            if settings.solo.is_some_and(|solo| solo != component) {
                ui.set_opacity(0.5);
            }
            name.of(check_box(ui, settings.switch_mut(component), "")).on_hover_text(help);
        });
        let is_solo = settings.solo == Some(component);
        let solo = ui.add(Button::new("Solo").selected(is_solo).small()).accessible_name(format!("Solo {}", name.full));
        if solo.on_hover_text("Shows this light alone; click again for all that are switched on").clicked() {
            settings.solo = (!is_solo).then_some(component);
        }
        Edited::at_once(*settings != before)
    })
}

fn solution(ui: &mut Ui, bounces: Bounces, wanted: Solution, actions: &mut Vec<Action>) {
    let solutions = bounces.solutions();
    let Some(now) = bounces.closest_to(wanted) else { return };
    let choices: Vec<_> = solutions.iter().map(|&s| (s, name(s), meaning(s))).collect();
    edit_row(actions, "Bounce light by", &now, Edit::Solution, |solution| {
        combo_row(ui, "Bounce by", "How bounced light is computed.", solution, &choices)
    });
    ui.label(RichText::new(meaning(now)).weak().small());
}

fn name(solution: Solution) -> &'static str {
    match solution {
        Solution::Cuts => "Cuts",
        Solution::Meshless => "Meshless",
        Solution::CutsMeshless => "Cuts over meshless",
    }
}

fn meaning(solution: Solution) -> &'static str {
    match solution {
        Solution::Cuts => "One bounce, sharp in glossy and bumped surfaces.",
        Solution::Meshless => "Many bounces, soft: the fastest while a light moves.",
        Solution::CutsMeshless => "Many bounces, the last one sharp in glossy and bumped surfaces.",
    }
}

fn hint(ui: &mut Ui, text: &str, can_bake: bool, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.weak(text);
        let button = ui.add_enabled(can_bake, Button::new("Bake with bounce light"));
        let button = button.on_hover_text("Opens the bake settings, with bounce light chosen");
        if button.on_disabled_hover_text("Open the scene file to bake it").clicked() {
            actions.push(Action::ChooseBake(BakeMode::All));
        }
    });
}
