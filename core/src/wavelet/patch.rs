//! Quads of a scene: surfaces with a point for each point of the unit square (wavelet paper, section 3).

use crate::{
    mesh::Mesh,
    sphere::{concentric, frame_along},
};
use glam::{Mat2, Mat3, Vec2, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use thiserror::Error;

/// A parallelogram, seen from the side of its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The point (0, 0).
    pub corner: Vec3,
    /// From the corner to the points (1, 0) and (0, 1).
    pub edges: [Vec3; 2],
    /// Tangent, bitangent and normal, as columns: the frame of directions.
    pub frame: Mat3,
    /// Area in m².
    pub area: f32,
    /// Its material.
    pub material: u32,
    /// The object that it is part of.
    pub object: u32,
}

/// A triangle without another one that makes a parallelogram of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "triangle {triangle} is no half of a flat quad with parallel sides; wavelet transport needs a scene of such quads alone"
)]
pub struct NotAQuad {
    /// Its index.
    pub triangle: u32,
}

/// Largest distance of a fourth corner from where it belongs, as a share of the shorter edge.
const TOLERANCE: f32 = 1e-3;

impl Patch {
    /// The point for a point of the unit square.
    pub fn point(&self, square: Vec2) -> Vec3 {
        self.corner + self.edges[0] * square.x + self.edges[1] * square.y
    }

    /// The point of the unit square for a point on the plane of the patch.
    pub fn square_of(&self, point: Vec3) -> Vec2 {
        let [u, v] = self.square_from_offset();
        Vec2::new(u.dot(point - self.corner), v.dot(point - self.corner))
    }

    /// Vectors whose dot products with an offset from the corner are its coordinates in the unit square.
    pub fn square_from_offset(&self) -> [Vec3; 2] {
        let [a, b] = self.edges;
        let normal = a.cross(b);
        [b.cross(normal), normal.cross(a)].map(|along| along / normal.length_squared())
    }

    /// Whether it lies in the plane of another one, with the same side; if asked, with the same frame of directions.
    pub fn continues(&self, other: &Self, with_frame: bool) -> bool {
        let height = (self.corner - other.corner).dot(other.normal());
        let is_in_plane =
            height.abs() <= TOLERANCE * other.area.sqrt() && self.normal().dot(other.normal()) > 1.0 - TOLERANCE;
        is_in_plane && (!with_frame || self.frame.abs_diff_eq(other.frame, TOLERANCE))
    }

    /// Whether the middle of a triangle of a mesh lies on it, with the same side.
    fn holds(&self, mesh: &Mesh, triangle: usize) -> bool {
        let middle = mesh.corners(triangle).iter().sum::<Vec3>() / 3.0;
        let square = self.square_of(middle);
        square.min_element() >= 0.0
            && square.max_element() <= 1.0
            && self.point(square).distance(middle) <= TOLERANCE * self.area.sqrt()
            && mesh.area_vector(triangle).dot(self.normal()) >= 0.0
    }

    /// The patch after its object was moved, by a triangle on it as it was and as it is.
    #[must_use]
    pub fn carried(&self, before: [Vec3; 3], now: [Vec3; 3]) -> Self {
        let [a, b, c] = before.map(|corner| self.square_of(corner));
        let weights_from_square = Mat2::from_cols(b - a, c - a).inverse();
        let carried = |point: Vec3| {
            let weights = weights_from_square * (self.square_of(point) - a);
            now[0] + (now[1] - now[0]) * weights.x + (now[2] - now[0]) * weights.y
        };
        let corner = carried(self.corner);
        let edges = self.edges.map(|edge| carried(self.corner + edge) - corner);
        let across = edges[0].cross(edges[1]);
        let tangent = carried(self.corner + self.frame.x_axis) - corner;
        let frame = frame_along(across.normalize_or(self.normal()), tangent, self.frame.determinant());
        Self { corner, edges, frame, area: across.length(), ..*self }
    }

    /// The unit normal.
    pub fn normal(&self) -> Vec3 {
        self.frame.z_axis
    }

    /// The unit direction for a point of the square of directions. Equal areas have equal integrals of the cosine.
    pub fn direction(&self, square: Vec2) -> Vec3 {
        let disc = concentric::disc_from_square(square);
        self.frame * disc.extend((1.0 - disc.length_squared()).max(0.0).sqrt())
    }

