//! Placement of surfels on the surface of an object.
//!
//! Points are sampled uniformly by area, [`GROUP`] for each surfel, and clustered by position and normal into a
//! balanced tree. A surfel is the point in the middle of its group. Surfels are far more even than independent samples,
//! so discs of their areas leave no holes.

use crate::{
    bounds::Bounds,
    light_tree::{Features, cluster_order_of_groups},
    mesh::Mesh,
    surfel::Surfel,
};
use glam::{Vec2, Vec3};

/// Points per surfel.
const GROUP: usize = 16;
/// Weight of position against normal in the clustering, for an object of unit diagonal.
const PLACE_WEIGHT: f32 = 12.0;

/// A surfel attached to a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// Place and normal at the pose of its placement.
    pub surfel: Surfel,
    /// Its area in areas of its triangle.
    pub share: f32,
}

/// The sides of a mesh's triangles, for sampling.
pub struct Sides<'a> {
    mesh: &'a Mesh,
    two_sided: &'a [bool],
    bounds: Bounds,
}

impl<'a> Sides<'a> {
    /// The sides of a mesh; `two_sided` has an entry per triangle.
    pub fn new(mesh: &'a Mesh, two_sided: &'a [bool]) -> Self {
        Self { mesh, two_sided, bounds: mesh.bounds() }
    }

    /// Area of a triangle in m², of both sides if it is two-sided, weighted by [`Self::density`].
    pub fn weight(&self, triangle: u32) -> f64 {
        let sides = if self.two_sided[triangle as usize] { 2.0 } else { 1.0 };
        0.5 * f64::from(self.mesh.area_vector(triangle as usize).length()) * sides * f64::from(self.density(triangle))
    }

    /// Relative number of surfels per area: 1, and on the ground lower by the squared distance in radii of the scene. A
    /// ground is much larger than the objects on it. It has no surfels where its light reaches nothing.
    fn density(&self, triangle: u32) -> f32 {
        if !self.mesh.is_ground(triangle) {
            return 1.0;
        }
        match self.mesh.is_far_ground(triangle, self.bounds) {
            true => 0.0,
            false => self.mesh.radii_of_ground(triangle, self.bounds).max(1.0).powi(-2),
        }
    }

    /// `count` points of some triangles, one per stretch of equal weight, and the weight of a stretch.
    fn points(&self, triangles: &[u32], count: usize, seed: u64) -> (Vec<Surfel>, f64) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let total: f64 = triangles.iter().map(|&t| self.weight(t)).sum();
        let step = total / count as f64;
        let mut points = Vec::with_capacity(count);
        let (mut end, mut next) = (0.0, step * rng.f64());
        for &triangle in triangles {
            end += self.weight(triangle);
            while next < end && points.len() < count {
                points.push(self.random_point(triangle, &mut rng));
                next = (points.len() as f64 + rng.f64()) * step;
            }
        }
        // Rounding may omit the last point.
        points.resize_with(count, || self.random_point(triangles[triangles.len() - 1], &mut rng));
        (points, step)
    }

    fn random_point(&self, triangle: u32, rng: &mut fastrand::Rng) -> Surfel {
        let (u, v) = (rng.f32(), rng.f32());
        let barycentric = if u + v > 1.0 { Vec2::new(1.0 - u, 1.0 - v) } else { Vec2::new(u, v) };
        let back = self.two_sided[triangle as usize] && rng.bool();
        self.mesh.surfel(triangle, barycentric, back)
    }

    /// `count` surfels of some triangles, in the order of the leaves of a balanced tree, with equal weights.
    pub fn surfels(&self, triangles: &[u32], count: u32, seed: u64) -> Vec<Carried> {
        let (points, step) = self.points(triangles, count as usize * GROUP, seed);
        let order = cluster_order_of_groups(&features(&points), GROUP);
        order.chunks_exact(GROUP).map(|group| self.middle(group, &points, step)).collect()
    }

    /// The point of a group nearest to its mean.
    fn middle(&self, group: &[u32], points: &[Surfel], step: f64) -> Carried {
        let all = || group.iter().map(|&i| &points[i as usize]);
        let mean = all().map(|p| p.position).sum::<Vec3>() / GROUP as f32;
        let normal = all().map(|p| p.normal).sum::<Vec3>();
        // Points that face away from the mean normal come last.
        let away = |p: &Surfel| (p.normal.dot(normal) <= 0.0, p.position.distance_squared(mean));
        let nearest = all().min_by(|a, b| {
            let (a, b) = (away(a), away(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let surfel = *nearest.expect("groups have points");
        let area_of = |p: &Surfel| step as f32 / self.density(p.place.triangle);
        let triangle = 0.5 * self.mesh.area_vector(surfel.place.triangle as usize).length();
        Carried { surfel, share: all().map(area_of).sum::<f32>() / triangle }
    }
}

/// Position in units of the diagonal over [`PLACE_WEIGHT`], and normal.
fn features(points: &[Surfel]) -> Features {
    let diagonal = Bounds::around(points.iter().map(|p| p.position)).diagonal();
    let scale = PLACE_WEIGHT / diagonal.max(f32::MIN_POSITIVE);
    let row = |p: &Surfel| [(p.position * scale).to_array(), p.normal.to_array()].concat();
    Features::new(6, points.iter().flat_map(row).collect())
}
