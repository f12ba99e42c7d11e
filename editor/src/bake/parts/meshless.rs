//! The meshless basis and its transport operator.

use super::{Cost, PartOfPanel, Row, Step, bake_row, count, used};
use crate::{
    actions::Action,
    bake::panel::Speed,
    widgets::{
        entries::{Decades, count_row, decades_row},
        units::bytes,
    },
};
use egui::Ui;
use lapidary_core::dataset::{BakeParts, BakeReport, BakeSettings, MeshlessSettings};
use lapidary_precompute::{BounceTrial, Phase};

/// Levels of the basis at most.
const MOST_LEVELS: usize = 8;
/// Core seconds, bytes and levels of the color box's meshless basis. Each level has about four times the functions of
/// the one above it; their number depends on the surface in units of the coarsest distance, not on the vertices.
const MESHLESS: (f64, f64, usize) = (110.0, 13e6, 6);
/// Functions that gather light, relative to those of the first two levels: all functions of three and four levels, and of each
/// further level those that need detail.
const GATHERING: [f64; 3] = [3.75, 13.3, 16.3];
/// Time of a ray of a whole basis relative to one of its first two levels, including the placing of points.
const OF_WHOLE_BASIS: f64 = 1.25;

/// The entry.
pub struct Meshless;

impl PartOfPanel for Meshless {
    fn controls(&self, ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
        let help = "Levels of the meshless basis, each four times as fine as the one before.";
        bake_row(actions, "Basis levels", bake, |b| {
            let edited = count_row(ui, "Basis levels", help, 1..=MOST_LEVELS, &mut b.meshless.levels);
            b.meshless.sender_levels = b.meshless.sender_levels.min(b.meshless.levels);
            edited
        });
        let help =
            "Levels that send light, from the coarsest. One more is slightly more accurate and doubles the time.";
        bake_row(actions, "Sender levels", bake, |b| {
            let levels = 1..=b.meshless.levels;
            count_row(ui, "Sender levels", help, levels, &mut b.meshless.sender_levels)
        });
        let help = "Rays per basis function. Fewer are faster and noisier.";
        bake_row(actions, "Gather rays", bake, |b| {
            count_row(ui, "Gather rays", help, (6..=12).map(|power| 1 << power), &mut b.meshless.rays)
        });
        let help = "Drops links that carry less than this share of the light. Smaller is more accurate, takes more memory, and slows moving lights.";
        let default = f64::from(MeshlessSettings::default().epsilon);
        let epsilon = Decades { decimals: 5, ..Decades::count("Epsilon", help, 0.0..=1.0, default) };
        bake_row(actions, "Epsilon", bake, |b| decades_row(ui, &epsilon, &mut b.meshless.epsilon));
    }

    fn described(&self, settings: &BakeSettings) -> Vec<Row> {
        let MeshlessSettings { levels, sender_levels, coarse_radius, rays, epsilon } = settings.meshless;
        let rows = [
            ("Levels", levels.to_string()),
            ("Sender levels", sender_levels.to_string()),
            ("Coarse radius", coarse_radius.map_or("automatic".into(), |r| r.to_string())),
            ("Gather rays", rays.to_string()),
            ("Epsilon", epsilon.to_string()),
        ];
        rows.map(|(name, value)| (name, used(settings.mode.meshless(), value))).into()
    }

    fn steps(&self, _mode: BakeParts) -> Vec<Step> {
        vec![
            (Phase::Basis, "Meshless basis", "Placing the basis functions of the soft bounces."),
            (Phase::Transport, "Meshless transport", "Tracing light between the basis functions."),
        ]
    }

    /// The cost depends on the levels.
    fn cost(&self, speed: &Speed, settings: &BakeSettings, _vertices: f64) -> Cost {
        let settings = &settings.meshless;
        let (core_secs, bytes, measured_levels) = MESHLESS;
        let share = 4_f64.powf(settings.levels as f64 - measured_levels as f64);
        let core_secs = speed.bounces.map_or(share * core_secs, |BounceTrial { basis: trial, .. }| {
            let receivers = trial.functions as f64 * gathering(settings.levels);
            OF_WHOLE_BASIS * receivers * settings.rays as f64 * trial.core_secs_per_gather_ray
        });
        Cost { secs: core_secs / speed.cores as f64, bytes: share * bytes }
    }

    fn rows(&self, report: &BakeReport, _settings: &BakeSettings) -> Vec<Row> {
        let Some(report) = &report.meshless else { return Vec::new() };
        vec![
            ("Basis", format!("{} functions", count(report.functions.iter().sum()))),
            ("Basis links", format!("{} ({})", count(report.links), bytes(report.bytes_links))),
        ]
    }
}

/// Functions that gather light in a basis of `levels` levels, as a multiple of those of the first two.
fn gathering(levels: usize) -> f64 {
    match levels {
        0..=2 => 1.0,
        3 => GATHERING[0],
        _ => GATHERING[1] + (levels - 4) as f64 * GATHERING[2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::panel::test_speed as speed;
    use lapidary_precompute::Preset;

    #[test]
    fn a_level_more_of_the_basis_takes_four_times_as_long() {
        let settings = BakeSettings { mode: BakeParts::MESHLESS, max_vertices: None, ..Preset::Normal.settings() };
        let placed = 5000.0 * 5e-5 / 2.0;
        let finer = MeshlessSettings { levels: settings.meshless.levels + 1, ..settings.meshless };
        let secs = |s: &BakeSettings| speed(None).estimate(s).unwrap().secs - placed;
        assert!((secs(&settings) - 55.0).abs() < 1e-6, "on two cores");
        assert!((secs(&BakeSettings { meshless: finer, ..settings.clone() }) - 220.0).abs() < 1e-6);
    }
}
