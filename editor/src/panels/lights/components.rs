//! Which parts of the light are in the picture, and how bounced light is computed.

use super::{LightsContext, LightsPanel};
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
use lapidary_core::{dataset::BakeMode, meshless::BounceEnergy};
use lapidary_render::Solution;

/// Share of the light above which it is said that bounces are missing: a few percent are not seen.
const MUCH_MISSING: f32 = 0.1;

/// Shows switches, solo buttons and the solution.
pub fn show(ui: &mut Ui, state: &mut LightsPanel, context: &LightsContext, actions: &mut Vec<Action>) {
    for component in Component::ALL {
        edit_row(actions, "Light in the picture", &context.document.components, Edit::Components, |settings| {
            component_row(ui, component, settings)
        });
    }
    match context.bounces {
        Some(bounces) if bounces.any() => {
            solution(ui, bounces, context.document.solution, actions);
            fading(ui, context.energy);
            if bounces.cuts {
                let help = "Draws the surface points that send light on, in the color of the cluster that each is in: \
                            light is gathered from one cluster at a time";
                check_box(ui, &mut state.shows_clusters, "Show clusters in the viewport").on_hover_text(help);
            }
        }
        Some(_) => bounce_hint(ui, "This bake has no bounce light.", context, actions),
        None => bounce_hint(ui, "Nothing is baked yet.", context, actions),
    }
    if context.document.components.shows(Component::Environment) {
        environment_hint(ui, context.baked, context.can_bake, actions);
    }
}

/// Says that there is no light of the environment in a bake without it, and leads to one with it.
pub fn environment_hint(ui: &mut Ui, baked: Option<BakeMode>, can_bake: bool, actions: &mut Vec<Action>) {
    let Some(baked) = baked.filter(|mode| !mode.environment()) else { return };
    let mode = if baked.meshless() { BakeMode::All } else { BakeMode::Cuts };
    let text = "This bake has no light of the environment.";
    hint(ui, text, "Bake with the environment", mode, can_bake, actions);
}

/// How much light the bounces carry, and what to do if much is left when they end.
fn fading(ui: &mut Ui, energy: Option<BounceEnergy>) {
    let Some(BounceEnergy { bounces, last_share, missing_share }) = energy else { return };
    let text = format!("Bounces: {bounces}, the last carries {} of the light.", percent(last_share));
    ui.label(RichText::new(text).weak().small());
    if missing_share > MUCH_MISSING {
        let text = if missing_share < 1.0 {
            format!("About {} of the light is missing, for it would bounce on.", percent(missing_share))
        } else {
            "The light would bounce on without end: surfaces reflect all of it.".into()
        };
        let remedy = "Lower the base color of the brightest materials, below 0.8, to see it all.";
        ui.label(RichText::new(format!("{text} {remedy}")).color(ui.visuals().warn_fg_color));
    }
}

fn percent(share: f32) -> String {
    let percent = 100.0 * share;
    if percent < 10.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
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

/// Leads to a bake of bounce light that loses nothing of what is baked.
fn bounce_hint(ui: &mut Ui, text: &str, context: &LightsContext, actions: &mut Vec<Action>) {
    let mode = match context.document.bake.mode {
        BakeMode::Environment => BakeMode::Cuts,
        with_bounces => with_bounces,
    };
    hint(ui, text, "Bake with bounce light", mode, context.can_bake, actions);
}

fn hint(ui: &mut Ui, text: &str, button: &str, mode: BakeMode, can_bake: bool, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.weak(text);
        let button = ui.add_enabled(can_bake, Button::new(button));
        let button = button.on_hover_text("Opens the bake settings, with this chosen");
        if button.on_disabled_hover_text("Open the scene file to bake it").clicked() {
            actions.push(Action::ChooseBake(mode));
        }
    });
}
