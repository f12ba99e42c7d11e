//! Solid angles of the sources around a point, by rays.
//!
//! Far sources are discs, each hidden or not. Near by the shape of what surrounds the point counts: in the folds of a sofa
//! discs overlap, and reach into other surfaces; at the foot of a wall the floor's are seen edge on. So rays from the point go
//! out in all directions, and each gives its part of the sphere to the source that stands for the place it meets. A receiver
//! takes light of a source to come from its centre, so a ray counts by its own cosine over that of the centre: irradiance is
//! nearly right even where rays meet the foot of a wall and the centre is far up.

use super::Source;
use crate::{
    ray::Intersector,
    sphere::fibonacci_directions,
    surfel::{Surfel, SurfelGrid},
};
use glam::Vec3;
use std::f32::consts::TAU;

/// Sources within so many radii of their Poisson-disk set are near.
const REACH: f32 = 8.0;
/// A place that is further than so many radii from all sources belongs to none: light does not reach it.
pub const OWNED_WITHIN: f32 = 2.0;
/// Rays over the sphere. In the living room of the measurements four times as many are no better.
const RAYS: usize = 1024;
/// A point no higher than so many radii over a source's plane lies in the same surface.
const LEAST_HEIGHT: f32 = 1e-3;

/// Cosines count as no less: what is interpolated is shaded at other places than it was sampled at, where a centre that lay at
/// the horizon may stand high. In the living room with 0.05 a single pixel held 0.4 of the squared error.
const LEAST_COSINE: f32 = 0.3;

/// Sources by place, for the rays of points next to them.
pub struct NearField {
    /// The sources that have an area.
    grid: SurfelGrid,
    /// Which they are.
    members: Vec<u32>,
    directions: Vec<Vec3>,
    radius: f32,
}

impl NearField {
    /// For sources that are about `radius` metres apart.
    pub fn new(sources: &[Source], radius: f32) -> Self {
        let members: Vec<u32> = (0..sources.len() as u32).filter(|&i| sources[i as usize].area > 0.0).collect();
        let surfels: Vec<Surfel> = members.iter().map(|&i| sources[i as usize].surfel).collect();
        let grid = SurfelGrid::of((OWNED_WITHIN * radius).max(f32::MIN_POSITIVE), &surfels);
        Self { grid, members, directions: fibonacci_directions(RAYS), radius }
    }

    /// Whether rays from `origin` say what it sees of a source, and not the source's disc.
    #[inline(always)]
    pub fn holds(&self, source: &Source, origin: Vec3) -> bool {
        let reach = REACH * self.radius;
        source.surfel.position.distance_squared(origin) < reach * reach
    }

    /// Whether `origin` lies in front of a source's plane, and not just by rounding.
    #[inline(always)]
    pub fn is_over(&self, source: &Source, origin: Vec3) -> bool {
        (origin - source.surfel.position).dot(source.surfel.normal) > LEAST_HEIGHT * self.radius
    }

    /// Calls `add` with sources that [`Self::holds`] of a point at `origin`, which lies off all surfaces, and the solid angle
    /// in steradians that one more ray gives them, of the rays in directions that the point `receives`. `normal` is that of
    /// its cosines. Returns the rays traced.
    pub fn gather(
        &self,
        sources: &[Source],
        scene: &Intersector,
        [origin, normal]: [Vec3; 2],
        receives: impl Fn(Vec3) -> bool,
        mut add: impl FnMut(usize, f32),
    ) -> u64 {
        let cosine = |direction: Vec3| direction.dot(normal).max(LEAST_COSINE);
        let mut rays = 0;
        for &direction in self.directions.iter().filter(|&&d| receives(d)) {
            rays += 1;
            let met = scene.surfel_before(origin, direction, (REACH + OWNED_WITHIN) * self.radius);
            if let Some(owner) = met.and_then(|met| self.owner(sources, origin, &met)) {
                let to_center = (sources[owner].surfel.position - origin).normalize_or_zero();
                add(owner, 2.0 * TAU / RAYS as f32 * cosine(direction) / cosine(to_center));
            }
        }
        rays
    }

