//! A trial of the surface sources.

use super::{Tried, some_points};
use crate::{
    bake::settings::Preset,
    errors::BakeError,
    observer::Silent,
    sources::{
        order::order_sources,
        placement::place_sources,
        sampler::{SourceSampler, SourceScratch},
    },
    vertices::{
        points::{BakePoint, BakePoints},
        visibility::USUAL,
    },
};
use lapidary_core::{
    cut::{SourceCriterion, SourceCutSelector},
    dataset::BakeSettings,
    light_tree::TreeKind,
    ray::Intersector,
    sources::Source,
    surfel::Surface,
    threads::CoreClock,
};

/// Sources of the trial.
const SOURCES: usize = 1024;

/// Result of a trial of the surface sources.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourcesTrial {
    /// Number of sources of the trial.
    pub sources: usize,
    /// Core seconds for placing one source.
    pub core_secs_per_source: f64,
    /// Core seconds per point for following segments to the sources and selecting the cut.
    pub core_secs_per_point: f64,
    /// Mean nodes of a cut, with the error bound.
    pub mean_cut: (f64, f32),
}

impl SourcesTrial {
    pub(super) fn of(tried: &Tried) -> Result<Self, BakeError> {
        let &Tried { scene, sides, intersector, surface, viewpoint } = tried;
        let start = CoreClock::begin();
        let sources = place_sources(surface, viewpoint, SOURCES, &[], &Silent)?;
        let placing = start.secs();
        let settings = BakeSettings { tree: TreeKind::Geometric, ..Preset::Draft.settings() };
        let points = BakePoints::new(&scene.mesh, sides);
        let sources = order_sources(sources, &points, intersector, surface, &settings, &Silent)?;
        let [_, points] = some_points(&scene.mesh, sides, intersector);
        let criterion = settings.indirect.criterion;
        let (secs, nodes) = traced(&points, intersector, &sources, surface.offset(), criterion);
        let count = points.len().max(1) as f64;
        Ok(Self {
            sources: SOURCES,
            core_secs_per_source: placing / SOURCES as f64,
            core_secs_per_point: secs / count,
            mean_cut: (nodes as f64 / count, criterion.sigma),
        })
    }
}

/// Seconds for computing the cuts of points over sources, and their number of nodes.
fn traced(
    points: &[BakePoint],
    intersector: &Intersector,
    sources: &[Source],
    offset: f32,
    criterion: SourceCriterion,
) -> (f64, usize) {
    let sampler = SourceSampler::new(intersector, sources, offset, USUAL);
    let (mut scratch, mut seen) = (SourceScratch::default(), vec![0.0; sources.len()]);
    let mut selector = SourceCutSelector::new(sources.len().ilog2(), criterion);
    let length = |point: &BakePoint| {
        let mut cut = Vec::new();
        sampler.sample(point, &mut scratch, &mut seen);
        selector.select(&seen, &mut cut);
        cut.len()
    };
    let start = CoreClock::begin();
    let nodes = points.iter().map(length).sum();
    (start.secs(), nodes)
}
