//! The audit: how many lights, or sources, one probe may stand for without making cuts worse than an exhaustive bake's.
//!
//! It precedes the visibility of all points. Points are independent, so the bake will reproduce the audit's results for them. No
//! work is wasted, and shards on several machines agree.

use crate::{
    bake::settings::ResolvedBake,
    errors::{BakeError, cancelled},
    observer::Observer,
    sources::{
        error::{relative_rms, squared_norm},
        sampler::{SourceSampler, SourceScratch},
    },
    vertices::{
        points::BakePoint,
        tracing::{ManySampler, POINTS_AT_A_TIME, Tracing},
        visibility::{EXHAUSTIVE, FINEST, USUAL},
    },
};
use lapidary_core::{
    cut::{CutSelector, SourceCutSelector, solid_angle_error, squared_error},
    dataset::BakeAudit,
    light_tree::LightTree,
    ray::{Intersector, RayDevices},
    sources::Source,
};
use rayon::prelude::*;
use std::cell::LazyCell;

/// One in this many bake points is audited.
const ONE_OF: usize = 100;
/// Least number of audited points, if there are as many.
const LEAST: usize = 64;
/// Largest root mean square of stored minus traced values, relative to an exhaustive bake's.
const MOST_ERROR: f64 = 1.01;

/// The audit that decides how the environment is traced; `None` if every light is traced anyway.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn audit_environment(
    points: &[BakePoint],
    scene: &Intersector,
    tree: &LightTree,
    settings: &ResolvedBake,
    (devices, observer): (Option<&dyn RayDevices>, &dyn Observer),
) -> Result<Option<BakeAudit>, BakeError> {
    let sampler = |lights_per_probe| {
        ManySampler::new(scene, tree.leaf_directions(), Tracing { lights_per_probe, devices, observer })
    };
    let all = LazyCell::new(|| sampler(EXHAUSTIVE));
    let selector = || CutSelector::new(tree.height(), settings.criterion);
    coarsest_good(settings, |lights_per_probe| {
        let probed = sampler(lights_per_probe);
        let mut sums = Vec::new();
        let points = audited(points);
        for some in points.chunks(POINTS_AT_A_TIME) {
            cancelled(observer)?;
            let visible = |sampler: &ManySampler| sampler.each(some, || (), |(), visible, _| visible.to_vec());
            let (traced, seen) = (visible(&all), visible(&probed));
            let compare = |selector: &mut CutSelector, (traced, seen): (&Vec<u8>, &Vec<u8>)| {
                sums_of_lights(selector, tree.height(), traced, seen)
            };
            sums.par_extend(traced.par_iter().zip(&seen).map_init(selector, compare));
        }
        Ok(audit_of(&sums, lights_per_probe))
    })
}

/// Sums over the lights that a point sees: all are traced, or some are seen along boundaries.
fn sums_of_lights(selector: &mut CutSelector, height: u32, traced: &[u8], seen: &[u8]) -> Sums {
    let (mut cut, mut exhaustive) = (Vec::new(), Vec::new());
    selector.select(seen, &mut cut);
    let squared_error_exhaustive = selector.select(traced, &mut exhaustive);
    Sums {
        leaves: traced.len(),
        wrong: traced.iter().zip(seen).filter(|(a, b)| a != b).count(),
        norm: traced.len() as f64,
        squared_error: squared_error(height, &cut, traced),
        squared_error_exhaustive,
    }
}

