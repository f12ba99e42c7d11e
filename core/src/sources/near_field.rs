//! Solid angles of the sources around a point, by ray tracing.
//!
//! A distant source is a disc, hidden or visible. At small distances the shape of the surfaces around the point matters: in the
//! folds of a sofa discs overlap and reach into other surfaces; at the foot of a wall the floor's discs are seen edge on. So rays
//! sample all directions from the point, and each assigns its part of the sphere to the source that owns the surface it hits.
//! Shading places a source's light at its center, so a ray is weighted by its own cosine over the center's. Irradiance is then
//! nearly right even where rays hit the foot of a wall whose center is far up.

use super::Source;
use crate::{
    ray::{Intersector, in_eights, spatial_order},
    sphere::fibonacci_directions,
    surfel::{GradedGrid, Surfel},
};
use glam::Vec3;
use std::f32::consts::TAU;

/// Sources within this many of their spacings are near.
const REACH: f32 = 8.0;
/// A point farther than this many spacings from every source has no owner: light does not reach it.
pub const OWNED_WITHIN: f32 = 2.0;
/// Rays over the sphere. In a furnished room four times as many are no better, see `docs/decisions/0008-near-field-by-rays.md`.
const RAYS: usize = 1024;
/// A point up to this many spacings above a source's plane lies in the same surface.
const LEAST_HEIGHT: f32 = 1e-3;
/// A hit belongs to the point's own surface if it is at most this multiple of the lift below the origin, and faces
/// nearly as that surface does ([`Origin::same_surface_cosine`]). Smooth normals receive directions below the
/// surrounding faces, which would take the light of those faces' sources.
const SAME_SURFACE_LIFTS: f32 = 2.0;

/// Smallest cosine in the weights of rays. Interpolation shades points between the samples, where a center at the
/// horizon may be high above it. With 0.05 a single pixel of the living room held 0.4 of the squared error.
const LEAST_COSINE: f32 = 0.3;

/// The sources with an area, and a grid that finds the owner of a place.
pub fn owners(sources: &[Source]) -> (Vec<u32>, GradedGrid) {
    let members: Vec<u32> = (0..sources.len() as u32).filter(|&i| sources[i as usize].area > 0.0).collect();
    let reach = |&i: &u32| {
        let Source { surfel, spacing, .. } = sources[i as usize];
        (surfel, OWNED_WITHIN * spacing)
    };
    let grid = GradedGrid::of(members.iter().map(reach));
    (members, grid)
}

/// Origin of a point's rays.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// Position off all surfaces.
    pub position: Vec3,
    /// The common point of all faces around the vertex. It differs from `position` only for vertices sampled beside themselves.
    pub anchor: Vec3,
    /// Unit normal for cosines.
    pub normal: Vec3,
    /// Unit normal of the surface at the point.
    pub face: Vec3,
    /// Distance from that surface, in meters.
    pub lift: f32,
    /// Smallest cosine with `face` at which a hit can belong to the same surface: [`Self::SAME_SURFACE_COSINE`], or
    /// less where faces around a vertex lean farther from its normal.
    pub same_surface_cosine: f32,
}

impl Origin {
    /// Value for a point within a face.
    pub const SAME_SURFACE_COSINE: f32 = 0.5;

    /// Whether a hit belongs to the surface at the point.
    fn lies_in_surface_of(&self, place: &Surfel) -> bool {
        let height = (self.anchor - place.position).dot(place.normal);
        height < SAME_SURFACE_LIFTS * self.lift && place.normal.dot(self.face) > self.same_surface_cosine
    }

    fn height_over(&self, place: &Surfel) -> f32 {
        (self.position - place.position).dot(place.normal)
    }
}

/// Sources by position, for the rays of nearby points.
pub struct NearField {
    /// The sources with an area.
    owners: GradedGrid,
    /// Their indices.
    members: Vec<u32>,
    directions: Vec<Vec3>,
    /// Indices of the owners, sorted so that neighbors are adjacent.
    close_together: Vec<u32>,
    /// Length of the rays, in meters.
    longest: f32,
}

