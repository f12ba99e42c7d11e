//! Which leaves an edit reaches from a point: those whose rays meet a box of what changed. Leaves are told by granules, the nodes of
//! one depth of their tree.

use super::change::Change;
use crate::vertices::{points::BakePoint, side::Side};
use glam::Vec3;
use lapidary_core::{bounds::Bounds, sources::Source};

/// Depth of the granules, less in a small tree.
const DEPTH: u32 = 9;

/// Leaves in a granule of a tree of `leaves`.
fn leaves_of_granule(leaves: usize) -> usize {
    leaves >> DEPTH.min(leaves.ilog2())
}

/// Directions of lights by granule.
pub struct LightReach<'a> {
    change: &'a Change,
    directions: &'a [Vec3],
    cones: Vec<Cone>,
}

/// A cone around the directions of a granule.
struct Cone {
    axis: Vec3,
    /// Half-angle in radians.
    angle: f32,
}

impl Cone {
    fn around(directions: &[Vec3]) -> Self {
        let axis = directions.iter().sum::<Vec3>().normalize_or(Vec3::Y);
        let angle = directions.iter().map(|d| axis.angle_between(*d)).fold(0.0, f32::max);
        Self { axis, angle }
    }

    /// Whether it may meet a box from its apex.
    fn may_meet(&self, apex: Vec3, bounds: &Bounds) -> bool {
        let (toward, radius) = (bounds.center() - apex, 0.5 * bounds.diagonal());
        let distance = toward.length();
        distance <= radius || self.axis.angle_between(toward) <= 1.001 * self.angle + (radius / distance).asin() + 1e-3
    }
}

impl<'a> LightReach<'a> {
    /// For the leaf directions of a light tree.
    pub fn new(directions: &'a [Vec3], change: &'a Change) -> Self {
        let cones = directions.chunks(leaves_of_granule(directions.len())).map(Cone::around).collect();
        Self { change, directions, cones }
    }

    /// Sets whether the edit reaches each granule from a point.
    pub fn stale(&self, point: &BakePoint, stale: &mut Vec<bool>) {
        stale.clear();
        stale.resize(self.cones.len(), false);
        let granules = || self.cones.iter().zip(self.directions.chunks(leaves_of_granule(self.directions.len())));
        for &side in point.sides() {
            let origin = point.origin(side);
            for bounds in self.change.boxes() {
                let meets = |(cone, directions): (&Cone, &[Vec3])| {
                    cone.may_meet(origin, bounds)
                        && directions.iter().any(|&d| bounds.meets_ray(origin, d, f32::INFINITY))
                };
                stale.iter_mut().zip(granules()).for_each(|(stale, granule)| *stale |= meets(granule));
            }
        }
    }
}

/// Sources by granule.
pub struct SourceReach<'a> {
    change: &'a Change,
    sources: &'a [Source],
    /// Whether each source moved.
    has_moved: Vec<bool>,
    /// Boxes around the discs of each granule.
    boxes: Vec<Bounds>,
}

/// Radius of a source's disc in meters.
fn radius(source: &Source) -> f32 {
    (source.area * std::f32::consts::FRAC_1_PI).sqrt().max(source.spacing)
}

impl<'a> SourceReach<'a> {
    /// For sources in the order of their tree, now and before.
    pub fn new(sources: &'a [Source], before: &[Source], change: &'a Change) -> Self {
        let around = |granule: &[Source]| {
            Bounds::around(granule.iter().flat_map(|source| {
                let (at, reach) = (source.surfel.position, Vec3::splat(radius(source)));
                [at - reach, at + reach]
            }))
        };
        let has_moved = sources.iter().zip(before).map(|(now, before)| now.surfel != before.surfel).collect();
        let boxes = sources.chunks(leaves_of_granule(sources.len())).map(around).collect();
        Self { change, sources, has_moved, boxes }
    }

    /// Sets whether the edit reaches each granule from a point.
    pub fn stale(&self, point: &BakePoint, stale: &mut Vec<bool>) {
        stale.clear();
        let size = leaves_of_granule(self.sources.len());
        let sides: &[Side] = point.sides();
        let meets = |source: &Source, origin: Vec3| {
            let toward = source.surfel.position - origin;
            self.change.boxes().iter().any(|b| b.grown(radius(source)).meets_ray(origin, toward, 1.0))
        };
        let granules = self.sources.chunks(size).zip(self.has_moved.chunks(size)).zip(&self.boxes);
        stale.extend(granules.map(|((sources, has_moved), around)| {
            let may_meet = |origin: Vec3| {
                let hull = Bounds::around([around.min, around.max, origin]);
                self.change.boxes().iter().any(|b| overlap(&hull, b))
            };
            has_moved.contains(&true)
                || sides
                    .iter()
                    .map(|&side| point.origin(side))
                    .any(|origin| may_meet(origin) && sources.iter().any(|source| meets(source, origin)))
        }));
    }
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}