    /// The near source that stands for a place; none for one of the surface that `origin` itself lies in, which rays below
    /// the tangent plane of a rounded edge meet.
    fn owner(&self, sources: &[Source], origin: Vec3, place: &Surfel) -> Option<usize> {
        let owner = self.members[self.grid.nearest(place, OWNED_WITHIN * self.radius)?] as usize;
        let source = &sources[owner];
        let is_beside = source.surfel.position.distance(origin) < OWNED_WITHIN * self.radius;
        let is_own = is_beside && !self.is_over(source, origin);
        (self.holds(source, origin) && !is_own).then_some(owner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{scene::Mesh, surfel::Surfel};
    use std::f32::consts::PI;

    /// Distance of the sources, which is that of their places on a grid.
    const CELL: f32 = 0.1;

    /// A floor y = 0 with a wall x = 0 to its left, and discs on a grid over the floor for sources.
    fn floor_and_wall() -> (Intersector, Vec<Source>) {
        let (near, far) = (-10.0, 10.0);
        let mut mesh = Mesh::default();
        let quads = [
            [Vec3::new(0.0, 0.0, near), Vec3::new(0.0, 0.0, far), Vec3::new(far, 0.0, far), Vec3::new(far, 0.0, near)],
            [Vec3::new(0.0, 0.0, near), Vec3::new(0.0, far, near), Vec3::new(0.0, far, far), Vec3::new(0.0, 0.0, far)],
        ];
        for quad in quads {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(quad);
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        let at = |i: i32| (i as f32 + 0.5) * CELL;
        let surfel =
            |x, z| Surfel { position: Vec3::new(at(x), 0.0, at(z)), normal: Vec3::Y, place: Default::default() };
        let places = (0..40).flat_map(|x| (-40..40).map(move |z| (x, z)));
        let sources = places.map(|(x, z)| Source { surfel: surfel(x, z), area: CELL * CELL }).collect();
        (Intersector::new(&mesh), sources)
    }

    fn gathered(near: &NearField, scene: &Intersector, sources: &[Source], origin: Vec3, normal: Vec3) -> Vec<f32> {
        let mut angles = vec![0.0; sources.len()];
        near.gather(sources, scene, [origin, normal], |d| d.dot(normal) > 0.0, |i, angle| angles[i] += angle);
        angles
    }

    #[test]
    fn the_foot_of_a_wall_is_lit_by_the_floor() {
        let (scene, sources) = floor_and_wall();
        let near = NearField::new(&sources, CELL);
        let foot = Vec3::new(1e-4, 0.02 * CELL, 0.0);
        let lit = |angles: Vec<f32>| {
            let cosine = |s: &Source| (s.surfel.position - foot).normalize().x.max(0.0);
            angles.iter().zip(&sources).map(|(angle, s)| angle * cosine(s)).sum::<f32>()
        };
        // Half of what a furnace gives, but for the floor beyond the reach and for small cosines, which count as more.
        let found = lit(gathered(&near, &scene, &sources, foot, Vec3::X));
        assert!((found / (0.5 * PI) - 1.0).abs() < 0.1, "{found}");
        let discs = lit(sources.iter().map(|s| s.solid_angle_from(foot)).collect());
        assert!(discs < 0.3 * PI, "negative control: discs that are seen edge on, {discs}");
    }

    #[test]
    fn sources_have_their_solid_angle_and_only_near_ones() {
        let (scene, sources) = floor_and_wall();
        let near = NearField::new(&sources, CELL);
        let origin = Vec3::new(2.05, 0.3, 0.05);
        let seen = gathered(&near, &scene, &sources, origin, Vec3::NEG_Y);
        let below = sources.iter().position(|s| s.surfel.position.distance(origin) < 0.301).unwrap();
        // A square seen from three of its sides above its middle.
        let exact = 4.0 * (1.0_f32 / 37.0).asin();
        assert!((seen[below] / exact - 1.0).abs() < 0.1, "{} for {exact}", seen[below]);
        for (angle, source) in seen.iter().zip(&sources) {
            assert!(*angle == 0.0 || near.holds(source, origin));
        }
        assert_eq!(gathered(&near, &scene, &sources, origin, Vec3::Y).iter().sum::<f32>(), 0.0, "none above");
    }

    #[test]
    fn light_from_where_no_source_is_does_not_count() {
        let (scene, sources) = floor_and_wall();
        let (origin, left) = (Vec3::new(0.01, 0.5, 0.0), Vec3::NEG_X);
        let near = NearField::new(&sources, CELL);
        let seen: f32 = gathered(&near, &scene, &sources, origin, left).iter().sum();
        assert!(seen < 0.1, "the wall has none: {seen}");
        let none = NearField::new(&sources, 0.0);
        assert!(gathered(&none, &scene, &sources, origin, left).iter().all(|&angle| angle == 0.0));
    }

    #[test]
    fn what_has_no_area_takes_no_light_and_neither_does_one_s_own_surface() {
        let (scene, mut sources) = floor_and_wall();
        let (origin, down) = (Vec3::new(2.05, 0.1, 0.05), Vec3::NEG_Y);
        let all = NearField::new(&sources, CELL);
        let below = sources.iter().position(|s| s.surfel.position.distance(origin) < 0.101).unwrap();
        let full = gathered(&all, &scene, &sources, origin, down);
        sources[below].area = 0.0;
        let seen = gathered(&NearField::new(&sources, CELL), &scene, &sources, origin, down);
        assert!(full[below] > 0.0 && seen[below] == 0.0);
        let sums = [&seen, &full].map(|angles| angles.iter().sum::<f32>());
        assert!((sums[0] / sums[1] - 1.0).abs() < 0.1, "its neighbours stand for its place: {sums:?}");
        let in_floor = Vec3::new(2.05, 1e-5, 0.05);
        assert!(gathered(&all, &scene, &sources, in_floor, down).iter().sum::<f32>() < 1e-2 * sums[1]);
    }
}