impl NearField {
    /// Prepares the rays for these sources.
    pub fn new(sources: &[Source]) -> Self {
        let (members, owners) = owners(sources);
        let widest = sources.iter().map(|source| source.spacing).fold(0.0, f32::max);
        let longest = (REACH + OWNED_WITHIN) * widest;
        let directions = fibonacci_directions(RAYS);
        Self { owners, members, close_together: spatial_order(&directions), directions, longest }
    }

    /// Whether rays from `origin` determine the source's solid angle, instead of its disc.
    #[inline(always)]
    pub fn holds(&self, source: &Source, origin: Vec3) -> bool {
        let reach = REACH * source.spacing;
        source.surfel.position.distance_squared(origin) < reach * reach
    }

    /// Whether `origin` lies in front of a source's plane by more than rounding.
    #[inline(always)]
    pub fn is_over(&self, source: &Source, origin: Vec3) -> bool {
        (origin - source.surfel.position).dot(source.surfel.normal) > LEAST_HEIGHT * source.spacing
    }

    /// Traces the rays of a point in the directions that it `receives`. Each hit on a source for which [`Self::holds`]
    /// is true calls `add` with that source and the ray's solid angle in steradians. Returns the number of rays traced.
    pub fn gather(
        &self,
        sources: &[Source],
        scene: &Intersector,
        origin: Origin,
        receives: impl Fn(Vec3) -> bool,
        add: impl FnMut(usize, f32),
    ) -> u64 {
        let trace = |rays: &[Vec3]| {
            let eights = in_eights(rays.iter().copied());
            scene.surfels_before(origin.position, &eights, self.longest).into_flattened()
        };
        self.gather_traced(sources, trace, origin, receives, add)
    }

    /// [`Self::gather`] ray by ray, for verification.
    pub fn gather_singly(
        &self,
        sources: &[Source],
        scene: &Intersector,
        origin: Origin,
        receives: impl Fn(Vec3) -> bool,
        add: impl FnMut(usize, f32),
    ) -> u64 {
        let single = |&ray: &Vec3| scene.surfel_before(origin.position, ray, self.longest);
        self.gather_traced(sources, |rays| rays.iter().map(single).collect(), origin, receives, add)
    }

    /// [`Self::gather`], with the hits given by `trace`.
    fn gather_traced(
        &self,
        sources: &[Source],
        trace: impl Fn(&[Vec3]) -> Vec<Option<Surfel>>,
        origin: Origin,
        receives: impl Fn(Vec3) -> bool,
        mut add: impl FnMut(usize, f32),
    ) -> u64 {
        let cosine = |direction: Vec3| direction.dot(origin.normal);
        let direction = |&i: &u32| self.directions[i as usize];
        let received: Vec<u32> = self.close_together.iter().copied().filter(|i| receives(direction(i))).collect();
        let mut met = vec![None; self.directions.len()];
        let traced = trace(&received.iter().map(direction).collect::<Vec<_>>());
        received.iter().zip(traced).for_each(|(&i, surfel)| met[i as usize] = surfel);
        // In the order of the directions, so that sums do not depend on the tracing.
        for (&direction, met) in self.directions.iter().zip(&met) {
            let Some(met) = met else { continue };
            // A ray from high above must not go to a source at the horizon.
            let lowest = if cosine(direction) < LEAST_COSINE { 0.0 } else { LEAST_COSINE };
            let to = |source: &Source| (source.surfel.position - origin.position).normalize_or_zero();
            let owner = self.owner(sources, &origin, met, |source| cosine(to(source)) > lowest);
            // Below a sheet on a floor, the nearest source may be on the other side of the sheet.
            if let Some(owner) = owner.filter(|&owner| receives(to(&sources[owner]))) {
                let cosines = [direction, to(&sources[owner])].map(|d| cosine(d).max(LEAST_COSINE));
                add(owner, 2.0 * TAU / RAYS as f32 * cosines[0] / cosines[1]);
            }
        }
        received.len() as u64
    }

