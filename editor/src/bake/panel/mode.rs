//! The parts of a bake: light from outside, bounced light, or both. Each choice shows its effect and cost.

use super::estimate::Speed;
use crate::{
    actions::{Action, BakeAction},
    widgets::{check_row, entries::combo_row, units::duration},
};
use egui::{RichText, Ui};
use lapidary_core::dataset::{BakeParts, BakeSettings};

/// The list of bake types, and the effect and cost of the chosen one.
pub fn show(ui: &mut Ui, bake: &BakeSettings, speed: &Speed, actions: &mut Vec<Action>) {
    let mode = bake.mode;
    let mut modes = vec![
        BakeParts::ENVIRONMENT,
        BakeParts::INDIRECT,
        BakeParts::CUTS,
        BakeParts::ENVIRONMENT_MESHLESS,
        BakeParts::ALL,
    ];
    if !modes.contains(&mode) {
        modes.push(mode);
    }
    let costs: Vec<String> =
        modes.iter().map(|&mode| gives_and_costs(&BakeSettings { mode, ..bake.clone() }, speed)).collect();
    let choices: Vec<_> = modes.iter().zip(&costs).map(|(&mode, text)| (mode, name(mode), text.as_str())).collect();
    let mut chosen = mode;
    if combo_row(ui, "Bake type", "Light to bake; more takes longer.", &mut chosen, &choices).changed {
        actions.push(Action::Bake(BakeAction::Choose(chosen)));
    }
    ui.label(RichText::new(gives_and_costs(bake, speed)).weak().small());
}

/// Displayed name.
pub fn name(mode: BakeParts) -> &'static str {
    match (mode.environment(), mode.sources(), mode.meshless()) {
        (_, false, false) => "Environment",
        (false, true, false) => "Bounced light",
        (true, true, false) => "Environment and bounced light",
        (false, false, true) => "Many soft bounces only",
        (true, false, true) => "Environment and many soft bounces",
        (false, true, true) => "Bounced light, with many bounces",
        (true, true, true) => "All, with many bounces",
    }
}

fn gives(mode: BakeParts) -> &'static str {
    match (mode.environment(), mode.sources(), mode.meshless()) {
        (_, false, false) => "Environment light without bounces. For objects lit from outside.",
        (false, true, false) => {
            "One bounce of the local lights, sharp in glossy surfaces. No environment light. Fastest for a room with lamps."
        }
        (true, true, false) => {
            "Environment light, and one bounce of it and of the local lights. For a room with windows."
        }
        (false, false, true) => {
            "Many soft bounces of the local lights, none sharp in glossy surfaces. No environment light."
        }
        (true, false, true) => {
            "Environment light, and many soft bounces of it and of the local lights, none sharp in glossy surfaces."
        }
        (false, true, true) => {
            "Many bounces of the local lights: the first is sharp in glossy surfaces, later ones are soft. No environment light."
        }
        (true, true, true) => {
            "Environment light, and many bounces: the first is sharp in glossy surfaces, later ones are soft. Takes longest."
        }
    }
}

fn gives_and_costs(bake: &BakeSettings, speed: &Speed) -> String {
    let cost = speed.estimate(bake).map_or(String::new(), |e| format!(" About {}.", duration(e.secs)));
    gives(bake.mode).to_owned() + &cost
}

/// The rare choice of many bounces without cuts.
pub fn advanced(ui: &mut Ui, mode: BakeParts, actions: &mut Vec<Action>) {
    let mut is_meshless = mode == BakeParts::MESHLESS;
    if check_row(ui, "Many soft bounces only", gives(BakeParts::MESHLESS), &mut is_meshless).changed {
        actions.push(Action::Bake(BakeAction::Choose(if is_meshless {
            BakeParts::MESHLESS
        } else {
            BakeParts::INDIRECT
        })));
    }
}
