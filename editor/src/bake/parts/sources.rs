//! Surface sources, for one bounce.

use super::{Cost, PartOfPanel, Row, Step, bake_row, count, environment, missed, used};
use crate::{
    actions::Action,
    bake::panel::{NODE_BYTES, Speed},
    widgets::{Number, entries::count_row, slider_row, units::bytes},
};
use egui::Ui;
use lapidary_core::{
    cut::SourceCriterion,
    dataset::{BakeParts, BakeReport, BakeSettings, IndirectSettings, sigma_text},
    light_tree::{MAX_HEIGHT, TreeKind},
};
use lapidary_precompute::{BounceTrial, Phase};

/// Height of the smallest tree of sources in the list: 1,024 sources.
const LEAST_HEIGHT: u32 = 10;

/// (vertex, source) pairs per second and core along boundaries, and its number of sources, where nothing has measured it: 4.5 to
/// 16.5 million in rooms.
const SOURCE_PAIRS_PER_SECOND_AND_CORE: (f64, usize) = (8e6, 32_768);
/// Time per vertex grows with this power of the sources, besides the near field: in the color box and the interior, eight times as
/// many sources take 1.55 times as long, 32 times as many 2.6 and 3.0 times.
const SOURCES_POWER: f64 = 0.3;
/// Core seconds per source for placing it and measuring its area, where no trial has measured them.
const PLACING: f64 = 7.5e-4;
/// Factor in time for tracing every source: 1.2 times in a furnished room, twice in an empty one.
const EXHAUSTIVE_SOURCES: f64 = 1.5;
/// Mean nodes of a cut over surface samples: between the 500 of the color box and the 1,340 of the Cornell box.
const MEAN_SOURCE_CUT: f64 = 800.0;
/// Samples and sigma of [`MEAN_SOURCE_CUT`].
const MEAN_SOURCE_CUT_AT: (usize, f32) = (32_768, 2.0);
/// Power of the number of samples with which the mean cut grows; it is inversely proportional to sigma. In the color box 330 nodes
/// for 8,192 samples at sigma 1, 100 at sigma 4; in the Cornell box 1,336 at sigma 2, 650 at sigma 4, 328 at sigma 8.
const SOURCE_CUT_POWER: f64 = 0.7;
/// Bytes of a source beside its cut: place, normal, area, triangle.
const SOURCE_BYTES: f64 = 40.0;

/// The entry.
pub struct Sources;

impl PartOfPanel for Sources {
    fn controls(&self, ui: &mut Ui, bake: &BakeSettings, actions: &mut Vec<Action>) {
        let help = "Number of surface sources, a power of two. More give sharper bounces near surfaces.";
        bake_row(actions, "Sources", bake, |b| {
            count_row(ui, "Sources", help, (LEAST_HEIGHT..=MAX_HEIGHT).map(|h| 1 << h), &mut b.indirect.sources)
        });
        let help = "Error bound of a cluster of sources. Smaller gives finer cuts, and takes more memory and time.";
        let default = IndirectSettings::default().criterion.sigma;
        let sigma = Number::new("Source sigma", help, 0.5..=8.0, default).entry(0.0..=1e3);
        bake_row(actions, "Source sigma", bake, |b| slider_row(ui, &sigma, &mut b.indirect.criterion.sigma));
    }

    /// All parts that bounce light cover the space around the viewpoint.
    fn described(&self, settings: &BakeSettings) -> Vec<Row> {
        let IndirectSettings { sources, criterion, viewpoint } = settings.indirect;
        let SourceCriterion { sigma, max_solid_angle, contrast } = criterion;
        let of_sources = |text: String| used(settings.mode.sources(), text);
        let viewpoint = viewpoint.map_or("automatic".into(), |v| v.to_string());
        vec![
            ("Sources", of_sources(count(sources))),
            ("Source sigma", of_sources(sigma.to_string())),
            ("Largest solid angle", of_sources(max_solid_angle.to_string())),
            ("Source contrast", of_sources(contrast.to_string())),
            ("Viewpoint", used(settings.mode.bounces(), viewpoint)),
        ]
    }