    /// The near source that owns a hit: the nearest that `lights` a point at `origin`, else the nearest of all. The
    /// nearest may not light the point: a table's top is next to a ledge below its rim, and sources may lie at the very
    /// foot of a wall. `None` where the nearest source is far enough to be a disc, and for a hit on the surface of
    /// `origin` itself, which rays below the tangent plane of a rounded edge reach.
    fn owner(
        &self,
        sources: &[Source],
        origin: &Origin,
        place: &Surfel,
        lights: impl Fn(&Source) -> bool,
    ) -> Option<usize> {
        if origin.lies_in_surface_of(place) {
            return None;
        }
        let from = origin.position;
        let source = |i: usize| &sources[self.members[i] as usize];
        let is_own = |s: &Source| s.surfel.position.distance(from) < OWNED_WITHIN * s.spacing && !self.is_over(s, from);
        let stands_in = |i: usize| self.holds(source(i), from) && !is_own(source(i)) && lights(source(i));
        let nearest = self.owners.nearest(place).filter(|&i| self.holds(source(i), from))?;
        let is_elsewhere = origin.height_over(place) > LEAST_HEIGHT * source(nearest).spacing;
        let other = || is_elsewhere.then(|| self.owners.nearest_that(place, stands_in)).flatten();
        let owner = if stands_in(nearest) { nearest } else { other().unwrap_or(nearest) };
        (!is_own(source(owner))).then_some(self.members[owner] as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{mesh::Mesh, surfel::Surfel};
    use std::f32::consts::PI;

    /// Distance of the sources, equal to their spacing on the grid.
    const CELL: f32 = 0.1;

    /// A floor y = 0 with a wall x = 0 on its left, and discs on a grid over the floor as sources.
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
        let surfel = |x, z| Surfel { position: Vec3::new(at(x), 0.0, at(z)), ..Default::default() };
        let places = (0..40).flat_map(|x| (-40..40).map(move |z| (x, z)));
        let sources = places.map(|(x, z)| Source { surfel: surfel(x, z), area: CELL * CELL, spacing: CELL }).collect();
        (Intersector::new(&mesh), sources)
    }

    fn gathered(near: &NearField, scene: &Intersector, sources: &[Source], origin: Vec3, normal: Vec3) -> Vec<f32> {
        let mut angles = vec![0.0; sources.len()];
        let (face, same_surface_cosine) = (normal, Origin::SAME_SURFACE_COSINE);
        let origin = Origin { position: origin, anchor: origin, normal, face, lift: 0.0, same_surface_cosine };
        near.gather(sources, scene, origin, |d| d.dot(normal) > 0.0, |i, angle| angles[i] += angle);
        angles
    }

    #[test]
    fn the_foot_of_a_wall_is_lit_by_the_floor() {
        let (scene, sources) = floor_and_wall();
        let near = NearField::new(&sources);
        let foot = Vec3::new(1e-4, 0.02 * CELL, 0.0);
        let lit = |angles: Vec<f32>| {
            let cosine = |s: &Source| (s.surfel.position - foot).normalize().x.max(0.0);
            angles.iter().zip(&sources).map(|(angle, s)| angle * cosine(s)).sum::<f32>()
        };
        // Half of a furnace, except for the floor beyond the reach and for small cosines, which count more.
        let found = lit(gathered(&near, &scene, &sources, foot, Vec3::X));
        assert!((found / (0.5 * PI) - 1.0).abs() < 0.1, "{found}");
        let discs = lit(sources.iter().map(|s| s.solid_angle_from(foot)).collect());
        assert!(discs < 0.3 * PI, "negative control: discs that are seen edge on, {discs}");
    }

    #[test]
    fn sources_have_their_solid_angle_and_only_near_ones() {
        let (scene, sources) = floor_and_wall();
        let near = NearField::new(&sources);
        let origin = Vec3::new(2.05, 0.3, 0.05);
        let seen = gathered(&near, &scene, &sources, origin, Vec3::NEG_Y);
        let below = sources.iter().position(|s| s.surfel.position.distance(origin) < 0.301).unwrap();
        // A square seen from above its middle, at three times its side.
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
        let near = NearField::new(&sources);
        let seen: f32 = gathered(&near, &scene, &sources, origin, left).iter().sum();
        assert!(seen < 0.1, "the wall has none: {seen}");
        let none: Vec<Source> = sources.iter().map(|s| Source { spacing: 0.0, ..*s }).collect();
        let (near, sources) = (NearField::new(&none), none);
        assert!(gathered(&near, &scene, &sources, origin, left).iter().all(|&angle| angle == 0.0));
    }

    #[test]
    fn what_has_no_area_takes_no_light_and_neither_does_one_s_own_surface() {
        let (scene, mut sources) = floor_and_wall();
        let (origin, down) = (Vec3::new(2.05, 0.1, 0.05), Vec3::NEG_Y);
        let all = NearField::new(&sources);
        let below = sources.iter().position(|s| s.surfel.position.distance(origin) < 0.101).unwrap();
        let full = gathered(&all, &scene, &sources, origin, down);
        sources[below].area = 0.0;
        let seen = gathered(&NearField::new(&sources), &scene, &sources, origin, down);
        assert!(full[below] > 0.0 && seen[below] == 0.0);
        let sums = [&seen, &full].map(|angles| angles.iter().sum::<f32>());
        assert!((sums[0] / sums[1] - 1.0).abs() < 0.1, "its neighbours stand for its place: {sums:?}");
        let in_floor = Vec3::new(2.05, 1e-5, 0.05);
        assert!(gathered(&all, &scene, &sources, in_floor, down).iter().sum::<f32>() < 1e-2 * sums[1]);
    }

    #[test]
    fn directions_below_a_face_that_its_smooth_normal_receives_meet_no_source() {
        let (scene, sources) = floor_and_wall();
        let (near, lift) = (NearField::new(&sources), 0.02 * CELL);
        let normal = Vec3::new(0.0, 0.2, -1.0).normalize();
        let position = Vec3::new(2.02, 0.02 * CELL, 0.03);
        let in_floor = Origin {
            position,
            anchor: position,
            normal,
            face: Vec3::Y,
            lift,
            same_surface_cosine: Origin::SAME_SURFACE_COSINE,
        };
        let gathered = |origin| {
            let mut sum = 0.0;
            near.gather(&sources, &scene, origin, |d| d.dot(normal) > 0.0, |_, angle| sum += angle);
            sum
        };
        assert_eq!(gathered(in_floor), 0.0);
        let vertex = Origin { face: normal, same_surface_cosine: 0.99 * normal.y, ..in_floor };
        assert_eq!(gathered(vertex), 0.0, "of which the normal alone is known");
        let beside = Origin { position: position + Vec3::Y * 0.1 * CELL, ..in_floor };
        assert_eq!(gathered(beside), 0.0, "a vertex that samples beside itself");
        for (control, is) in [
            (
                Origin { same_surface_cosine: Origin::SAME_SURFACE_COSINE, ..vertex },
                "one whose faces are said to lean less",
            ),
            (Origin { anchor: beside.position, ..beside }, "a point as high above the floor"),
            (Origin { lift: 0.0, ..in_floor }, "a point that close above the floor, but not in it"),
            (Origin { face: Vec3::NEG_Z, ..in_floor }, "the foot of a wall"),
        ] {
            assert!(gathered(control) > 0.5, "negative control: {is}");
        }
    }

    #[test]
    fn light_of_one_side_does_not_go_to_a_source_before_the_other() {
        let (scene, mut sources) = floor_and_wall();
        sources.retain(|s| s.surfel.position.x > 1.5);
        let near = NearField::new(&sources);
        let foot = Vec3::new(1.49, 0.02, 0.0);
        let lit = |normal| gathered(&near, &scene, &sources, foot, normal).iter().sum::<f32>();
        assert_eq!(lit(Vec3::NEG_X), 0.0);
        assert!(lit(Vec3::X) > 1.0, "negative control: the side that the sources lie before");
    }

    #[test]
    fn a_ledge_below_a_rim_is_not_taken_for_the_top() {
        let surfel = |x, y, z| Surfel { position: Vec3::new(x, y, z), ..Default::default() };
        let source = |surfel| Source { surfel, area: 1e-3, spacing: 0.05 };
        // A ledge of two centimeters at the foot of a rim of one; the top's source is nearer to what the rim sees of it.
        let (low, wide) = (-0.01, 0.02);
        let corners = [(0.0, -1.0), (0.0, 1.0), (wide, 1.0), (wide, -1.0)];
        let mesh = Mesh {
            positions: corners.map(|(x, z)| Vec3::new(x, low, z)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Default::default()
        };
        let sources = [source(surfel(-0.005, 0.0, 0.0)), source(surfel(0.015, low, 0.04))];
        let (scene, rim) = (Intersector::new(&mesh), Vec3::new(1e-4, -0.005, 0.0));
        let seen = |sources: &[Source]| gathered(&NearField::new(sources), &scene, sources, rim, Vec3::X);
        let angles = seen(&sources);
        assert!(angles[0] == 0.0 && angles[1] > 0.5, "{angles:?}");
        assert_eq!(seen(&sources[..1]), [0.0], "negative control: the top gives the rim no light");
    }

    #[test]
    fn sources_at_the_very_foot_of_a_wall_do_not_take_the_light_from_above() {
        let (scene, _) = floor_and_wall();
        let surfel = |y, z| Surfel { position: Vec3::new(0.0, y, z), normal: Vec3::X, ..Default::default() };
        let at = |row: i32, i: i32| surfel(CELL * (row as f32 + 0.02), CELL * i as f32);
        let row = |row: i32| (-20..20).map(move |i| at(row, i));
        let source = |surfel| Source { surfel, area: CELL * CELL, spacing: CELL };
        let sources: Vec<Source> = (0..20).flat_map(row).map(source).collect();
        let floor = Vec3::new(0.1 * CELL, 1e-5, 0.5 * CELL);
        let lit = |sources: &[Source]| {
            let angles = gathered(&NearField::new(sources), &scene, sources, floor, Vec3::Y);
            let cosine = |s: &Source| (s.surfel.position - floor).normalize().y;
            angles.iter().zip(sources).map(|(angle, s)| angle * cosine(s)).sum::<f32>()
        };
        // Half of a furnace, except for the wall beyond the reach and for low rays: cosines below 0.3 hold 0.09 of it,
        // and go to the foot.
        let found = lit(&sources);
        assert!((found / (0.5 * PI) - 1.0).abs() < 0.1, "{found}");
        assert!(lit(&sources[..40]) < 0.3 * PI, "negative control: none above");
    }

    /// At half the spacing, four times as many sources give the same light.
    #[test]
    fn sources_of_two_spacings_give_as_much_as_of_one() {
        let (scene, even) = floor_and_wall();
        let halves = [-0.25, 0.25].map(|step| step * CELL);
        let quarters = |s: &Source| {
            let at = s.surfel.position;
            let quarter = move |(x, z)| {
                let surfel = Surfel { position: at + Vec3::new(x, 0.0, z), ..s.surfel };
                Source { surfel, area: 0.25 * s.area, spacing: 0.5 * s.spacing }
            };
            halves.into_iter().flat_map(move |x| halves.map(|z| (x, z))).map(quarter).collect::<Vec<_>>()
        };
        let (fine, coarse): (Vec<_>, Vec<_>) = even.iter().partition(|s| s.surfel.position.x < 1.5);
        let graded: Vec<Source> = fine.iter().flat_map(quarters).chain(coarse).collect();
        // Over the border of the two, by rays nearby and discs beyond.
        let origin = Vec3::new(1.5, 0.15, 0.0);
        let lit = |sources: &[Source]| {
            let near = NearField::new(sources);
            let mut angles = gathered(&near, &scene, sources, origin, Vec3::NEG_Y);
            let far = sources.iter().zip(&mut angles).filter(|(s, _)| !near.holds(s, origin));
            far.for_each(|(s, angle)| *angle = s.solid_angle_from(origin));
            let cosine = |s: &Source| -(s.surfel.position - origin).normalize().y;
            angles.iter().zip(sources).map(|(angle, s)| angle * cosine(s)).sum::<f32>()
        };
        let (found, known) = (lit(&graded), lit(&even));
        assert!((found / known - 1.0).abs() < 0.01, "{found} for {known}");
        let holes: Vec<Source> = graded.iter().filter(|s| s.spacing < CELL).copied().collect();
        assert!(lit(&holes) < 0.8 * known, "negative control: places whose sources are missing belong to none");
    }
}
