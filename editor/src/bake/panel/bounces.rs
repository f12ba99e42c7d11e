//! The settings of bounced light, each by itself: surface sources and the meshless basis, as far as a bake is of them.

use super::settings::count_row;
use crate::{
    actions::Action,
    document::Edit,
    widgets::{
        Number, edit_row,
        entries::{Decades, decades_row},
        slider_row,
    },
};
use egui::Ui;
use lapidary_core::{
    dataset::{BakeSettings, IndirectSettings, MeshlessSettings},
    light_tree::MAX_HEIGHT,
};

/// Height of the smallest tree of sources in the list: 1,024 of them.
const LEAST_HEIGHT: u32 = 10;
/// Levels of the meshless basis at most.
const MOST_LEVELS: usize = 8;

/// Rows of what the bake has.
pub fn advanced(ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
    if bake.mode.sources() {
        sources(ui, bake, actions);
    }
    if bake.mode.meshless() {
        basis(ui, bake, actions);
    }
}

fn wrap(bake: BakeSettings) -> Edit {
    Edit::Bake(Box::new(bake))
}

fn sources(ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
    let help = "Number of surface sources, a power of two. More give sharper bounces near surfaces.";
    edit_row(actions, "Sources", bake, wrap, |b| {
        count_row(ui, "Sources", help, (LEAST_HEIGHT..=MAX_HEIGHT).map(|h| 1 << h), &mut b.indirect.sources)
    });
    let help = "Error bound of a cluster of sources. Smaller gives finer cuts, and takes more memory and time.";
    let default = IndirectSettings::default().criterion.sigma;
    let sigma = Number::new("Source sigma", help, 0.5..=8.0, default).entry(0.0..=1e3);
    edit_row(actions, "Source sigma", bake, wrap, |b| slider_row(ui, &sigma, &mut b.indirect.criterion.sigma));
}

fn basis(ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
    let help = "Levels of the meshless basis, each four times as fine as the one before.";
    edit_row(actions, "Basis levels", bake, wrap, |b| {
        let edited = count_row(ui, "Basis levels", help, 1..=MOST_LEVELS, &mut b.meshless.levels);
        b.meshless.sender_levels = b.meshless.sender_levels.min(b.meshless.levels);
        edited
    });
    let help =
        "Levels that send light, counted from the coarsest. One more is slightly more accurate, and doubles the time.";
    edit_row(actions, "Sender levels", bake, wrap, |b| {
        let levels = 1..=b.meshless.levels;
        count_row(ui, "Sender levels", help, levels, &mut b.meshless.sender_levels)
    });
    let help = "Rays per basis function. Fewer are faster and noisier.";
    edit_row(actions, "Gather rays", bake, wrap, |b| {
        count_row(ui, "Gather rays", help, (6..=12).map(|power| 1 << power), &mut b.meshless.rays)
    });
    let help = "Links that carry less than this share of the light are dropped. Smaller is more accurate, takes more memory, and is slower when a light moves.";
    let default = f64::from(MeshlessSettings::default().epsilon);
    let epsilon = Decades { decimals: 5, ..Decades::count("Epsilon", help, 0.0..=1.0, default) };
    edit_row(actions, "Epsilon", bake, wrap, |b| decades_row(ui, &epsilon, &mut b.meshless.epsilon));
}
