//! What a bake is of: visibility of the environment, of surfaces that send light on, or both.

use crate::{
    actions::Action,
    panels::{entries::combo_row, widgets::check_row},
};
use egui::Ui;
use lapidary_core::dataset::BakeMode;

/// The choice for most bakes.
pub fn show(ui: &mut Ui, mode: BakeMode, actions: &mut Vec<Action>) {
    let mut choices = vec![
        (BakeMode::Environment, "Environment", "For scenes that are lit from outside. Local lights do not bounce."),
        (BakeMode::Indirect, "Bounce light", "For rooms that are lit by local lights alone."),
        (BakeMode::All, "Both", "Environment, local lights and the light that surfaces send on, in one picture."),
    ];
    if mode == BakeMode::Meshless {
        choices.push((mode, "Meshless bounces only", "See Advanced."));
    }
    let mut chosen = mode;
    if combo_row(ui, "Bake of", "What is baked; more takes longer.", &mut chosen, &choices).changed {
        actions.push(Action::ChooseBake(chosen));
    }
}

/// The choice for few: many bounces without the cuts.
pub fn advanced(ui: &mut Ui, mode: BakeMode, actions: &mut Vec<Action>) {
    let mut is_meshless = mode == BakeMode::Meshless;
    let help = "Bakes only the meshless basis: many soft bounces, no sharp ones. Both has it as well.";
    if check_row(ui, "Meshless bounces only", help, &mut is_meshless).changed {
        actions.push(Action::ChooseBake(if is_meshless { BakeMode::Meshless } else { BakeMode::Indirect }));
    }
}
