//! What a bake will cost, from what the last one did.

use super::BakeContext;
use lapidary_core::{
    dataset::{BakeReport, BakeSettings, Dataset, IndirectSettings, MeshlessSettings},
    light_tree::TreeKind,
};
use lapidary_precompute::{BounceTrial, POINTS_PER_VERTEX, Phase, Trial, most_vertices};

/// (vertex, light) pairs per second and core of a bake that follows boundaries, where no bake has measured it, at the lights
/// that it holds for: 40 to 60 million in nine scenes.
const PAIRS_PER_SECOND_AND_CORE: (f64, usize) = (45e6, 32_768);
/// A vertex takes a time that grows by this power of the lights: probes are as many as the lights, boundaries as long as the
/// square root. A quarter of the lights take a third of the time.
const LIGHTS_POWER: f64 = 0.8;
/// How much longer it takes to trace every light.
const EXHAUSTIVE: f64 = 2.7;
/// Points of each pilot cluster that are traced as vertices are.
const PILOT_POINTS: f64 = 8.0;
/// Core seconds for each vertex of placing vertices where visibility varies, where no trial has measured it; and of all else
/// before the light tree.
const TESSELLATION: [f64; 2] = [2.5e-4, 5e-5];
/// Mean nodes of a cut at 32,768 lights and sigma 2 on the test scenes.
const MEAN_CUT: f64 = 170.0;
/// The lights and sigma that it holds for.
const MEAN_CUT_AT: (usize, f32) = (32_768, 2.0);
/// Bytes of a packed node.
const NODE_BYTES: f64 = 2.0;

/// Pairs of vertex and source that a core resolves per second along boundaries, where nothing has measured them, at the sources
/// that it holds for: 4.5 to 16.5 million in rooms.
const SOURCE_PAIRS_PER_SECOND_AND_CORE: (f64, usize) = (8e6, 32_768);
/// A vertex takes a time that grows by this power of the sources, beside what is near: in the color box and the interior eight
/// times as many take 1.55 times as long, and 32 times as many 2.6 and 3.0 times.
const SOURCES_POWER: f64 = 0.3;
/// Core seconds for each source of placing it and measuring its area, where no trial has measured them.
const PLACING: f64 = 7.5e-4;
/// How much longer it takes to trace every source: 1.2 times in a furnished room, twice in an empty one.
const EXHAUSTIVE_SOURCES: f64 = 1.5;
/// Mean nodes of a cut over surface samples: between the 500 of the color box and the 1,340 of the Cornell box.
const MEAN_SOURCE_CUT: f64 = 800.0;
/// The samples and sigma that it holds for.
const MEAN_SOURCE_CUT_AT: (usize, f32) = (32_768, 2.0);
/// How it changes with their number and with sigma, to whose inverse it is proportional. In the color box 330 nodes
/// for 8,192 samples at sigma 1, 100 at sigma 4; in the Cornell box 1,336 at sigma 2, 650 at sigma 4, 328 at sigma 8.
const SOURCE_CUT_POWER: f64 = 0.7;
/// Bytes of a source beside its cut: place, normal, area, triangle.
const SOURCE_BYTES: f64 = 40.0;
/// Core seconds, bytes and levels of the color box's meshless basis. Each level has about four times the functions of
/// the one above it; their number depends on the surface in units of the coarsest distance, not on the vertices.
const MESHLESS: (f64, f64, usize) = (110.0, 13e6, 6);
/// Functions that gather light, in terms of those of the first two levels: all of three and four levels do, and as many of each
/// further level as need detail.
const GATHERING: [f64; 3] = [3.75, 13.3, 16.3];
/// How much longer a ray of a whole basis takes than one of its first two levels, with what placing its points takes.
const OF_WHOLE_BASIS: f64 = 1.25;

/// Size of a scene before tessellation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneStats {
    /// Its vertices.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
}

/// What is known for estimates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    /// Vertices before tessellation.
    pub source_vertices: Option<usize>,
    /// (vertex, light) pairs a second along boundaries, and the lights that it came from.
    pub pairs_per_second: (f64, usize),
    /// A mean cut size, and the lights and sigma that it came from.
    pub mean_cut: (f64, usize, f32),
    /// (vertex, surface sample) pairs a second along boundaries, and the samples that it came from.
    pub source_pairs_per_second: (f64, usize),
    /// What a trial of the bounces found.
    pub bounces: Option<BounceTrial>,
    /// A mean cut over surface samples, and the samples and sigma that it came from.
    pub mean_source_cut: (f64, usize, f32),
    /// Core seconds for each vertex of placing vertices.
    pub core_secs_per_placed: f64,
    /// Cores that a bake may use.
    pub cores: usize,
}

