//! The phases of the surface sources: points, their tree, the bake points' cuts over them, and their cuts over the
//! environment.
//!
//! A resumed bake recomputes sources and tree. Chunks for other sources are not used.

use super::{
    audit::audit_sources,
    bounces::Bouncing,
    chunks::{EnvironmentCuts, SourceCuts, bake_chunks},
    fit::{TEXTURE_BYTES, fit_sources},
    geometry::Geometry,
    pack::{Packed, pack},
    point_cuts::PointCuts,
};
use crate::{
    bake::{
        checkpoint::{Places, Series},
        clock::Clock,
    },
    errors::{BakeError, CutsOf},
    observer::{Event, Phase},
    sources::{
        order::order_sources,
        placement::{place_sources, placement_units},
        sampler::SourceSampler,
    },
    vertices::{
        points::{BakePoint, BakePoints},
        tracing::ManySampler,
        visibility::EXHAUSTIVE,
    },
    warning::{SourcesWarning, Warning},
};
use lapidary_core::{
    cut::prune_sources,
    dataset::{BakeAudit, IndirectReport},
    sources::{IndirectBake, Source},
    surfel::{Surface, Surfel},
};

impl Bouncing<'_> {
    /// All phases of the sources.
    pub fn bake_indirect(&self, clock: &mut Clock) -> Result<(IndirectBake, IndirectReport), BakeError> {
        let sources = self.sources(clock)?;
        let places = places_of(&sources, &self.geometry.points);
        let SeenSources { packed: seen, coarsened, audit } = self.source_cuts(&sources, places, clock)?;
        let environment = self.environment_cuts(&sources, places, clock)?;
        let spacings = || sources.iter().map(|source| source.spacing);
        let report = IndirectReport {
            viewpoint: self.viewpoint.into(),
            sources: sources.len(),
            radius: spacings().fold(f32::INFINITY, f32::min),
            widest_spacing: spacings().fold(0.0, f32::max),
            area: sources.iter().map(|s| f64::from(s.area)).sum(),
            without_area: sources.iter().filter(|s| s.area == 0.0).count(),
            mean_cut: seen.mean_cut(),
            max_cut: seen.max_cut,
            coarsened,
            relative_error: (seen.squared_error / seen.points.max(1) as f64).sqrt(),
            mean_environment_cut: environment.mean_cut(),
            bytes_cuts: seen.bytes() + environment.bytes(),
            rays_traced: seen.rays,
            audit,
        };
        Ok((IndirectBake { sources, cuts: seen.cuts, environment_cuts: environment.cuts }, report))
    }

    /// Sources in the order of their tree.
    fn sources(&self, clock: &mut Clock) -> Result<Vec<Source>, BakeError> {
        let count = self.settings.indirect.sources;
        let observer = clock.observer;
        let sources = clock.time(Phase::Points, placement_units(count), "points", || {
            place_sources(self.surface, self.viewpoint, count, &self.settings.shots, observer)
        })?;
        let clusters = self.settings.pilot_clusters as u64;
        clock.time(Phase::SourceTree, clusters, "clusters", || {
            order_sources(
                sources,
                &self.geometry.points,
                &self.geometry.intersector,
                self.surface,
                self.settings,
                observer,
            )
        })
    }

    /// The bake points' cuts over the sources.
    fn source_cuts(&self, sources: &[Source], places: Places, clock: &mut Clock) -> Result<SeenSources, BakeError> {
        let Geometry { points, scene, intersector, .. } = self.geometry;
        let receivers = points.for_sources(&scene.mesh, intersector, &self.settings.shots);
        let (criterion, offset) = (self.settings.indirect.criterion, self.surface.offset());
        let kept = self.checkpoint.series(Series::Sources, places);
        let observer = clock.observer;
        let (cuts, audit) = clock.time(Phase::SourceVisibility, points.points.len() as u64, "points", || {
            let audit = audit_sources(&receivers, intersector, (sources, offset), self.settings, observer)?;
            let sources_per_probe = audit.map_or(EXHAUSTIVE, |audit| audit.leaves_per_probe);
            let sampler = SourceSampler::new(intersector, sources, offset, sources_per_probe);
            let maker = SourceCuts { points: &receivers, sampler, criterion };
            Ok::<_, BakeError>((bake_chunks(&maker, &kept, observer)?, audit))
        })?;
        if kept.has_met_others() {
            observer.event(Event::Warning { message: Warning::Sources(SourcesWarning::Other) });
        }
        let height = cuts.height();
        let coarsened = fit_sources(&cuts, criterion, TEXTURE_BYTES, observer)?;
        let coarser = |cut: &[u16]| prune_sources(height, criterion.coarser(coarsened.unwrap_or(1.0)), cut);
        let coarser = coarsened.is_some().then_some(&coarser as _);
        let packed = pack(&cuts, coarser, points.of_vertex.iter().copied(), CutsOf::Sources)?;
        Ok(SeenSources { packed, coarsened, audit })
    }

    fn environment_cuts(&self, sources: &[Source], places: Places, clock: &mut Clock) -> Result<Packed, BakeError> {
        let kept = self.checkpoint.series(Series::SourceEnvironment, places);
        let cuts = if self.settings.mode.environment() {
            let points: Vec<BakePoint> =
                sources.iter().map(|s| BakePoint::of_surfel(s.surfel, self.surface.offset())).collect();
            let maker = EnvironmentCuts {
                points: &points,
                sampler: ManySampler::new(&self.geometry.intersector, self.tree.leaf_directions(), self.tracing),
                height: self.tree.height(),
                criterion: self.settings.criterion,
            };
            let observer = clock.observer;
            clock.time(Phase::SourceEnvironment, sources.len() as u64, "sources", || {
                bake_chunks(&maker, &kept, observer)
            })?
        } else {
            PointCuts::unbaked(sources.len())
        };
        pack(&cuts, None, 0..sources.len() as u32, CutsOf::SourceEnvironment)
    }
}

/// The bake points' cuts over the sources.
struct SeenSources {
    packed: Packed,
    /// See [`IndirectReport::coarsened`].
    coarsened: Option<f32>,
    audit: Option<BakeAudit>,
}

/// Hash for the chunks of these sources and bake points.
fn places_of(sources: &[Source], points: &BakePoints) -> Places {
    let surfels: Vec<Surfel> = sources.iter().map(|s| s.surfel).collect();
    let mut numbers: Vec<f32> = sources.iter().flat_map(|s| [s.area, s.spacing]).collect();
    numbers.extend(points.coordinates());
    Places::of(&surfels, &numbers)
}
