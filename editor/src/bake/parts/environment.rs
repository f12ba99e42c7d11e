//! Visibility of distant light. Other parts use its light tree and pilot as well.

use super::{Cost, PartOfPanel, Row, Step, bake_row, count, limit, missed, used};
use crate::{
    actions::Action,
    bake::panel::{NODE_BYTES, Speed, histogram::histogram},
    widgets::{
        Number,
        entries::{Decades, combo_row, count_row, limit_row},
        slider_row,
        units::bytes,
    },
};
use egui::{RichText, Ui};
use lapidary_core::{
    cut::CutCriterion,
    dataset::{BakeParts, BakeReport, BakeRun, BakeSettings, sigma_text},
    light_tree::{MAX_HEIGHT, TreeKind},
};
use lapidary_precompute::Phase;

/// Height of the smallest tree in the list: 256 lights. Fewer are for tests.
const LEAST_HEIGHT: u32 = 8;

/// (vertex, light) pairs per second and core of a bake that follows boundaries, and its number of lights, where no bake has
/// measured it: 40 to 60 million in nine scenes.
const PAIRS_PER_SECOND_AND_CORE: (f64, usize) = (45e6, 32_768);
/// Time per vertex grows with this power of the lights: the number of probes is proportional to the lights, the length of
/// boundaries to their square root. A quarter of the lights takes a third of the time.
const LIGHTS_POWER: f64 = 0.8;
/// Factor in time for tracing every light.
const EXHAUSTIVE: f64 = 2.7;
/// Points of each pilot cluster that are traced like vertices.
const PILOT_POINTS: f64 = 8.0;
/// Mean nodes of a cut at 32,768 lights and sigma 2 on the test scenes.
const MEAN_CUT: f64 = 170.0;
/// Lights and sigma of [`MEAN_CUT`].
const MEAN_CUT_AT: (usize, f32) = (32_768, 2.0);

/// The entry.
pub struct Environment;

impl PartOfPanel for Environment {
    fn controls(&self, ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
        tree(ui, bake, actions);
        let help = "Error bound of a cluster (Eq. 5). Smaller gives finer cuts, and takes more memory and time.";
        let sigma = Number::new("Sigma", help, 0.5..=8.0, 2.0).entry(0.0..=1e4);
        bake_row(actions, "Sigma", bake, |b| slider_row(ui, &sigma, &mut b.criterion.sigma));
        limits(ui, bake, actions);
    }

    fn described(&self, settings: &BakeSettings) -> Vec<Row> {
        let BakeSettings { lights, tree, beta, criterion, pilot_clusters, max_bytes, .. } = settings;
        let CutCriterion { sigma, max_nodes, total_error } = criterion;
        let max_nodes = (*max_nodes < u32::MAX).then_some(u64::from(*max_nodes));
        vec![
            ("Lights", count(*lights)),
            ("Light tree", tree_name(*tree).to_lowercase()),
            ("Beta", used(*tree == TreeKind::Mixed, beta.to_string())),
            ("Sigma", sigma.to_string()),
            ("Largest cut", limit(max_nodes)),
            ("Total error", total_error.map_or("no limit".into(), |e| e.to_string())),
            ("Pilot clusters", count(*pilot_clusters)),
            ("Bytes", limit(*max_bytes)),
        ]
    }

    fn steps(&self, _mode: BakeParts) -> Vec<Step> {
        let pilot = "Tracing a few vertices, to cluster directions by visibility.";
        let visibility = "Tracing the environment's visibility from every vertex.";
        vec![(Phase::Pilot, "Pilot visibility", pilot), (Phase::Visibility, "Environment visibility", visibility)]
    }

    fn cost(&self, speed: &Speed, settings: &BakeSettings, vertices: f64) -> Cost {
        let bytes = vertices * cut_size(speed, settings) * NODE_BYTES;
        let most = settings.max_bytes.map_or(f64::INFINITY, |bytes| bytes as f64);
        let points = vertices + pilot_points(settings, vertices);
        Cost { secs: tracing(speed, settings, points), bytes: bytes.min(most) }
    }

    fn rows(&self, report: &BakeReport, settings: &BakeSettings) -> Vec<Row> {
        if !report.mode.environment() {
            return Vec::new();
        }
        let mut rows = vec![
            ("Lights", count(report.lights)),
            ("Mean cut", format!("{:.1} nodes", report.mean_cut)),
            ("Largest cut", format!("{} nodes", count(report.max_cut))),
            ("Sigma", sigma_text(report.sigma, settings.criterion.sigma)),
            ("Visibility error", format!("{:.4} RMS", report.rms_visibility)),
            ("Cuts", bytes(report.bytes_cuts)),
        ];
        if let Some(audit) = &report.audit {
            rows.extend([
                ("Error, checked", format!("{:.4} RMS", audit.rms_error)),
                ("Lights missed", missed(audit, "lights")),
            ]);
        }
        let speed = |run: &BakeRun| ("Speed", format!("{:.1} M pairs/s", run.samples_per_second / 1e6));
        rows.extend(report.run.as_ref().map(speed));
        rows
    }

