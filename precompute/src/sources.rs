//! Surface sources: their places, their tree, and what a bake point sees of them (paper, 4.1, with the points of the
//! meshless basis paper in place of a repulsion of random ones).

use crate::{
    BakeError, MeshSurface, Observer, PointsError,
    bake_points::{BakePoint, BakePoints},
    pilot::pilot_of,
    surface_points::{poisson_count, sample_areas},
};
use glam::Vec3;
use lapidary_core::{
    dataset::BakeSettings,
    indirect::{Receiver, Source},
    light_tree::{Features, PilotVisibility, TreeKind, cluster_order},
    ray::{Intersector, SegmentBatch},
    surfel::{Surface, Surfel},
};

/// Seed of the particles, so that the same scene gets the same sources.
const POINTS_SEED: u64 = 0x736f_7572_6365_7301;
/// Seed of the points that areas are estimated by.
const AREAS_SEED: u64 = 0x736f_7572_6365_7302;

/// `count` sources on the surfaces that light reaches from the viewpoint, and their least distance in metres.
///
/// # Errors
/// See [`poisson_count`].
pub fn place_sources(
    surface: &MeshSurface,
    viewpoint: Vec3,
    count: usize,
    observer: &dyn Observer,
) -> Result<(Vec<Source>, f32), PointsError> {
    let (surfels, radius) = poisson_count(surface, viewpoint, count, POINTS_SEED, observer)?;
    let areas = sample_areas(surface, &surfels, radius, AREAS_SEED, observer)?;
    let sources = surfels.into_iter().zip(areas).map(|(surfel, area)| Source { surfel, area }).collect();
    Ok((sources, radius))
}

/// Arranges sources as the leaves of their complete binary tree, by position and normal, by pilot visibility, or by both.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn order_sources(
    sources: Vec<Source>,
    points: &BakePoints,
    scene: &Intersector,
    surface: &dyn Surface,
    settings: &BakeSettings,
    observer: &dyn Observer,
) -> Result<Vec<Source>, BakeError> {
    let diagonal = surface.bounds().diagonal();
    let none = PilotVisibility { lights: sources.len(), fractions: Vec::new() };
    // By place first: the pilot's batches need neighbours in order to be neighbours in space.
    let sources = clustered(&sources, TreeKind::Geometric, 1.0, diagonal, &none);
    if settings.tree == TreeKind::Geometric {
        return Ok(sources);
    }
    let sampler = SourceSampler::new(scene, &sources, surface.offset());
    let sample = |point: &BakePoint, seen: &mut [u8]| {
        let mut solid_angles = vec![0.0; sources.len()];
        sampler.sample(point, &mut SourceScratch::default(), &mut solid_angles);
        seen.iter_mut().zip(solid_angles).for_each(|(s, angle)| *s = u8::from(angle > 0.0));
    };
    let pilot = pilot_of(points, diagonal, sources.len(), settings.pilot_clusters, observer, sample)?;
    Ok(clustered(&sources, settings.tree, settings.beta, diagonal, &pilot))
}

fn clustered(sources: &[Source], kind: TreeKind, beta: f32, diagonal: f32, pilot: &PilotVisibility) -> Vec<Source> {
    let surfels: Vec<Surfel> = sources.iter().map(|s| s.surfel).collect();
    let order = cluster_order(&Features::of_surfels(kind, beta, &surfels, diagonal, pilot));
    order.into_iter().map(|i| sources[i as usize]).collect()
}

/// Solid angles of all sources from one bake point after another.
pub struct SourceSampler<'a> {
    scene: &'a Intersector,
    sources: &'a [Source],
    /// Where segments to each source end, off its surface.
    ends: Vec<Vec3>,
}

/// Buffers of [`SourceSampler::sample`].
#[derive(Default)]
pub struct SourceScratch {
    batch: SegmentBatch,
    /// Sources to trace from the upper and from the lower side.
    wanted: [Vec<u32>; 2],
}

impl<'a> SourceSampler<'a> {
    /// For sources in tree order; segments end `offset` metres off their surface.
    pub fn new(scene: &'a Intersector, sources: &'a [Source], offset: f32) -> Self {
        let ends = sources.iter().map(|s| s.surfel.position + s.surfel.normal * offset).collect();
        Self { scene, sources, ends }
    }

    /// Number of sources.
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// Sets `seen[leaf]` to the solid angle in steradians of every source: zero if it faces away, lies below the point's
    /// horizon, or is hidden. Returns the rays traced.
    pub fn sample(&self, point: &BakePoint, scratch: &mut SourceScratch, seen: &mut [f32]) -> u64 {
        let SourceScratch { batch, wanted } = scratch;
        wanted.iter_mut().for_each(Vec::clear);
        for (i, (source, seen)) in self.sources.iter().zip(seen.iter_mut()).enumerate() {
            let side = facing_side(point, source);
            *seen = if side.is_some() { 1.0 } else { 0.0 };
            side.iter().for_each(|&upper| wanted[usize::from(!upper)].push(i as u32));
        }
        for (wanted, upper) in wanted.iter().zip([true, false]) {
            batch.trace(self.scene, point.origin(upper), &self.ends, wanted, |i| seen[i as usize] = 0.0);
            for i in wanted.iter().map(|&i| i as usize) {
                if seen[i] > 0.0 {
                    seen[i] = open_solid_angle(point, upper, &self.sources[i]);
                }
            }
        }
        wanted.iter().map(|w| w.len() as u64).sum()
    }

    /// [`Self::sample`] segment by segment and without packets, for verification.
    pub fn sample_singly(&self, point: &BakePoint, seen: &mut [f32]) {
        for ((source, &end), seen) in self.sources.iter().zip(&self.ends).zip(seen) {
            let open = facing_side(point, source).filter(|&u| !self.scene.occluded_between(point.origin(u), end));
            *seen = open.map_or(0.0, |upper| open_solid_angle(point, upper, source));
        }
    }
}

/// Whether a source lies on the upper side of a point (or on the lower), if both face each other.
#[inline]
fn facing_side(point: &BakePoint, source: &Source) -> Option<bool> {
    if source.solid_angle_from(point.position) == 0.0 {
        return None;
    }
    let upper = point.is_upper((source.surfel.position - point.position).normalize_or_zero());
    (upper || point.two_sided).then_some(upper)
}

/// A point stands for no more surface than so many radii of the source: where edges are long, light varies along them.
const LARGEST_RECEIVER: f32 = 3.0;

/// Solid angle of a source with nothing between.
fn open_solid_angle(point: &BakePoint, upper: bool, source: &Source) -> f32 {
    let normal = if upper { point.normal } else { -point.normal };
    let radius = point.radius.min(LARGEST_RECEIVER * source.radius());
    source.mean_solid_angle(&Receiver { position: point.position, normal, radius })
}

#[cfg(test)]
mod tests;
