//! A triangle mesh as a surface for light transport.

mod carrier;

pub use carrier::CarryingMesh;

use crate::{
    bounds::Bounds,
    mesh::Mesh,
    meshless::Owner,
    ray::{Hit, Intersector},
    surfel::{Surface, Surfel},
};
use glam::{Vec2, Vec3};

/// Diffuse reflectance of a point of the mesh.
pub type Reflectance<'a> = &'a (dyn Fn(&Surfel) -> Vec3 + Sync);

/// A mesh with the visible sides of its triangles.
#[derive(Clone, Copy)]
pub struct MeshSurface<'a> {
    mesh: &'a Mesh,
    intersector: &'a Intersector,
    two_sided: &'a [bool],
    reflectance: Reflectance<'a>,
    bounds: Bounds,
}

impl<'a> MeshSurface<'a> {
    /// `two_sided` has one entry per triangle. Backs of one-sided triangles are invisible to light.
    pub fn new(
        mesh: &'a Mesh,
        intersector: &'a Intersector,
        two_sided: &'a [bool],
        reflectance: Reflectance<'a>,
    ) -> Self {
        Self { mesh, intersector, two_sided, reflectance, bounds: mesh.bounds() }
    }

    /// Whether a ray meets the mesh from either side.
    pub fn hits_anything(&self, origin: Vec3, direction: Vec3) -> bool {
        let is_plain = self.mesh.ground.is_none() && !self.intersector.has_veils();
        let hit = || self.intersector.closest_above(origin, direction, |_| 0.0);
        match is_plain {
            true => self.intersector.occluded(origin, direction),
            false => hit().is_some_and(|hit| !self.is_far(hit.triangle)),
        }
    }

    /// Whether a triangle is so far out on the ground that its light reaches nothing; it then does not count as a surface.
    fn is_far(&self, triangle: u32) -> bool {
        self.mesh.is_far_ground(triangle, self.bounds)
    }

    /// Whether rays that arrive at a point of the mesh hit its own triangle, and not another one in the same plane or just above.
    /// Points in a cutout do not count.
    pub fn is_outermost(&self, at: &Surfel) -> bool {
        let hit = self.intersector.closest_above(at.position + at.normal * self.offset(), -at.normal, |_| 0.0);
        hit.is_some_and(|hit| hit.triangle == at.place.triangle)
    }

    /// Object and material of a point of the mesh.
    pub fn part(&self, at: &Surfel) -> (u32, u32) {
        let Owner { object, material, .. } = self.owner(at);
        (object, material)
    }

    /// The side of a part that a point of the mesh belongs to.
    pub fn owner(&self, at: &Surfel) -> Owner {
        Owner::on(self.mesh, at)
    }

    /// Points spread uniformly over all sides of the mesh, and the area in m² that each represents.
    ///
    /// They are stratified: one per stretch of equal area along the list of triangles.
    pub fn uniform_points(&self, count: usize, seed: u64) -> (Vec<Surfel>, f32) {
        self.points_on(0..self.mesh.triangles.len(), count, seed)
    }

    /// [`Self::uniform_points`] on some triangles.
    pub fn points_on(
        &self,
        triangles: impl Iterator<Item = usize> + Clone,
        count: usize,
        seed: u64,
    ) -> (Vec<Surfel>, f32) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let sides = |t: usize| if self.two_sided[t] { 2.0 } else { 1.0 };
        let area = |t: usize| match self.is_far(t as u32) {
            true => 0.0,
            false => 0.5 * f64::from(self.mesh.area_vector(t).length()) * sides(t),
        };
        let total: f64 = triangles.clone().map(area).sum();
        let step = total / count.max(1) as f64;
        let mut points = Vec::with_capacity(count);
        let (mut end, mut next) = (0.0, step * rng.f64());
        for t in triangles {
            end += area(t);
            while next < end {
                points.push(self.random_point(t, &mut rng));
                next = (points.len() as f64 + rng.f64()) * step;
            }
        }
        (points, step as f32)
    }

    /// Points of random triangles, each equally likely: most lie where the mesh is detailed.
    pub fn points_of_random_triangles(&self, count: usize, seed: u64) -> Vec<Surfel> {
        let mut rng = fastrand::Rng::with_seed(seed);
        let triangles = self.mesh.triangles.len();
        let count = if triangles == 0 { 0 } else { count };
        let point = |_| {
            let triangle = rng.usize(0..triangles);
            (!self.is_far(triangle as u32)).then(|| self.random_point(triangle, &mut rng))
        };
        (0..count).filter_map(point).collect()
    }

    /// A uniformly distributed point of a triangle, on either side if it is two-sided.
    fn random_point(&self, triangle: usize, rng: &mut fastrand::Rng) -> Surfel {
        let (u, v) = (rng.f32(), rng.f32());
        let barycentric = if u + v > 1.0 { Vec2::new(1.0 - u, 1.0 - v) } else { Vec2::new(u, v) };
        let back = self.two_sided[triangle] && rng.bool();
        self.mesh.surfel(triangle as u32, barycentric, back)
    }
}

