//! The bases of objects.

use super::{Cost, PartOfPanel, Row, Step, bake_row, count, used};
use crate::{
    actions::Action,
    bake::panel::Speed,
    widgets::{
        entries::count_row,
        units::{bytes, grouped},
    },
};
use egui::Ui;
use lapidary_core::{
    dataset::{BakeParts, BakeReport, BakeSettings, ObjectBasesSettings},
    meshless::RadiositySettings,
};
use lapidary_precompute::Phase;

/// Core seconds and bytes of a function.
const OF_A_FUNCTION: (f64, f64) = (5e-5, 36.0);

/// The entry.
pub struct ObjectBases;

impl PartOfPanel for ObjectBases {
    fn controls(&self, ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
        let help = "Functions of all objects, which carry the light that is solved anew after a move. More are finer and take longer to solve.";
        bake_row(actions, "Functions", bake, |b| {
            let mut functions = b.object_bases.functions as usize;
            let choices = [10_000, 30_000, 75_000, 150_000, 300_000, 600_000];
            let edited = count_row(ui, "Functions", help, choices.into_iter(), &mut functions);
            b.object_bases.functions = functions as u32;
            edited
        });
    }

    fn described(&self, settings: &BakeSettings) -> Vec<Row> {
        let ObjectBasesSettings { functions, levels, sender_level } = settings.object_bases;
        let rays = RadiositySettings::DEFAULT.bytes_of_rays(u64::from(functions));
        let rows = [
            ("Functions", grouped(u64::from(functions))),
            ("Rays kept while solving", format!("up to {}", bytes(rays))),
            ("Levels of functions", levels.to_string()),
            ("Sending level", (sender_level + 1).to_string()),
        ];
        rows.map(|(name, value)| (name, used(settings.mode.object_bases(), value))).into()
    }

    fn steps(&self, _mode: BakeParts) -> Vec<Step> {
        vec![(Phase::ObjectBases, "Functions of objects", "Placing functions on each object.")]
    }

    fn cost(&self, speed: &Speed, settings: &BakeSettings, _vertices: f64) -> Cost {
        let functions = f64::from(settings.object_bases.functions);
        let (core_secs, bytes) = OF_A_FUNCTION;
        Cost { secs: core_secs * functions / speed.cores as f64, bytes: bytes * functions }
    }

    fn rows(&self, report: &BakeReport, _settings: &BakeSettings) -> Vec<Row> {
        let Some(report) = &report.object_bases else { return Vec::new() };
        let functions = count(report.functions.iter().sum());
        vec![("Functions", format!("{functions} ({})", bytes(report.bytes_points)))]
    }
}
