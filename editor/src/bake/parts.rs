//! The parts of a bake as one table of panel entries. A new part needs a file here and a line in [`of`].

mod environment;
mod meshless;
mod object_bases;
mod sources;
mod wavelet;

use super::panel::{Speed, mode::name as mode_name};
use crate::{
    actions::Action,
    document::Edit,
    widgets::{Edited, edit_row, units::grouped},
};
use egui::Ui;
use glam::Vec3;
use lapidary_core::{
    dataset::{BakeAudit, BakePart, BakeParts, BakeReport, BakeSettings},
    ground::Ground,
    shot::Shot,
};
use lapidary_precompute::Phase;

/// A name and a value with its unit.
pub type Row = (&'static str, String);

/// A phase of a bake, its displayed name, and its description.
pub type Step = (Phase, &'static str, &'static str);

/// Cost of a part.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// Seconds.
    pub secs: f64,
    /// Bytes of the dataset.
    pub bytes: f64,
}

/// Panel entry of one part.
pub trait PartOfPanel: Sync {
    /// Its controls under *Advanced*.
    fn controls(&self, ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>);

    /// Its settings in words, for comparing bakes.
    fn described(&self, settings: &BakeSettings) -> Vec<Row>;

    /// Phases that only it needs, in a bake of `mode`.
    fn steps(&self, mode: BakeParts) -> Vec<Step>;

    /// Its cost in a bake of `vertices` vertices.
    fn cost(&self, speed: &Speed, settings: &BakeSettings, vertices: f64) -> Cost;

    /// Its rows of the report; none if it was not baked.
    fn rows(&self, report: &BakeReport, settings: &BakeSettings) -> Vec<Row>;

    /// Its diagram under the report, if it has one.
    fn diagram(&self, _ui: &mut Ui, _report: &BakeReport) {}
}

/// The entry of a part.
pub fn of(part: BakePart) -> &'static dyn PartOfPanel {
    match part {
        BakePart::Environment => &environment::Environment,
        BakePart::Sources => &sources::Sources,
        BakePart::Meshless => &meshless::Meshless,
        BakePart::ObjectBases => &object_bases::ObjectBases,
        BakePart::Wavelet => &wavelet::Wavelet,
    }
}

/// All entries, in the order in which they are baked.
pub fn all() -> impl Iterator<Item = &'static dyn PartOfPanel> {
    BakePart::ALL.iter().map(|part| of(*part))
}

/// The entries of parts that bounce light.
fn bouncing() -> impl Iterator<Item = &'static dyn PartOfPanel> {
    BakePart::ALL.iter().filter(|part| part.bounces()).map(|part| of(*part))
}

/// All settings in words: the environment's, those of no part, then the other parts'.
pub fn described(settings: &BakeSettings) -> Vec<Row> {
    // Destructured, so that a new setting cannot be forgotten; parts describe the settings without a name here.
    let BakeSettings {
        lights: _,
        tree: _,
        beta: _,
        criterion: _,
        pilot_clusters: _,
        max_bytes: _,
        ground,
        max_vertices,
        even_vertices,
        shots,
        exhaustive,
        mode,
        indirect: _,
        meshless: _,
        object_bases: _,
        wavelet: _,
    } = settings;
    let mut rows = of(BakePart::Environment).described(settings);
    rows.extend([
        ("Vertices", limit(max_vertices.map(|v| v as u64))),
        // A bake is the same for a surface and a shadow catcher.
        ("Ground", if *ground == Ground::Off { "none" } else { "under the scene" }.into()),
        ("Placing", if *even_vertices { "evenly" } else { "where visibility varies" }.into()),
        ("Views", described_shots(shots)),
        ("Tracing", if *exhaustive { "every light and source" } else { "boundaries" }.into()),
        ("Bake type", mode_name(*mode).to_lowercase()),
    ]);
    rows.extend(bouncing().flat_map(|part| part.described(settings)));
    rows
}

/// The views of a bake, with everything that distinguishes them.
fn described_shots(shots: &[Shot]) -> String {
    let place = |Vec3 { x, y, z }: Vec3| format!("({x}, {y}, {z})");
    let described = |Shot { camera, aspect }: &Shot| {
        let (eye, target, degrees) = (place(camera.eye), place(camera.target), camera.fov_y.to_degrees());
        let roll = if camera.up == Vec3::Y { String::new() } else { format!(", {} upward", place(camera.up)) };
        format!("from {eye} to {target}{roll} at {degrees}°, {aspect} to 1")
    };
    if shots.is_empty() { "all alike".into() } else { shots.iter().map(described).collect::<Vec<_>>().join("; ") }
}

fn limit(limit: Option<u64>) -> String {
    limit.map_or("no limit".into(), grouped)
}

/// A setting in words, where a bake uses it.
fn used(is_used: bool, text: String) -> String {
    if is_used { text } else { "unused".into() }
}

/// A row that edits a setting of the bake.
pub fn bake_row(
    actions: &mut Vec<Action>,
    label: &'static str,
    bake: &BakeSettings,
    row: impl FnOnce(&mut BakeSettings) -> Edited,
) {
    edit_row(actions, label, bake, |bake| Edit::Bake(Box::new(bake)), row);
}

/// A number of a report.
pub fn count(n: usize) -> String {
    grouped(n as u64)
}

/// Share of the lights or sources that following boundaries has missed.
fn missed(audit: &BakeAudit, leaves: &str) -> String {
    match audit.leaves_per_probe {
        1 => format!("none: all {leaves} were traced"),
        _ => format!("{:.3} % of {leaves}", 100.0 * audit.leaves_wrong),
    }
}