impl MeshSurface<'_> {
    /// The surface point of a hit, if that side is visible to light.
    fn seen(&self, hit: Hit) -> Option<Surfel> {
        let seen = !hit.back_face || self.two_sided[hit.triangle as usize];
        (seen && !self.is_far(hit.triangle)).then(|| self.mesh.surfel(hit.triangle, hit.barycentric, hit.back_face))
    }
}

impl Surface for MeshSurface<'_> {
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel> {
        self.seen(self.intersector.closest_hit(origin, direction)?)
    }

    fn first_hits(&self, origin: Vec3, directions: &[[Vec3; 8]]) -> Vec<[Option<Surfel>; 8]> {
        let seen = |hit: Option<Hit>| hit.and_then(|hit| self.seen(hit));
        self.intersector.closest_hits(origin, directions).into_iter().map(|eight| eight.map(seen)).collect()
    }

    fn sees(&self, from: Vec3, to: Vec3) -> bool {
        self.intersector.lets_through_by_chance(from, to)
    }

    fn reflectance(&self, at: &Surfel) -> Vec3 {
        (self.reflectance)(at)
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{floor, scene_of};

    struct Prepared {
        mesh: Mesh,
        intersector: Intersector,
        two_sided: Vec<bool>,
    }

    impl Prepared {
        fn new(triangles: &[[Vec3; 3]]) -> Self {
            let mesh = scene_of(triangles).mesh;
            Self { intersector: Intersector::new(&mesh), two_sided: vec![false; mesh.triangles.len()], mesh }
        }

        fn surface(&self) -> MeshSurface<'_> {
            MeshSurface::new(&self.mesh, &self.intersector, &self.two_sided, &|_| Vec3::splat(0.5))
        }
    }

    #[test]
    fn backs_of_one_sided_surfaces_do_not_exist_and_those_of_two_sided_ones_do() {
        let mut prepared = Prepared::new(&floor(1.0, 0.0));
        let (above, below) = (Vec3::new(0.2, 1.0, 0.3), Vec3::new(0.2, -1.0, 0.3));
        let hit = prepared.surface().first_hit(above, Vec3::NEG_Y).unwrap();
        assert_eq!(hit.normal, Vec3::Y);
        assert!((hit.position - Vec3::new(0.2, 0.0, 0.3)).length() < 1e-6);
        assert!(prepared.surface().first_hit(below, Vec3::Y).is_none());
        assert!(!prepared.surface().sees(above, below) && prepared.surface().sees(above, above + Vec3::X));
        let eights = [[
            Vec3::Y,
            Vec3::NEG_Y,
            Vec3::X,
            Vec3::Z,
            Vec3::Y,
            Vec3::Y,
            Vec3::new(0.1, 1.0, 0.0).normalize(),
            -Vec3::X,
        ]];
        let one_by_one =
            |prepared: &Prepared, from| eights[0].map(|direction| prepared.surface().first_hit(from, direction));
        let met = |prepared: &Prepared, from| prepared.surface().first_hits(from, &eights)[0];
        for from in [above, below] {
            assert_eq!(met(&prepared, from), one_by_one(&prepared, from));
        }
        assert_eq!([above, below].map(|from| met(&prepared, from).iter().flatten().count()), [1, 0]);
        prepared.two_sided = vec![true; 2];
        assert_eq!(prepared.surface().first_hit(below, Vec3::Y).unwrap().normal, Vec3::NEG_Y);
        assert_eq!(met(&prepared, below), one_by_one(&prepared, below));
        assert_eq!(met(&prepared, below).iter().flatten().count(), 4);
    }

    #[test]
    fn of_faces_that_lie_in_one_another_rays_find_one() {
        let prepared = Prepared::new(&[floor(1.0, 0.0), floor(1.0, 0.0), floor(1.0, -0.5)].concat());
        let surface = prepared.surface();
        let (points, area) = surface.uniform_points(6000, 1);
        let of =
            |y: f32| points.iter().filter(|p| p.normal.y > 0.0 && p.position.y == y && surface.is_outermost(p)).count();
        for y in [0.0, -0.5] {
            assert!((of(y) as f32 * area - 4.0).abs() < 0.2, "{} m2 at {y}", of(y) as f32 * area);
        }
    }

    #[test]
    fn uniform_points_stand_for_the_area_of_all_sides() {
        let mut prepared = Prepared::new(&floor(1.0, 0.0));
        let (points, area) = prepared.surface().uniform_points(1000, 1);
        assert!((points.len() as f32 * area - 4.0).abs() < 1e-3);
        let quarter = points.iter().filter(|p| p.position.x > 0.0 && p.position.z > 0.0).count();
        assert!((quarter as f32 / 250.0 - 1.0).abs() < 0.15, "{quarter}");
        prepared.two_sided = vec![true; 2];
        let (points, area) = prepared.surface().uniform_points(1000, 1);
        assert!((points.len() as f32 * area - 8.0).abs() < 1e-2);
        assert!(points.iter().any(|p| p.normal.y < 0.0) && points.iter().any(|p| p.normal.y > 0.0));
    }
}
