//! The BRDF model and the parameters that it declares, each with its map.

use super::{Changes, MaterialContext, MaterialPanel, maps, target::Target};
use crate::{
    actions::Action,
    widgets::{Number, color_row, entries::combo_row, group, note, section, slider_row},
};
use egui::Ui;
use lapidary_core::{
    brdf::Parameter,
    material::{BrdfModel, Material},
};

/// All rows.
pub fn show(
    ui: &mut Ui,
    state: &mut MaterialPanel,
    context: &MaterialContext,
    index: usize,
    changes: &mut Changes,
    actions: &mut Vec<Action>,
) {
    model(ui, changes);
    if changes.material.model.has_file() {
        super::brdf_file::show(ui, index, &changes.material, actions);
    }
    let mut shown = |ui: &mut Ui, changes: &mut Changes, parameter: &'static Parameter| {
        match parameter.is_color() {
            true => color(ui, parameter, changes),
            false => number(ui, parameter, changes),
        }
        maps::slot(ui, state, context, Target { index, kind: parameter.name }, changes, actions);
    };
    for part in changes.material.declared().chunk_by(|a, b| a.section == b.section) {
        match part[0].section {
            "" => part.iter().for_each(|parameter| shown(ui, changes, parameter)),
            title => {
                // A part without weight is folded.
                let is_there = changes.material.parameters.value(&part[0]).number() > 0.0;
                section(ui, title, is_there, |ui| {
                    group(ui, title, |ui| part.iter().for_each(|parameter| shown(ui, changes, parameter)));
                });
            }
        }
    }
    let stored = changes.material.stored_parameters();
    if !stored.is_empty() {
        section(ui, "Stored, not rendered", false, |ui| {
            note(ui, "Kept for other programs; the picture does not show them.");
            stored.iter().for_each(|parameter| shown(ui, changes, parameter));
        });
    }
}

fn model(ui: &mut Ui, changes: &mut Changes) {
    let models: Vec<_> = BrdfModel::ALL.iter().map(|&m| (m, m.label(), m.summary())).collect();
    let mut model = changes.material.model;
    let edited = combo_row(ui, "Model", "How the surface reflects light.", &mut model, &models);
    if edited.changed {
        changes.material.change_model(model);
    }
    changes.note("BRDF model", edited);
}

fn color(ui: &mut Ui, parameter: &'static Parameter, changes: &mut Changes) {
    let parameters = &mut changes.material.parameters;
    let mut color = parameters.value(parameter).color();
    let edited = color_row(ui, &parameter.short_label(), parameter.help, &mut color, parameter.default.color());
    if edited.changed {
        parameters.set(parameter.name, color);
    }
    changes.note(parameter.label, edited);
}

fn number(ui: &mut Ui, parameter: &'static Parameter, changes: &mut Changes) {
    let mut number = changes.material.parameters.value(parameter).number();
    let help = format!("{}{}", parameter.help, figure(parameter, number));
    let [[low, high], [from, to]] = [parameter.range, parameter.slider];
    let label = parameter.short_label();
    let row = Number::new(&label, &help, from..=to, parameter.default.number());
    let row = row.unit(parameter.unit, 3).entry(low..=high).disabled(unread(&changes.material, parameter));
    let edited = slider_row(ui, &row, &mut number);
    if edited.changed {
        changes.material.parameters.set(parameter.name, number);
    }
    changes.note(parameter.label, edited);
}

/// The meaning of a value, as a sentence.
fn figure(parameter: &Parameter, value: f32) -> String {
    match parameter.quantity {
        "roughness" => format!(" Now alpha = {:.4}.", value * value),
        "ior" => format!(" Reflects {:.1} % at normal incidence.", 100.0 * ((value - 1.0) / (value + 1.0)).powi(2)),
        _ => String::new(),
    }
}

/// Why a parameter has no effect, if it has none.
fn unread(material: &Material, parameter: &Parameter) -> Option<&'static str> {
    let metalness = material.parameter_for("metalness")?;
    let is_metal = material.parameters.value(metalness).number() >= 1.0 && material.maps.get(metalness.name).is_none();
    // OpenPBR's specular scales the reflection of metals too.
    let of_dielectrics = ["ior", "specular", "specular_ior"];
    (is_metal && of_dielectrics.contains(&parameter.name))
        .then_some("No effect now: a full metal's reflectance is its base color.")
}