    fn steps(&self, mode: BakeParts) -> Vec<Step> {
        let environment = "Tracing every surface source against the environment.";
        let environment = (Phase::SourceEnvironment, "Environment on sources", environment);
        let placing = "Placing points that send bounced light.";
        let clustering = "Clustering surface sources that send similar light.";
        let tracing = "Tracing every vertex against the surface sources.";
        let mut steps = vec![
            (Phase::Points, "Placing surface sources", placing),
            (Phase::SourceTree, "Building the source tree", clustering),
            (Phase::SourceVisibility, "Source visibility", tracing),
        ];
        steps.extend(mode.environment().then_some(environment));
        steps
    }

    /// The cuts of vertices over the sources, and the sources' own over the environment if that is baked.
    fn cost(&self, speed: &Speed, settings: &BakeSettings, vertices: f64) -> Cost {
        let sources = settings.indirect.sources as f64;
        let (own_secs, own_nodes) = match settings.mode.environment() {
            true => (environment::tracing(speed, settings, sources), environment::cut_size(speed, settings)),
            false => (0.0, 1.0),
        };
        let longer = if settings.exhaustive { EXHAUSTIVE_SOURCES } else { 1.0 };
        let (rate, at) = pairs_per_second(speed);
        let per_point = longer * at as f64 * (sources / at as f64).powf(SOURCES_POWER) / rate;
        // Their tree has a pilot of its own, unless it clusters by place alone.
        let has_pilot = settings.tree != TreeKind::Geometric;
        let pilot = if has_pilot { environment::pilot_points(settings, vertices) } else { 0.0 };
        let placing = speed.bounces.map_or(PLACING, |trial| trial.sources.core_secs_per_source) / speed.cores as f64;
        let secs = (vertices + pilot) * per_point + sources * placing + own_secs;
        let nodes = vertices * cut_size(speed, &settings.indirect) + sources * own_nodes;
        Cost { secs, bytes: nodes * NODE_BYTES + sources * SOURCE_BYTES }
    }

    fn rows(&self, report: &BakeReport, settings: &BakeSettings) -> Vec<Row> {
        let Some(report) = &report.indirect else { return Vec::new() };
        let asked = settings.indirect.criterion;
        let mut rows = vec![
            ("Sources", count(report.sources)),
            ("Mean source cut", format!("{:.1} nodes", report.mean_cut)),
            ("Source sigma", sigma_text(report.criterion(asked).sigma, asked.sigma)),
            ("Bounce error", format!("{:.1} %", 100.0 * report.relative_error)),
            ("Source cuts", bytes(report.bytes_cuts)),
        ];
        rows.extend(report.audit.iter().map(|audit| ("Sources missed", missed(audit, "sources"))));
        rows
    }
}

/// (vertex, source) pairs a second along boundaries, and the number of sources at which it was measured.
fn pairs_per_second(speed: &Speed) -> (f64, usize) {
    let cores = speed.cores as f64;
    let of_trial = |BounceTrial { sources: trial, .. }: BounceTrial| {
        (cores * trial.sources as f64 / trial.core_secs_per_point, trial.sources)
    };
    let measured = speed.last.and_then(|(report, _)| measured_pairs_per_second(report));
    let (rate, at) = SOURCE_PAIRS_PER_SECOND_AND_CORE;
    measured.or(speed.bounces.map(of_trial)).unwrap_or((rate * cores, at))
}

/// The same from the last bake, if it had sources.
fn measured_pairs_per_second(report: &BakeReport) -> Option<(f64, usize)> {
    let secs = report.seconds(Phase::SourceVisibility.name())?;
    let indirect = report.indirect.as_ref()?;
    let along_boundaries = if indirect.sources_per_probe() == 1 { EXHAUSTIVE_SOURCES } else { 1.0 };
    let pairs = report.bake_points as f64 * indirect.sources as f64;
    (pairs > 0.0 && secs > 0.0).then(|| (along_boundaries * pairs / secs, indirect.sources))
}

/// Mean cut over sources for `settings`.
fn cut_size(speed: &Speed, settings: &IndirectSettings) -> f64 {
    let (size, sources, sigma) = mean_cut(speed);
    let finer = (settings.sources as f64 / sources as f64).powf(SOURCE_CUT_POWER);
    let coarser = f64::from(settings.criterion.sigma.max(0.1) / sigma.max(0.1));
    (size * finer / coarser).clamp(1.0, settings.sources as f64)
}

