//! The BRDF model and its eight parameters. What the model does not read is greyed and says why.

use super::{
    Changes, MaterialPanel,
    maps::{self, Target},
};
use crate::{
    actions::Action,
    document::Document,
    panels::widgets::{Number, choice_row, color_row, slider_row},
};
use egui::Ui;
use lapidary_core::material::{BrdfModel, BrdfParameters, MapKind, Material};

const MODELS: [(BrdfModel, &str, &str); 3] = [
    (BrdfModel::Lambert, "Lambert", "Ideal diffuse reflection: chalk, plaster. Reads the base color only."),
    (
        BrdfModel::Ggx,
        "GGX",
        "Microfacets with Fresnel over a diffuse base, as in glTF and most renderers. Highlights with long tails.",
    ),
    (
        BrdfModel::Ward,
        "Ward",
        "A Gaussian lobe over a diffuse base, without Fresnel. Highlights with sharp ends; brushed metals.",
    ),
];

/// All rows, each with its map.
pub fn show(
    ui: &mut Ui,
    state: &mut MaterialPanel,
    document: &Document,
    index: usize,
    changes: &mut Changes,
    actions: &mut Vec<Action>,
) {
    let edited = choice_row(ui, "Model", "How light is reflected.", &mut changes.material.model, &MODELS);
    changes.note("BRDF model", edited);
    let mut map = |ui: &mut Ui, changes: &mut Changes, kind: MapKind| {
        if diffuse_only(&changes.material).is_none() || kind == MapKind::BaseColor {
            maps::slot(ui, state, document, Target { index, kind }, changes, actions);
        }
    };
    base_color(ui, changes);
    map(ui, changes, MapKind::BaseColor);
    number(ui, changes, "Roughness", |p| &mut p.roughness);
    map(ui, changes, MapKind::Roughness);
    number(ui, changes, "Metalness", |p| &mut p.metalness);
    map(ui, changes, MapKind::Metalness);
    number(ui, changes, "Specular", |p| &mut p.specular);
    map(ui, changes, MapKind::Specular);
    number(ui, changes, "IOR", |p| &mut p.ior);
    map(ui, changes, MapKind::Ior);
    number(ui, changes, "Anisotropy", |p| &mut p.anisotropy);
    map(ui, changes, MapKind::Anisotropy);
}

fn base_color(ui: &mut Ui, changes: &mut Changes) {
    let help = "Diffuse albedo of a dielectric, reflectance at normal incidence of a metal. The hex is sRGB; \
                the value is kept linear, 0 to 1.";
    let default = BrdfParameters::default().base_color;
    let edited = color_row(ui, "Base color", help, &mut changes.material.parameters.base_color, default);
    changes.note("Base color", edited);
}

/// The row of a number by its label.
fn number(ui: &mut Ui, changes: &mut Changes, label: &'static str, field: impl Fn(&mut BrdfParameters) -> &mut f32) {
    let help = help(label, &changes.material.parameters);
    let (range, entry) = match label {
        "IOR" => (1.0..=3.0, 1.0..=10.0),
        "Anisotropy" => (-1.0..=1.0, -1.0..=1.0),
        _ => (0.0..=1.0, 0.0..=1.0),
    };
    let default = *field(&mut BrdfParameters::default());
    let row = Number::new(label, &help, range, default).unit("", 3).entry(entry);
    let reason = unread(&changes.material, label);
    let edited = slider_row(ui, &row.disabled(reason), field(&mut changes.material.parameters));
    changes.note(label, edited);
}

fn help(label: &str, p: &BrdfParameters) -> String {
    match label {
        "Roughness" => format!(
            "Width of the highlight, 0 (mirror) to 1 (dull). Perceptual: the microfacet width is alpha = roughness² = {:.4}.",
            p.roughness * p.roughness
        ),
        "Metalness" => "0 for a dielectric, 1 for a metal. Values between are for transitions in maps.".into(),
        "Specular" => {
            "Weight of a dielectric's highlight, 0 (none) to 1 (all that its index of refraction gives).".into()
        }
        "IOR" => format!(
            "Index of refraction of a dielectric, 1 to 10: water 1.33, most plastics and glass 1.5, diamond 2.42. \
             At normal incidence it reflects {:.1} %. A map goes from 1 (black) to this value (white).",
            100.0 * ((p.ior - 1.0) / (p.ior + 1.0)).powi(2)
        ),
        _ => "How far the highlight is stretched: along the tangent (positive, to 1) or across it (negative, to -1). \
              A map goes from 0 (black) to this value (white)."
            .into(),
    }
}

/// Why a parameter has no effect, if it has none.
fn unread(material: &Material, label: &str) -> Option<&'static str> {
    let metal = material.parameters.metalness >= 1.0 && material.maps[MapKind::Metalness].is_none();
    let of_metal = (metal && ["IOR", "Specular"].contains(&label))
        .then_some("No effect now: a full metal's reflectance is its base color.");
    diffuse_only(material).or(of_metal)
}

fn diffuse_only(material: &Material) -> Option<&'static str> {
    (material.model == BrdfModel::Lambert).then_some("No effect now: Lambert reads the base color only.")
}
