//! The parts of a bake: light from outside, bounced light, or both. Each choice shows its effect and cost.

use super::estimate::Speed;
use crate::{
    actions::{Action, BakeAction},
    widgets::{check_row, entries::combo_row, units::duration},
};
use egui::{RichText, Ui};
use lapidary_core::dataset::{BakePart, BakeParts, BakeSettings};

/// Bake types with name and effect. The list offers the first [`LISTED`].
const TYPES: [(BakeParts, &str, &str); 10] = [
    (BakeParts::ENVIRONMENT, "Environment", "Environment light without bounces. For objects lit from outside."),
    (
        BakeParts::INDIRECT,
        "Bounced light",
        "One bounce of the local lights, sharp in glossy surfaces. No environment light. Fastest for a room with lamps.",
    ),
    (
        BakeParts::CUTS,
        "Environment and bounced light",
        "Environment light, and one bounce of it and of the local lights. For a room with windows.",
    ),
    (
        BakeParts::ENVIRONMENT_MESHLESS,
        "Environment and many soft bounces",
        "Environment light, and many soft bounces of it and of the local lights, none sharp in glossy surfaces.",
    ),
    (
        BakeParts::ALL,
        "All, with many bounces",
        "Environment light, and many bounces: the first is sharp in glossy surfaces, later ones are soft. Takes longest.",
    ),
    (
        BakeParts::ENVIRONMENT.with(BakeParts::RADIOSITY),
        "Environment and moving objects",
        "Environment light, and many soft bounces that are solved anew when an object was moved.",
    ),
    (
        BakeParts::WAVELET,
        "Glossy bounces between quads",
        "Many bounces of the local lights, also from gloss to gloss, in a scene of quads alone. No environment light.",
    ),
    (
        BakeParts::RADIOSITY,
        "Moving objects only",
        "Many soft bounces of the local lights, solved anew when an object was moved. No environment light.",
    ),
    (
        BakeParts::MESHLESS,
        "Many soft bounces only",
        "Many soft bounces of the local lights, none sharp in glossy surfaces. No environment light.",
    ),
    (
        BakeParts::INDIRECT.with(BakeParts::MESHLESS),
        "Bounced light, with many bounces",
        "Many bounces of the local lights: the first is sharp in glossy surfaces, later ones are soft. No environment light.",
    ),
];
/// Types in the list.
const LISTED: usize = 7;

/// The list of bake types, and the effect and cost of the chosen one.
pub fn show(ui: &mut Ui, bake: &BakeSettings, speed: &Speed, actions: &mut Vec<Action>) {
    let mode = bake.mode;
    let mut modes: Vec<BakeParts> = TYPES[..LISTED].iter().map(|(mode, ..)| *mode).collect();
    if !modes.contains(&mode) {
        modes.push(mode);
    }
    let told = |&mode: &BakeParts| (mode, name(mode), gives_and_costs(&BakeSettings { mode, ..bake.clone() }, speed));
    let told: Vec<_> = modes.iter().map(told).collect();
    let choices: Vec<_> = told.iter().map(|(mode, name, text)| (*mode, name.as_str(), text.as_str())).collect();
    let mut chosen = mode;
    if combo_row(ui, "Bake type", "Light to bake; more takes longer.", &mut chosen, &choices).changed {
        actions.push(Action::Bake(BakeAction::Choose(chosen)));
    }
    ui.label(RichText::new(gives_and_costs(bake, speed)).weak().small());
}

/// Displayed name: that of the type, or else what the parts store.
pub fn name(mode: BakeParts) -> String {
    let known = TYPES.iter().find(|(known, ..)| *known == mode).map(|(_, name, _)| (*name).to_owned());
    known.unwrap_or_else(|| mode.parts().map(BakePart::noun).collect::<Vec<_>>().join(", "))
}

fn gives(mode: BakeParts) -> &'static str {
    TYPES.iter().find(|(known, ..)| *known == mode).map_or("", |(.., gives)| gives)
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
