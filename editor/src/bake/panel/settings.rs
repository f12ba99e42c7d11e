//! The settings of the next bake: presets with their cost, and every setting by itself.

use super::{
    BakeContext,
    estimate::{Estimate, Speed},
};
use crate::{
    actions::Action,
    bake::stale::tree_name,
    control_names::error_text,
    document::Edit,
    widgets::{
        Edited, Number, check_row, copyable, edit_row,
        entries::{Decades, combo_row, limit_row},
        slider_row,
        units::{bytes, duration, grouped},
    },
};
use egui::{Button, Grid, RichText, Ui};
use lapidary_core::{
    dataset::{BakeSettings, IndirectSettings},
    light_tree::{MAX_HEIGHT, TreeKind},
};
use lapidary_precompute::{Preset, resolve};

/// Height of the smallest tree in the list: 256 lights. Fewer are for tests.
const LEAST_HEIGHT: u32 = 8;

const PRESETS: [(Preset, &str, &str); 3] = [
    (
        Preset::Draft,
        "Draft",
        "A quarter of the lights, few vertices and a coarse meshless basis, for setting up a scene.",
    ),
    (Preset::Normal, "Normal", "32,768 lights and sigma 2, as in the paper."),
    (Preset::High, "High", "Finer cuts and three times the vertices, for final pictures."),
];

/// The presets, and what each will take.
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

/// A preset for what is baked now, over the same ground, for the same views and from the same viewpoint.
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

/// Every setting by itself, and what is wrong with them.
pub fn advanced(ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
    let wrap = |bake: BakeSettings| Edit::Bake(Box::new(bake));
    edit_row(actions, "Lights", bake, wrap, |b| lights_row(ui, b));
    let kinds = [
        (TreeKind::Mixed, tree_name(TreeKind::Mixed), "By direction and visibility (Eq. 12)."),
        (TreeKind::Geometric, tree_name(TreeKind::Geometric), "By direction alone (Eq. 10)."),
        (TreeKind::DataDriven, tree_name(TreeKind::DataDriven), "By visibility alone (Eq. 11)."),
    ];
    edit_row(actions, "Light tree", bake, wrap, |b| {
        combo_row(ui, "Light tree", "The metric that clusters lights.", &mut b.tree, &kinds)
    });
    let unused = (bake.tree != TreeKind::Mixed).then_some("Only mixed trees use it.");
    let beta = Number::new("Beta", "Weight of direction against visibility in a mixed tree, 0 to 1.", 0.0..=1.0, 0.5);
    edit_row(actions, "Beta", bake, wrap, |b| slider_row(ui, &beta.disabled(unused), &mut b.beta));
    let help = "Error bound of a cluster (Eq. 5). Smaller gives finer cuts, and takes more memory and time.";
    let sigma = Number::new("Sigma", help, 0.5..=8.0, 2.0).entry(0.0..=1e4);
    edit_row(actions, "Sigma", bake, wrap, |b| slider_row(ui, &sigma, &mut b.criterion.sigma));
    let help = "Traces every light and surface source from every vertex. Otherwise boundaries are followed, which takes a \
                fraction of the time; an audit keeps the error within 1 %.";
    let even = "Spreads further vertices evenly, without asking where visibility varies: faster, for a first look.";
    edit_row(actions, "Even vertices", bake, wrap, |b| check_row(ui, "Even vertices", even, &mut b.even_vertices));
    edit_row(actions, "Trace every light", bake, wrap, |b| check_row(ui, "Trace every light", help, &mut b.exhaustive));
    limits(ui, bake, actions);
    if let Err(error) = resolve(bake.clone()) {
        copyable(ui, RichText::new(error_text(&error)).color(ui.visuals().error_fg_color));
    }
}

fn lights_row(ui: &mut Ui, bake: &mut BakeSettings) -> Edited {
    let help = "Samples of the environment: a power of two.";
    count_row(ui, "Lights", help, (LEAST_HEIGHT..=MAX_HEIGHT).map(|h| 1 << h), &mut bake.lights)
}

/// A number out of a list, which also has the present one.
pub(super) fn count_row(
    ui: &mut Ui,
    label: &str,
    help: &str,
    counts: impl Iterator<Item = usize>,
    value: &mut usize,
) -> Edited {
    let mut counts: Vec<usize> = counts.collect();
    if !counts.contains(value) {
        counts.push(*value);
    }
    let names: Vec<String> = counts.iter().map(|&n| grouped(n as u64)).collect();
    let choices: Vec<(usize, &str, &str)> =
        counts.iter().zip(&names).map(|(&n, name)| (n, name.as_str(), "")).collect();
    combo_row(ui, label, help, value, &choices)
}

fn limits(ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
    let wrap = |bake: BakeSettings| Edit::Bake(Box::new(bake));
    let help =
        "Splits triangles where visibility varies until there are this many. Without it the mesh stays as it is.";
    let vertices = Decades::count("Max vertices", help, 0.0..=1e9, 100_000.0);
    edit_row(actions, "Max vertices", bake, wrap, |b| limit_row(ui, &vertices, &mut b.max_vertices));
    let help = "Limit of the environment cuts in megabytes. All cuts are coarsened alike until they fit.";
    let size = Decades { unit: " MB", decimals: 1, ..Decades::count("Byte budget", help, 0.0..=1e7, 64.0) };
    edit_row(actions, "Byte budget", bake, wrap, |b| {
        let mut megabytes = b.max_bytes.map(|bytes| bytes as f64 / 1e6);
        let edited = limit_row(ui, &size, &mut megabytes);
        if edited.changed {
            b.max_bytes = megabytes.map(|m| (m * 1e6).round() as u64);
        }
        edited
    });
    let help = "A cut is refined until the root of its summed squared errors is below this, in lights.";
    let error = Decades { decimals: 1, ..Decades::count("Total error", help, 0.0..=1e4, 16.0) };
    edit_row(actions, "Total error", bake, wrap, |b| limit_row(ui, &error, &mut b.criterion.total_error));
}