    /// The point of the square of directions for a unit direction on the visible side.
    pub fn square_of_direction(&self, direction: Vec3) -> Vec2 {
        concentric::square_from_disc((self.frame.transpose() * direction).truncate())
    }

    /// The patch of two triangles: of the corner `apex` of the first, and of the corner of the second that is opposite to it.
    fn of_halves(mesh: &Mesh, [first, second]: [u32; 2], apex: usize) -> Option<Self> {
        let triangle = mesh.corners(first as usize);
        let [corner, a, b] = [0, 1, 2].map(|i| triangle[(apex + i) % 3]);
        let edges = [a - corner, b - corner];
        let fourth = corner + edges[0] + edges[1];
        let most = TOLERANCE * edges[0].length().min(edges[1].length());
        let other = mesh.corners(second as usize);
        let is_corner = |point: Vec3| other.iter().any(|other| other.distance(point) <= most);
        let faces = |i: u32| mesh.area_vector(i as usize);
        let normal = faces(first).try_normalize()?;
        let is_one = [a, b, fourth].into_iter().all(is_corner) && faces(second).dot(normal) > 0.0;
        let is_alike = mesh.triangle_material[first as usize] == mesh.triangle_material[second as usize];
        let tangent = mesh.tangents[mesh.triangles[first as usize][apex] as usize];
        let frame = frame_along(normal, tangent.truncate(), tangent.w);
        let area = edges[0].cross(edges[1]).length();
        let [material, object] = [&mesh.triangle_material, &mesh.triangle_object].map(|of| of[first as usize]);
        (is_one && is_alike).then_some(Self { corner, edges, frame, area, material, object })
    }
}

/// The patches of a mesh, in the order of their first triangles.
///
/// # Errors
/// A triangle belongs to none.
pub fn patches(mesh: &Mesh) -> Result<Vec<Patch>, NotAQuad> {
    let mut is_taken = vec![false; mesh.triangles.len()];
    let by_corner = by_corner(mesh);
    let mut patches = Vec::new();
    for triangle in 0..mesh.triangles.len() as u32 {
        if is_taken[triangle as usize] {
            continue;
        }
        let corners = mesh.corners(triangle as usize);
        let neighbors = corners.iter().flat_map(|corner| &by_corner[&bits(*corner)]).copied();
        // Writers of files split one quad after the other, so the next triangle comes first.
        let candidates = std::iter::once(triangle + 1).chain(neighbors);
        let is_free = |&other: &u32| other > triangle && is_taken.get(other as usize) == Some(&false);
        let mut found = candidates.filter(is_free).flat_map(|other| {
            longest_edge_first(corners)
                .into_iter()
                .filter_map(move |apex| Some((other, Patch::of_halves(mesh, [triangle, other], apex)?)))
        });
        let (other, patch) = found.next().ok_or(NotAQuad { triangle })?;
        [triangle, other].into_iter().for_each(|half| is_taken[half as usize] = true);
        patches.push(patch);
    }
    Ok(patches)
}

/// The patch of each triangle of a mesh, which may be split further than the mesh of the patches; `None` on none.
pub fn patch_of_triangles(mesh: &Mesh, patches: &[Patch]) -> Vec<Option<u32>> {
    let mut of_objects = FxHashMap::<u32, Vec<u32>>::default();
    (0..).zip(patches).for_each(|(index, patch)| of_objects.entry(patch.object).or_default().push(index));
    let find = |triangle: usize| {
        let of_object = of_objects.get(&mesh.triangle_object[triangle])?;
        of_object.iter().copied().find(|&index| patches[index as usize].holds(mesh, triangle))
    };
    (0..mesh.triangles.len()).into_par_iter().map(find).collect()
}

/// Corners of a triangle, those opposite to long edges first: a quad is most often split along its longer diagonal.
fn longest_edge_first(corners: [Vec3; 3]) -> [usize; 3] {
    let mut order = [0, 1, 2];
    let opposite = |apex: usize| corners[(apex + 1) % 3].distance_squared(corners[(apex + 2) % 3]);
    order.sort_by(|&a, &b| opposite(b).total_cmp(&opposite(a)));
    order
}