/// What a bake will take, roughly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Vertices after tessellation, at most.
    pub vertices: usize,
    /// Seconds.
    pub secs: f64,
    /// Bytes of the cuts.
    pub bytes: u64,
}

impl Speed {
    /// From the last report, from a trial, or from averages.
    pub fn known(context: &BakeContext) -> Self {
        let report = context.dataset.map(|d| &d.report);
        let known = Self::from(report, context.trial, context.cores);
        let (bounces, cores) = (context.bounce_trial, known.cores as f64);
        let of_trial = |trial: BounceTrial| (cores * trial.sources as f64 / trial.core_secs_per_point, trial.sources);
        let cut_of_trial = |trial: BounceTrial| (trial.mean_cut.0, trial.sources, trial.mean_cut.1);
        let cut = context.dataset.and_then(mean_source_cut).or(bounces.map(cut_of_trial));
        let measured = report.and_then(source_pairs_per_second).or(bounces.map(of_trial));
        Self {
            source_vertices: context.source_vertices(),
            mean_source_cut: cut.unwrap_or(known.mean_source_cut),
            source_pairs_per_second: measured.unwrap_or(known.source_pairs_per_second),
            bounces,
            ..known
        }
    }

    fn from(report: Option<&BakeReport>, trial: Option<Trial>, cores: usize) -> Self {
        let along_boundaries = |r: &BakeReport| if r.lights_per_probe() == 1 { EXHAUSTIVE } else { 1.0 };
        let measured = report.and_then(|r| Some((r.run.as_ref()?.samples_per_second * along_boundaries(r), r.lights)));
        let per_core = trial.map(|trial| (trial.lights as f64 / trial.core_secs_per_point, trial.lights));
        let (rate, at) = per_core.unwrap_or(PAIRS_PER_SECOND_AND_CORE);
        let cut_of_trial = trial.map(|trial| (trial.mean_cut, trial.lights, trial.sigma));
        let cores = cores.max(1);
        let has_cuts = |r: &&BakeReport| r.mode.environment() && r.mean_cut > 0.0 && r.sigma > 0.0;
        let cut = report.filter(has_cuts).map(|r| (r.mean_cut, r.lights, r.sigma));
        Self {
            source_vertices: None,
            pairs_per_second: measured.filter(|m| m.0 > 0.0).unwrap_or((rate * cores as f64, at)),
            source_pairs_per_second: report
                .and_then(source_pairs_per_second)
                .unwrap_or((SOURCE_PAIRS_PER_SECOND_AND_CORE.0 * cores as f64, SOURCE_PAIRS_PER_SECOND_AND_CORE.1)),
            bounces: None,
            mean_source_cut: (MEAN_SOURCE_CUT, MEAN_SOURCE_CUT_AT.0, MEAN_SOURCE_CUT_AT.1),
            core_secs_per_placed: trial.map_or(TESSELLATION[0], |t| POINTS_PER_VERTEX as f64 * t.core_secs_per_split),
            cores,
            mean_cut: cut.or(cut_of_trial).unwrap_or((MEAN_CUT, MEAN_CUT_AT.0, MEAN_CUT_AT.1)),
        }
    }

    /// What a bake with `settings` will take; `None` if its number of vertices cannot be told.
    pub fn estimate(&self, settings: &BakeSettings) -> Option<Estimate> {
        self.source_vertices.max(settings.max_vertices)?;
        let vertices = most_vertices(self.source_vertices.unwrap_or(0), settings);
        let mode = settings.mode;
        let parts = [
            (mode.environment(), self.environment(settings, vertices as f64)),
            (mode.sources(), self.sources(settings, vertices as f64)),
            (mode.meshless(), self.meshless(&settings.meshless)),
        ];
        let wanted = || parts.iter().filter(|(wanted, _)| *wanted).map(|(_, cost)| cost);
        let bytes = wanted().map(|(_, bytes)| *bytes as u64).sum();
        let secs = self.tessellation(settings, vertices as f64) + wanted().map(|(secs, _)| secs).sum::<f64>();
        Some(Estimate { vertices, secs, bytes })
    }