/// A mean cut over sources, and the sources and sigma at which it was measured.
fn mean_cut(speed: &Speed) -> (f64, usize, f32) {
    let measured = speed.last.and_then(|(report, settings)| measured_cut(report, settings));
    let of_trial =
        speed.bounces.map(|BounceTrial { sources: trial, .. }| (trial.mean_cut.0, trial.sources, trial.mean_cut.1));
    measured.or(of_trial).unwrap_or((MEAN_SOURCE_CUT, MEAN_SOURCE_CUT_AT.0, MEAN_SOURCE_CUT_AT.1))
}

fn measured_cut(report: &BakeReport, settings: &BakeSettings) -> Option<(f64, usize, f32)> {
    let report = report.indirect.as_ref().filter(|report| report.mean_cut > 0.0 && report.sources > 0)?;
    Some((report.mean_cut, report.sources, report.criterion(settings.indirect.criterion).sigma))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::panel::{Estimate, test_speed as speed};
    use lapidary_core::dataset::{BakeAudit, BakeRun, IndirectReport};
    use lapidary_precompute::Preset;

    /// Estimated time and size of a bounce.
    fn bounce(speed: &Speed, sources: usize, sigma: f32) -> Estimate {
        let mut settings = BakeSettings { mode: BakeParts::INDIRECT, max_vertices: None, ..Preset::Normal.settings() };
        (settings.indirect.sources, settings.indirect.criterion.sigma) = (sources, sigma);
        speed.estimate(&settings).unwrap()
    }

    #[test]
    fn sources_have_a_rate_of_their_own() {
        // The pilot of their tree traces all points as well.
        let pairs = 2.0 * 5000.0 * 32_768.0;
        let secs = |report: Option<&BakeReport>| bounce(&speed(report), 32_768, 2.0).secs;
        let placed = 5000.0 * 5e-5 / 2.0 + 32_768.0 * PLACING / 2.0;
        assert!((secs(None) - placed - pairs / 16e6).abs() < 1e-6);
        let run = BakeRun { samples_per_second: 90e6, ..Default::default() };
        let environment = BakeReport { run: Some(run.clone()), ..Default::default() };
        assert_eq!(secs(Some(&environment)), secs(None), "those of an environment are other rays");
        let seconds = [(Phase::SourceVisibility.name().to_owned(), 4.0)].into();
        let audit = Some(BakeAudit { leaves_per_probe: 16, ..Default::default() });
        let indirect = Some(IndirectReport { sources: 32_768, audit, ..Default::default() });
        let run = Some(BakeRun { seconds, ..run });
        let mut measured = BakeReport { run, indirect, bake_points: 1000, ..environment };
        // 1,000 points of 32,768 sources in 4 seconds.
        assert!((secs(Some(&measured)) - placed - pairs / 8.192e6).abs() < 1e-6);
        measured.indirect.as_mut().unwrap().audit = None;
        let exhaustive = secs(Some(&measured));
        assert!((exhaustive - placed - pairs / 12.288e6).abs() < 1e-6, "boundaries will be faster: {exhaustive}");
    }

    #[test]
    fn cuts_over_sources_follow_their_number_and_sigma() {
        let nodes = |speed: &Speed, sources, sigma| {
            let own = sources as f64 * (SOURCE_BYTES + NODE_BYTES);
            (bounce(speed, sources, sigma).bytes as f64 - own) / (5000.0 * NODE_BYTES)
        };
        let measured = Some(IndirectReport { mean_cut: 500.0, sources: 32_768, ..Default::default() });
        let report = BakeReport { indirect: measured, ..Default::default() };
        let (any, colour_box) = (speed(None), speed(Some(&report)));
        assert!((nodes(&any, 32_768, 2.0) - 800.0).abs() < 1.0);
        for (sources, sigma, measured) in [(8192, 1.0, 330.0), (8192, 4.0, 100.0)] {
            let found = nodes(&colour_box, sources, sigma);
            assert!((found / measured).ln().abs() < 0.2, "{found} of {measured}");
        }
        assert!(nodes(&any, 64, 0.01) <= 64.5, "no more than there are");
        let mut dataset = crate::test_support::baked_triangle();
        assert_eq!(measured_cut(&dataset.report, &dataset.settings), None);
        dataset.report.indirect = Some(IndirectReport { mean_cut: 70.0, sources: 1024, ..Default::default() });
        dataset.settings.indirect.criterion.sigma = 3.0;
        assert_eq!(measured_cut(&dataset.report, &dataset.settings), Some((70.0, 1024, 3.0)));
    }
}
