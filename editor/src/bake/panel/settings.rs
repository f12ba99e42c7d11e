//! The settings of the next bake: presets with their cost, and every single setting.

use super::{
    BakeContext,
    estimate::{Estimate, Speed},
};
use crate::{
    actions::Action,
    bake::parts::{self, bake_row},
    control_names::error_text,
    document::Edit,
    widgets::{
        check_row, copyable,
        entries::{Decades, limit_row},
        units::{bytes, duration, grouped},
    },
};
use egui::{Button, Grid, RichText, Ui};
use lapidary_core::dataset::{BakePart, BakeSettings, IndirectSettings};
use lapidary_precompute::{Preset, resolve};

const PRESETS: [(Preset, &str, &str); 3] = [
    (
        Preset::Draft,
        "Draft",
        "A quarter of the lights, few vertices and a coarse meshless basis, for setting up a scene.",
    ),
    (Preset::Normal, "Normal", "32,768 lights and sigma 2, as in the paper."),
    (Preset::High, "High", "Finer cuts and three times the vertices, for final pictures."),
];

/// The presets with their estimated cost.
pub fn presets(ui: &mut Ui, context: &BakeContext, speed: &Speed, actions: &mut Vec<Action>) {
    let bake = &context.document.bake;
    Grid::new("presets").num_columns(4).show(ui, |ui| {
        for title in ["Preset", "Vertices", "Time", "Size"] {
            ui.label(RichText::new(title).weak().small());
        }
        ui.end_row();
        for (preset, name, help) in PRESETS {
            let settings = of_preset(preset, context);
            if ui.add(Button::selectable(*bake == settings, name)).on_hover_text(help).clicked() {
                let edit = Edit::Bake(Box::new(settings.clone()));
                actions.extend([Action::Edit { edit, label: "Bake preset" }, Action::EndGesture]);
            }
            cost(ui, speed.estimate(&settings));
        }
        if PRESETS.iter().all(|(preset, ..)| *bake != of_preset(*preset, context)) {
            ui.label("Custom").on_hover_text("The settings below.");
            cost(ui, speed.estimate(bake));
        }
    });
    let source = match (context.dataset, context.trial.is_some() || context.bounce_trial.is_some()) {
        (Some(_), _) => "the last bake",
        (None, true) => "a trial of this scene",
        (None, false) => "other scenes",
    };
    ui.label(RichText::new(format!("Times and sizes are estimates from {source}.")).weak().small());
}

/// A preset with the present parts, ground, views and viewpoint.
fn of_preset(preset: Preset, context: &BakeContext) -> BakeSettings {
    let bake = &context.document.bake;
    let settings = preset.settings_for(context.source_vertices().unwrap_or(0));
    let indirect = IndirectSettings { viewpoint: bake.indirect.viewpoint, ..settings.indirect };
    BakeSettings { mode: bake.mode, ground: bake.ground, shots: bake.shots.clone(), indirect, ..settings }
}

/// The rest of a preset's row; a dash where the size of the scene is not known.
fn cost(ui: &mut Ui, estimate: Option<Estimate>) {
    let texts = estimate.map_or(["-".into(), "-".into(), "-".into()], |e| {
        [grouped(e.vertices as u64), duration(e.secs), bytes(e.bytes)]
    });
    for text in texts {
        ui.label(text);
    }
    ui.end_row();
}

/// Every single setting, and errors in them. Every bake has the environment's settings, since it has its light tree.
pub fn advanced(ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
    parts::of(BakePart::Environment).controls(ui, bake, actions);
    let help = "Spreads added vertices evenly instead of where visibility varies: faster, for a first look.";
    bake_row(actions, "Even vertices", bake, |b| check_row(ui, "Even vertices", help, &mut b.even_vertices));
    let help = "Traces every light and surface source from every vertex. Off follows boundaries, which is faster; an audit \
                keeps its error within 1 %.";
    bake_row(actions, "Trace every light", bake, |b| check_row(ui, "Trace every light", help, &mut b.exhaustive));
    let help = "Splits triangles where visibility varies, up to this many vertices. Off keeps the mesh as it is.";
    let vertices = Decades::count("Max vertices", help, 0.0..=1e9, 100_000.0);
    bake_row(actions, "Max vertices", bake, |b| limit_row(ui, &vertices, &mut b.max_vertices));
    if let Err(error) = resolve(bake.clone()) {
        copyable(ui, RichText::new(error_text(&error)).color(ui.visuals().error_fg_color));
    }
    for part in bake.mode.parts().filter(|part| part.bounces()) {
        parts::of(part).controls(ui, bake, actions);
    }
}