/// The audit for the surface sources, in tree order; segments to them end `offset` meters off their surface.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn audit_sources(
    points: &[BakePoint],
    scene: &Intersector,
    (sources, offset): (&[Source], f32),
    settings: &ResolvedBake,
    observer: &dyn Observer,
) -> Result<Option<BakeAudit>, BakeError> {
    let height = sources.len().ilog2();
    let all = SourceSampler::new(scene, sources, offset, EXHAUSTIVE);
    let scratch = || {
        let selector = SourceCutSelector::new(height, settings.indirect.criterion);
        (selector, SourceScratch::default(), [vec![0.0; sources.len()], vec![0.0; sources.len()]])
    };
    coarsest_good(settings, |sources_per_probe| {
        let probed = SourceSampler::new(scene, sources, offset, sources_per_probe);
        audit(points, sources_per_probe, observer, scratch, |(selector, scratch, [traced, seen]), point| {
            all.sample(point, scratch, traced);
            probed.sample(point, scratch, seen);
            let (mut cut, mut exhaustive) = (Vec::new(), Vec::new());
            selector.select(seen, &mut cut);
            selector.select(traced, &mut exhaustive);
            Sums {
                leaves: traced.len(),
                wrong: traced.iter().zip(seen).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).count(),
                norm: squared_norm(traced),
                squared_error: solid_angle_error(height, &cut, traced),
                squared_error_exhaustive: solid_angle_error(height, &exhaustive, traced),
            }
        })
    })
}

/// The audit of the fewest probes that suffice, or of exhaustive tracing; `None` if the bake is exhaustive anyway.
fn coarsest_good(
    settings: &ResolvedBake,
    audit: impl Fn(usize) -> Result<BakeAudit, BakeError>,
) -> Result<Option<BakeAudit>, BakeError> {
    if settings.exhaustive {
        return Ok(None);
    }
    let mut found = audit(USUAL)?;
    if !is_good(&found) {
        found = audit(FINEST)?;
    }
    if !is_good(&found) {
        let rms_error = found.rms_exhaustive;
        found = BakeAudit { leaves_wrong: 0.0, rms_error, leaves_per_probe: EXHAUSTIVE, ..found };
    }
    Ok(Some(found))
}

/// Whether cuts are hardly worse than an exhaustive bake's.
fn is_good(audit: &BakeAudit) -> bool {
    audit.rms_error <= MOST_ERROR * audit.rms_exhaustive
}

/// Sums over the leaves at a point.
#[derive(Clone, Copy)]
struct Sums {
    leaves: usize,
    wrong: usize,
    /// Reference for relative squared errors.
    norm: f64,
    squared_error: f64,
    squared_error_exhaustive: f64,
}

/// The audit by `compare` at some of the points. `scratch` creates buffers that are reused.
fn audit<S>(
    points: &[BakePoint],
    leaves_per_probe: usize,
    observer: &dyn Observer,
    scratch: impl Fn() -> S + Sync + Send,
    compare: impl Fn(&mut S, &BakePoint) -> Sums + Sync + Send,
) -> Result<BakeAudit, BakeError> {
    let points = audited(points);
    let one = |scratch: &mut S, point: &&BakePoint| {
        cancelled(observer)?;
        Ok(compare(scratch, point))
    };
    // Collected in order: sums must not depend on thread timing.
    let sums = points.par_iter().map_init(scratch, one).collect::<Result<Vec<Sums>, BakeError>>()?;
    Ok(audit_of(&sums, leaves_per_probe))
}

/// The audit by sums at points.
fn audit_of(sums: &[Sums], leaves_per_probe: usize) -> BakeAudit {
    let sum = |of: fn(&Sums) -> usize| sums.iter().map(of).sum::<usize>() as f64;
    let rms = |of: fn(&Sums) -> f64| relative_rms(&sums.iter().map(|s| (of(s), s.norm)).collect::<Vec<_>>());
    BakeAudit {
        vertices: sums.len(),
        leaves_wrong: sum(|s| s.wrong) / sum(|s| s.leaves).max(1.0),
        rms_error: rms(|s| s.squared_error),
        rms_exhaustive: rms(|s| s.squared_error_exhaustive),
        leaves_per_probe,
    }
}

/// Points spread evenly over all points.
fn audited(points: &[BakePoint]) -> Vec<&BakePoint> {
    let count = (points.len() / ONE_OF).max(LEAST).min(points.len());
    (0..count).map(|i| &points[(2 * i + 1) * points.len() / (2 * count)]).collect()
}