    fn diagram(&self, ui: &mut Ui, report: &BakeReport) {
        if report.mode.environment() && report.cut_size_histogram.iter().any(|count| *count > 0) {
            ui.add_space(4.0);
            ui.label(RichText::new("Nodes of the visibility cuts").weak());
            histogram(ui, &report.cut_size_histogram);
        }
    }
}

/// The light tree, which every bake has.
fn tree(ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
    let help = "Number of environment samples, a power of two.";
    bake_row(actions, "Lights", bake, |b| {
        count_row(ui, "Lights", help, (LEAST_HEIGHT..=MAX_HEIGHT).map(|h| 1 << h), &mut b.lights)
    });
    let kinds = [
        (TreeKind::Mixed, tree_name(TreeKind::Mixed), "By direction and visibility (Eq. 12)."),
        (TreeKind::Geometric, tree_name(TreeKind::Geometric), "By direction alone (Eq. 10)."),
        (TreeKind::DataDriven, tree_name(TreeKind::DataDriven), "By visibility alone (Eq. 11)."),
    ];
    bake_row(actions, "Light tree", bake, |b| {
        combo_row(ui, "Light tree", "Metric for clustering lights.", &mut b.tree, &kinds)
    });
    let unused = (bake.tree != TreeKind::Mixed).then_some("Only mixed trees use it.");
    let beta = Number::new("Beta", "Weight of direction against visibility in a mixed tree, 0 to 1.", 0.0..=1.0, 0.5);
    bake_row(actions, "Beta", bake, |b| slider_row(ui, &beta.disabled(unused), &mut b.beta));
}

fn limits(ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
    let help = "Size limit of the environment cuts in megabytes. All cuts are coarsened equally until they fit.";
    let size = Decades { unit: " MB", decimals: 1, ..Decades::count("Byte budget", help, 0.0..=1e7, 64.0) };
    bake_row(actions, "Byte budget", bake, |b| {
        let mut megabytes = b.max_bytes.map(|bytes| bytes as f64 / 1e6);
        let edited = limit_row(ui, &size, &mut megabytes);
        if edited.changed {
            b.max_bytes = megabytes.map(|m| (m * 1e6).round() as u64);
        }
        edited
    });
    let help = "A cut is refined until the root of its summed squared errors is below this, in lights.";
    let error = Decades { decimals: 1, ..Decades::count("Total error", help, 0.0..=1e4, 16.0) };
    bake_row(actions, "Total error", bake, |b| limit_row(ui, &error, &mut b.criterion.total_error));
}

/// Displayed name.
fn tree_name(tree: TreeKind) -> &'static str {
    match tree {
        TreeKind::Geometric => "Geometric",
        TreeKind::DataDriven => "Data-driven",
        TreeKind::Mixed => "Mixed",
    }
}

/// Points that a pilot traces like vertices.
pub fn pilot_points(settings: &BakeSettings, vertices: f64) -> f64 {
    (PILOT_POINTS * settings.pilot_clusters as f64).min(vertices)
}

/// Seconds of tracing the environment's visibility from `points` points.
pub fn tracing(speed: &Speed, settings: &BakeSettings, points: f64) -> f64 {
    let (rate, at) = pairs_per_second(speed);
    let pairs = at as f64 * (settings.lights as f64 / at as f64).powf(LIGHTS_POWER);
    points * pairs / rate * if settings.exhaustive { EXHAUSTIVE } else { 1.0 }
}

/// (vertex, light) pairs a second along boundaries, and the number of lights at which it was measured.
fn pairs_per_second(speed: &Speed) -> (f64, usize) {
    let along_boundaries = |r: &BakeReport| if r.lights_per_probe() == 1 { EXHAUSTIVE } else { 1.0 };
    let of_report = |r: &BakeReport| Some((r.run.as_ref()?.samples_per_second * along_boundaries(r), r.lights));
    let per_core = speed.trial.map(|trial| (trial.lights as f64 / trial.core_secs_per_point, trial.lights));
    let (rate, at) = per_core.unwrap_or(PAIRS_PER_SECOND_AND_CORE);
    let measured = speed.last.and_then(|(report, _)| of_report(report)).filter(|m| m.0 > 0.0);
    measured.unwrap_or((rate * speed.cores as f64, at))
}

/// Mean cut for `settings`. A cut refines along the borders of visibility, lines on the sphere, down to clusters of
/// some `4 sigma²` leaves (Eq. 5). So their number is proportional to the square root of the number of lights and
/// to the inverse of sigma.
pub fn cut_size(speed: &Speed, settings: &BakeSettings) -> f64 {
    let (size, lights, sigma) = mean_cut(speed);
    let finer = (settings.lights as f64 / lights as f64).sqrt();
    let coarser = f64::from(settings.criterion.sigma.max(0.1) / sigma);
    let most = f64::from(settings.criterion.max_nodes).min(settings.lights as f64);
    (size * finer / coarser).clamp(1.0, most.max(1.0))
}