    /// Seconds until vertices are where they sample.
    fn tessellation(&self, settings: &BakeSettings, vertices: f64) -> f64 {
        let splits = settings.max_vertices > self.source_vertices;
        let placed = if splits { self.core_secs_per_placed } else { 0.0 };
        vertices * (placed + TESSELLATION[1]) / self.cores as f64
    }

    /// Seconds of the environment's visibility from so many points.
    fn tracing(&self, settings: &BakeSettings, points: f64) -> f64 {
        let (rate, at) = self.pairs_per_second;
        let pairs = at as f64 * (settings.lights as f64 / at as f64).powf(LIGHTS_POWER);
        points * pairs / rate * if settings.exhaustive { EXHAUSTIVE } else { 1.0 }
    }

    /// Seconds and bytes of the environment's cuts.
    fn environment(&self, settings: &BakeSettings, vertices: f64) -> (f64, f64) {
        let bytes = vertices * self.cut_size(settings) * NODE_BYTES;
        let most = settings.max_bytes.map_or(f64::INFINITY, |bytes| bytes as f64);
        let pilot = (PILOT_POINTS * settings.pilot_clusters as f64).min(vertices);
        (self.tracing(settings, vertices + pilot), bytes.min(most))
    }

    /// Those of surface samples: the cuts of vertices over them, and their own over the environment if that is baked.
    fn sources(&self, settings: &BakeSettings, vertices: f64) -> (f64, f64) {
        let sources = settings.indirect.sources as f64;
        let (own_secs, own_nodes) = match settings.mode.environment() {
            true => (self.tracing(settings, sources), self.cut_size(settings)),
            false => (0.0, 1.0),
        };
        let longer = if settings.exhaustive { EXHAUSTIVE_SOURCES } else { 1.0 };
        let (rate, at) = self.source_pairs_per_second;
        let per_point = longer * at as f64 * (sources / at as f64).powf(SOURCES_POWER) / rate;
        // Their tree has a pilot of its own, unless it is by place alone.
        let has_pilot = settings.tree != TreeKind::Geometric;
        let pilot = if has_pilot { (PILOT_POINTS * settings.pilot_clusters as f64).min(vertices) } else { 0.0 };
        let placing = self.bounces.map_or(PLACING, |trial| trial.core_secs_per_source) / self.cores as f64;
        let secs = (vertices + pilot) * per_point + sources * placing + own_secs;
        let nodes = vertices * self.source_cut_size(&settings.indirect) + sources * own_nodes;
        (secs, nodes * NODE_BYTES + sources * SOURCE_BYTES)
    }

    /// Those of the meshless basis, which go with its levels.
    fn meshless(&self, settings: &MeshlessSettings) -> (f64, f64) {
        let (core_secs, bytes, measured_levels) = MESHLESS;
        let share = 4_f64.powf(settings.levels as f64 - measured_levels as f64);
        let core_secs = self.bounces.map_or(share * core_secs, |trial| {
            let receivers = trial.functions as f64 * gathering(settings.levels);
            OF_WHOLE_BASIS * receivers * settings.rays as f64 * trial.core_secs_per_gather_ray
        });
        (core_secs / self.cores as f64, share * bytes)
    }

    /// Mean cut for `settings`. A cut refines along the borders of visibility, lines on the sphere, down to clusters of
    /// some `4 sigma²` leaves (Eq. 5). So their number is proportional to the square root of the number of lights and
    /// to the inverse of sigma.
    fn cut_size(&self, settings: &BakeSettings) -> f64 {
        let (size, lights, sigma) = self.mean_cut;
        let finer = (settings.lights as f64 / lights as f64).sqrt();
        let coarser = f64::from(settings.criterion.sigma.max(0.1) / sigma);
        let most = f64::from(settings.criterion.max_nodes).min(settings.lights as f64);
        (size * finer / coarser).clamp(1.0, most.max(1.0))
    }

    /// Mean cut over surface samples.
    fn source_cut_size(&self, settings: &IndirectSettings) -> f64 {
        let (size, sources, sigma) = self.mean_source_cut;
        let finer = (settings.sources as f64 / sources as f64).powf(SOURCE_CUT_POWER);
        let coarser = f64::from(settings.criterion.sigma.max(0.1) / sigma.max(0.1));
        (size * finer / coarser).clamp(1.0, settings.sources as f64)
    }
}

