//! The audit: how few lights need a probe, so that cuts are as good as those of an exhaustive bake.
//!
//! It comes before the visibility of all points, whose results do not depend on each other: what it finds of some of them is
//! what the bake will make of them. So no work is done in vain, and the parts of a bake that is shared among machines agree.

use super::geometry::Geometry;
use crate::{
    bake::settings::ResolvedBake,
    errors::{BakeError, cancelled},
    observer::Observer,
    vertices::{
        points::BakePoint,
        visibility::{EXHAUSTIVE, FINEST, USUAL, VisibilitySampler},
    },
};
use lapidary_core::{
    cut::{CutSelector, squared_error},
    dataset::BakeAudit,
    light_tree::LightTree,
    ray::BoundaryTracer,
};
use rayon::prelude::*;

/// One bake point of so many is audited.
const ONE_OF: usize = 100;
/// Least number of points that are audited, if there are as many.
const LEAST: usize = 64;
/// Largest root mean square of stored minus traced visibility, as a multiple of that of an exhaustive bake.
const MOST_ERROR: f64 = 1.01;

/// The audit that decides how the environment is traced; `None` if every light is to be traced anyway.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn audit_environment(
    geometry: &Geometry,
    tree: &LightTree,
    settings: &ResolvedBake,
    observer: &dyn Observer,
) -> Result<Option<BakeAudit>, BakeError> {
    if settings.exhaustive {
        return Ok(None);
    }
    let points = audited(&geometry.points.points);
    let auditor = Auditor { geometry, tree, settings, points: &points, observer };
    for lights_per_probe in [USUAL, FINEST] {
        let audit = auditor.audit(lights_per_probe)?;
        if audit.rms_error <= MOST_ERROR * audit.rms_exhaustive {
            return Ok(Some(audit));
        }
    }
    Ok(Some(auditor.audit(EXHAUSTIVE)?))
}

/// Points spread evenly over all.
fn audited(points: &[BakePoint]) -> Vec<&BakePoint> {
    let count = (points.len() / ONE_OF).max(LEAST).min(points.len());
    (0..count).map(|i| &points[(2 * i + 1) * points.len() / (2 * count)]).collect()
}

struct Auditor<'a> {
    geometry: &'a Geometry,
    tree: &'a LightTree,
    settings: &'a ResolvedBake,
    points: &'a [&'a BakePoint],
    observer: &'a dyn Observer,
}

/// Sums over the lights of a point.
#[derive(Clone, Copy, Default)]
struct Sums {
    wrong: u64,
    squared_error: f64,
    squared_error_exhaustive: f64,
}

impl Auditor<'_> {
    fn audit(&self, lights_per_probe: usize) -> Result<BakeAudit, BakeError> {
        let Self { geometry, tree, settings, points, observer } = self;
        let sampler = |lights_per_probe| VisibilitySampler::new(&geometry.intersector, tree, lights_per_probe);
        let (all, probed) = (sampler(EXHAUSTIVE), sampler(lights_per_probe));
        let scratch = || {
            let selector = CutSelector::new(tree.height(), settings.criterion);
            (selector, BoundaryTracer::default(), [vec![0; tree.len()], vec![0; tree.len()]])
        };
        let sums = points.par_iter().map_init(scratch, |(selector, tracer, [traced, seen]), point| {
            cancelled(*observer)?;
            all.sample(point, tracer, traced);
            probed.sample(point, tracer, seen);
            let (mut cut, mut exhaustive) = (Vec::new(), Vec::new());
            selector.select(seen, &mut cut);
            let squared_error_exhaustive = selector.select(traced, &mut exhaustive);
            Ok(Sums {
                wrong: traced.iter().zip(seen).filter(|(a, b)| a != b).count() as u64,
                squared_error: squared_error(tree.height(), &cut, traced),
                squared_error_exhaustive,
            })
        });
        // Collected in order: sums do not depend on which thread was first.
        let sums = sums.collect::<Result<Vec<Sums>, BakeError>>()?;
        let pairs = (points.len() * tree.len()).max(1) as f64;
        let rms = |of: fn(&Sums) -> f64| (sums.iter().map(of).sum::<f64>() / pairs).sqrt();
        Ok(BakeAudit {
            vertices: points.len(),
            leaves_wrong: sums.iter().map(|s| s.wrong).sum::<u64>() as f64 / pairs,
            rms_error: rms(|s| s.squared_error),
            rms_exhaustive: rms(|s| s.squared_error_exhaustive),
            lights_per_probe,
        })
    }
}