/// A mean cut size, and the lights and sigma at which it was measured.
fn mean_cut(speed: &Speed) -> (f64, usize, f32) {
    let has_cuts = |r: &&BakeReport| r.mode.environment() && r.mean_cut > 0.0 && r.sigma > 0.0;
    let measured = speed.last.map(|(report, _)| report).filter(has_cuts).map(|r| (r.mean_cut, r.lights, r.sigma));
    let of_trial = speed.trial.map(|trial| (trial.mean_cut, trial.lights, trial.sigma));
    measured.or(of_trial).unwrap_or((MEAN_CUT, MEAN_CUT_AT.0, MEAN_CUT_AT.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::panel::test_speed as speed;
    use lapidary_core::dataset::BakeRun;
    use lapidary_precompute::{Preset, Trial};

    #[test]
    fn without_a_report_averages_are_scaled_by_cores() {
        let estimate = speed(None).estimate(&Preset::Normal.settings()).unwrap();
        assert_eq!(estimate.vertices, 100_000);
        // 100,000 vertices are placed, and they and 8 points of each pilot cluster traced.
        let expected = 1e5 * 1.9e-4 / 2.0 + (1e5 + 8192.0) * 32_768.0 / 90e6;
        assert!((estimate.secs - expected).abs() < 1e-6, "{} for {expected}", estimate.secs);
        assert_eq!(estimate.bytes, 34_000_000);
        let four_cores = Speed { cores: 4, ..speed(None) };
        assert!(four_cores.estimate(&Preset::Normal.settings()).unwrap().secs < 0.6 * estimate.secs);
    }

    #[test]
    fn a_trial_counts_more_than_averages_and_less_than_a_report() {
        let trial = Trial {
            lights: 8192,
            sigma: 2.0,
            core_secs_per_point: 8192.0 / 20e6,
            mean_cut: 50.0,
            core_secs_per_split: 1e-4,
        };
        let settings = Preset::Normal.settings();
        let of = |speed| Speed { trial: Some(trial), ..speed };
        let estimate = of(speed(None)).estimate(&settings).unwrap();
        // Cuts of four times the lights are twice as long.
        assert_eq!(estimate.bytes, 20_000_000);
        let traced = (1e5 + 8192.0) * 8192.0 * 4_f64.powf(0.8) / 40e6;
        assert!((estimate.secs - (1e5 * 2.5e-4 / 2.0 + traced)).abs() < 1e-6, "{}", estimate.secs);
        let run = Some(BakeRun { samples_per_second: 1e6, ..Default::default() });
        let report = BakeReport { run, mean_cut: 100.0, lights: 32_768, sigma: 2.0, ..Default::default() };
        let known = of(speed(Some(&report)));
        assert_eq!(
            (pairs_per_second(&known), mean_cut(&known)),
            (pairs_per_second(&speed(Some(&report))), (100.0, 32_768, 2.0))
        );
    }

    #[test]
    fn a_quarter_of_the_lights_takes_a_third_of_the_time() {
        let secs = |lights| {
            let settings = BakeSettings { lights, max_vertices: None, ..Preset::Normal.settings() };
            speed(None).estimate(&settings).unwrap().secs - 5000.0 * 5e-5 / 2.0
        };
        assert!((secs(32_768) / secs(8192) - 3.03).abs() < 0.01);
    }

    #[test]
    fn a_report_overrides_the_averages() {
        let run = Some(BakeRun { samples_per_second: 1e6, ..Default::default() });
        let report = BakeReport { run, mean_cut: 100.0, lights: 32_768, sigma: 2.0, ..Default::default() };
        let settings = BakeSettings { max_vertices: None, ..Preset::Normal.settings() };
        let estimate = speed(Some(&report)).estimate(&settings).unwrap();
        assert_eq!((estimate.vertices, estimate.bytes), (5000, 1_000_000));
        // The pilot traces all points, and all rays at the rate of an exhaustive bake.
        let expected = 5000.0 * 5e-5 / 2.0 + 2.0 * 5000.0 * 0.032768 / 2.7;
        assert!((estimate.secs - expected).abs() < 1e-6);
        let exhaustive = BakeSettings { exhaustive: true, ..settings.clone() };
        let longer = speed(Some(&report)).estimate(&exhaustive).unwrap();
        assert!((longer.secs - 0.125 - 2.0 * 5000.0 * 0.032768).abs() < 1e-6);
        assert_eq!(speed(None).estimate(&settings).unwrap().bytes, 1_700_000, "without a report");
        let dark = BakeReport { mode: BakeParts::INDIRECT, mean_cut: 1.0, ..report };
        let estimate = speed(Some(&dark)).estimate(&settings).unwrap();
        assert_eq!(estimate.bytes, speed(None).estimate(&settings).unwrap().bytes, "its cuts are of nothing");
    }

    #[test]
    fn finer_cuts_are_larger() {
        let normal = Preset::Normal.settings();
        let mut finer = normal.clone();
        finer.criterion.sigma = 1.0;
        let bytes = |s: &BakeSettings| speed(None).estimate(s).unwrap().bytes;
        assert_eq!(bytes(&finer), 2 * bytes(&normal));
    }
}