/// Triangles at each position.
fn by_corner(mesh: &Mesh) -> FxHashMap<[u32; 3], Vec<u32>> {
    let mut found = FxHashMap::<_, Vec<u32>>::default();
    for triangle in 0..mesh.triangles.len() {
        mesh.corners(triangle).iter().for_each(|corner| found.entry(bits(*corner)).or_default().push(triangle as u32));
    }
    found
}

fn bits(position: Vec3) -> [u32; 3] {
    // Negative zero is zero.
    (position + Vec3::ZERO).to_array().map(f32::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{cuboid, floor, room, scene_of};
    use glam::{Affine3A, Quat};

    #[test]
    fn rooms_and_boxes_are_quads() {
        let scene = scene_of(&[room(Vec3::ZERO, Vec3::ONE), cuboid(Vec3::ZERO, Vec3::splat(0.3))].concat());
        let found = patches(&scene.mesh).unwrap();
        assert_eq!(found.len(), 12);
        let area: f32 = found.iter().map(|patch| patch.area).sum();
        assert!((area - (24.0 + 6.0 * 0.36)).abs() < 1e-4, "{area}");
        for patch in &found {
            let square = Vec2::new(0.2, 0.7);
            assert!(patch.square_of(patch.point(square)).distance(square) < 1e-5);
            assert!(patch.square_of_direction(patch.direction(square)).distance(square) < 1e-4);
        }
    }

    #[test]
    fn triangles_of_a_finer_mesh_are_on_the_patch_that_they_were_split_from() {
        let scene = scene_of(&[room(Vec3::ZERO, Vec3::ONE), cuboid(Vec3::ZERO, Vec3::splat(0.3))].concat());
        let found = patches(&scene.mesh).unwrap();
        let of = patch_of_triangles(&scene.mesh, &found);
        assert!((0..12).all(|patch| of.iter().filter(|&&of| of == Some(patch)).count() == 2), "{of:?}");
        let quarter = |[a, b, c]: [Vec3; 3]| [a, a.midpoint(b), a.midpoint(c)];
        let corners: Vec<_> = (0..of.len()).map(|triangle| quarter(scene.mesh.corners(triangle))).collect();
        assert_eq!(patch_of_triangles(&scene_of(&corners).mesh, &found), of);
        let turned: Vec<_> = corners.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert!(patch_of_triangles(&scene_of(&turned).mesh, &found).iter().all(Option::is_none), "negative control");
    }

    #[test]
    fn a_patch_goes_with_a_triangle_on_it() {
        let patch = patches(&scene_of(&floor(1.0, 0.0)).mesh).unwrap()[0];
        let moved = Affine3A::from_scale_rotation_translation(
            Vec3::splat(2.0),
            Quat::from_rotation_x(0.4),
            Vec3::new(1.0, 2.0, 3.0),
        );
        let triangle = [Vec2::ZERO, Vec2::new(0.5, 0.1), Vec2::new(0.2, 0.6)].map(|square| patch.point(square));
        let carried = patch.carried(triangle, triangle.map(|corner| moved.transform_point3(corner)));
        for square in [Vec2::ZERO, Vec2::X, Vec2::new(0.3, 0.9)] {
            assert!(carried.point(square).abs_diff_eq(moved.transform_point3(patch.point(square)), 1e-5));
            let direction = moved.transform_vector3(patch.direction(square)) / 2.0;
            assert!(carried.direction(square).abs_diff_eq(direction, 1e-5));
        }
        assert!((carried.area - 4.0 * patch.area).abs() < 1e-4);
        assert_eq!(patch.carried(triangle, triangle).corner, patch.corner);
    }

    #[test]
    fn a_triangle_alone_is_refused_by_its_number() {
        let mut triangles = floor(1.0, 0.0).to_vec();
        triangles.extend(floor(1.0, 1.0));
        triangles.pop();
        assert_eq!(patches(&scene_of(&triangles).mesh), Err(NotAQuad { triangle: 2 }));
        // A trapezoid.
        let mut bent = floor(1.0, 0.0).to_vec();
        bent[1][2].x += 0.1;
        assert!(patches(&scene_of(&bent).mesh).is_err());
    }

    #[test]
    fn two_materials_are_no_quad() {
        let mut scene = scene_of(&floor(1.0, 0.0));
        assert!(patches(&scene.mesh).is_ok());
        scene.mesh.triangle_material[1] = 1;
        assert!(patches(&scene.mesh).is_err());
    }
}