/// Functions that gather light in a basis of so many levels, as a multiple of those of the first two.
fn gathering(levels: usize) -> f64 {
    match levels {
        0..=2 => 1.0,
        3 => GATHERING[0],
        _ => GATHERING[1] + (levels - 4) as f64 * GATHERING[2],
    }
}

/// What the last bake has measured along boundaries, if it had surface samples, and their number.
fn source_pairs_per_second(report: &BakeReport) -> Option<(f64, usize)> {
    let secs = report.seconds(Phase::SourceVisibility.name())?;
    let indirect = report.indirect.as_ref()?;
    let along_boundaries = if indirect.sources_per_probe() == 1 { EXHAUSTIVE_SOURCES } else { 1.0 };
    let pairs = report.bake_points as f64 * indirect.sources as f64;
    (pairs > 0.0 && secs > 0.0).then(|| (along_boundaries * pairs / secs, indirect.sources))
}

fn mean_source_cut(dataset: &Dataset) -> Option<(f64, usize, f32)> {
    let report = dataset.report.indirect.as_ref().filter(|report| report.mean_cut > 0.0 && report.sources > 0)?;
    Some((report.mean_cut, report.sources, report.criterion(dataset.settings.indirect.criterion).sigma))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::dataset::{BakeAudit, BakeParts, BakeRun, IndirectReport};
    use lapidary_precompute::Preset;

    fn speed(report: Option<&BakeReport>) -> Speed {
        Speed { source_vertices: Some(5000), ..Speed::from(report, None, 2) }
    }

    #[test]
    fn without_a_report_averages_are_scaled_by_cores() {
        let estimate = speed(None).estimate(&Preset::Normal.settings()).unwrap();
        assert_eq!(estimate.vertices, 100_000);
        // 100,000 vertices are placed, and they and 8 points of each pilot cluster traced.
        let expected = 1e5 * 3e-4 / 2.0 + (1e5 + 8192.0) * 32_768.0 / 90e6;
        assert!((estimate.secs - expected).abs() < 1e-6, "{} for {expected}", estimate.secs);
        assert_eq!(estimate.bytes, 34_000_000);
        let four_cores = Speed { source_vertices: Some(5000), ..Speed::from(None, None, 4) };
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
        let of = |report| Speed { source_vertices: Some(5000), ..Speed::from(report, Some(trial), 2) };
        let estimate = of(None).estimate(&settings).unwrap();
        // Cuts of four times the lights are twice as long.
        assert_eq!(estimate.bytes, 20_000_000);
        let traced = (1e5 + 8192.0) * 8192.0 * 4_f64.powf(0.8) / 40e6;
        assert!((estimate.secs - (1e5 * 4.5e-4 / 2.0 + traced)).abs() < 1e-6, "{}", estimate.secs);
        let run = Some(BakeRun { samples_per_second: 1e6, ..Default::default() });
        let report = BakeReport { run, mean_cut: 100.0, lights: 32_768, sigma: 2.0, ..Default::default() };
        let known = of(Some(&report));
        assert_eq!(
            (known.pairs_per_second, known.mean_cut),
            (speed(Some(&report)).pairs_per_second, (100.0, 32_768, 2.0))
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
        // The pilot traces all points, and all rays at the rate of an exhaustive bake, as it was.
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

    /// Of a bounce: what its segments take, and its size.
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
    fn a_trial_of_the_bounces_tells_what_they_take() {
        let trial = BounceTrial {
            sources: 1024,
            core_secs_per_source: 6e-4,
            core_secs_per_point: 3e-4,
            mean_cut: (85.0, 2.0),
            functions: 1276,
            core_secs_per_gather_ray: 2e-6,
        };
        let of = |mode, bounces| {
            let source_pairs_per_second = (2.0 * 1024.0 / 3e-4, 1024);
            let speed = Speed { bounces, source_pairs_per_second, ..speed(None) };
            let settings = BakeSettings { mode, max_vertices: None, ..Preset::Normal.settings() };
            speed.estimate(&settings).unwrap().secs - 5000.0 * 5e-5 / 2.0
        };
        let sources = 1e4 * 3e-4 * 32_f64.powf(0.3) / 2.0 + 32_768.0 * 6e-4 / 2.0;
        assert!((of(BakeParts::INDIRECT, Some(trial)) - sources).abs() < 1e-6);
        let gathered = 1276.0 * (13.3 + 2.0 * 16.3) * 512.0 * 2e-6 * 1.25 / 2.0;
        assert!((of(BakeParts::MESHLESS, Some(trial)) - gathered).abs() < 1e-6);
        assert!((of(BakeParts::MESHLESS, None) - 55.0).abs() < 1e-6, "the average without one");
    }

    #[test]
    fn cuts_over_sources_follow_their_number_and_sigma() {
        let nodes = |speed: &Speed, sources, sigma| {
            let own = sources as f64 * (SOURCE_BYTES + NODE_BYTES);
            (bounce(speed, sources, sigma).bytes as f64 - own) / (5000.0 * NODE_BYTES)
        };
        let (any, colour_box) = (speed(None), Speed { mean_source_cut: (500.0, 32_768, 2.0), ..speed(None) });
        assert!((nodes(&any, 32_768, 2.0) - 800.0).abs() < 1.0);
        for (sources, sigma, measured) in [(8192, 1.0, 330.0), (8192, 4.0, 100.0)] {
            let found = nodes(&colour_box, sources, sigma);
            assert!((found / measured).ln().abs() < 0.2, "{found} of {measured}");
        }
        assert!(nodes(&any, 64, 0.01) <= 64.5, "no more than there are");
        let mut dataset = crate::test_support::baked_triangle();
        assert_eq!(mean_source_cut(&dataset), None);
        dataset.report.indirect = Some(IndirectReport { mean_cut: 70.0, sources: 1024, ..Default::default() });
        dataset.settings.indirect.criterion.sigma = 3.0;
        assert_eq!(mean_source_cut(&dataset), Some((70.0, 1024, 3.0)));
    }

    #[test]
    fn a_level_more_of_the_basis_takes_four_times_as_long() {
        let settings = BakeSettings { mode: BakeParts::MESHLESS, max_vertices: None, ..Preset::Normal.settings() };
        let placed = 5000.0 * 5e-5 / 2.0;
        let finer = MeshlessSettings { levels: settings.meshless.levels + 1, ..settings.meshless };
        let secs = |s: &BakeSettings| speed(None).estimate(s).unwrap().secs - placed;
        assert!((secs(&settings) - 55.0).abs() < 1e-6, "on two cores");
        assert!((secs(&BakeSettings { meshless: finer, ..settings.clone() }) - 220.0).abs() < 1e-6);
    }

    #[test]
    fn limits_hold_and_an_unknown_scene_has_no_estimate() {
        let settings = BakeSettings { max_bytes: Some(4096), ..Preset::High.settings() };
        assert_eq!(speed(None).estimate(&settings).unwrap().bytes, 4096);
        let unlimited = BakeSettings { max_vertices: None, ..Preset::High.settings() };
        assert_eq!(Speed::from(None, None, 2).estimate(&unlimited), None);
    }

    #[test]
    fn finer_cuts_are_larger() {
        let normal = Preset::Normal.settings();
        let mut finer = normal.clone();
        finer.criterion.sigma = 1.0;
        let bytes = |s: &BakeSettings| speed(None).estimate(s).unwrap().bytes;
        assert_eq!(bytes(&finer), 2 * bytes(&normal));
    }

    #[test]
    fn both_cost_what_their_parts_cost() {
        let settings = Preset::Normal.settings();
        let cost = |mode| speed(None).estimate(&BakeSettings { mode, ..settings.clone() }).unwrap();
        let parts = [BakeParts::CUTS, BakeParts::MESHLESS].map(cost);
        let all = cost(BakeParts::ALL);
        // Vertices are placed once.
        let placed = 1e5 * 3e-4 / 2.0;
        assert!((all.secs + placed - parts.iter().map(|p| p.secs).sum::<f64>()).abs() < 1e-6);
        assert!(all.bytes.abs_diff(parts.iter().map(|p| p.bytes).sum()) < 4);
        assert!(parts.iter().all(|part| part.secs < all.secs && part.bytes < all.bytes && part.bytes > 0));
        let [environment, indirect] = [BakeParts::ENVIRONMENT, BakeParts::INDIRECT].map(cost);
        let on_sources = 32_768.0 * 32_768.0 / 90e6;
        assert!(
            (parts[0].secs + placed - environment.secs - indirect.secs - on_sources).abs() < 1e-6,
            "sources see the sky too"
        );
    }
}
