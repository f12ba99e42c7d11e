//! Triangles on which light arrives from both sides.
//!
//! A material may be two-sided. Also, a connected piece with an open boundary (a cloth, a leaf) can be seen from behind, so it is
//! sampled from both sides. The exception is a piece with the whole scene in front of it: a floor's underside faces nothing. Closed
//! pieces receive light only from outside; sampling inside them would waste rays.

use glam::Vec3;
use lapidary_core::{
    opacity::Opacities,
    scene::{Mesh, Scene},
};
use rustc_hash::{FxBuildHasher, FxHashMap};

/// Index of the first vertex at the same position, for every vertex.
pub fn weld_positions(mesh: &Mesh) -> Vec<u32> {
    let mut first = FxHashMap::with_capacity_and_hasher(mesh.positions.len(), FxBuildHasher);
    mesh.positions.iter().enumerate().map(|(i, &p)| *first.entry(exact_key(p)).or_insert(i as u32)).collect()
}

/// The bits of a vector, for exact comparison; adding 0.0 turns -0.0 into 0.0.
pub fn exact_key(v: Vec3) -> [u32; 3] {
    (v + 0.0).to_array().map(f32::to_bits)
}

/// Properties of the sides of each triangle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sidedness {
    /// Whether each triangle receives light, and is visible, from both sides.
    pub two_sided: Vec<bool>,
    /// Whether each triangle belongs to a piece without boundary, so that its back is inside.
    pub closed: Vec<bool>,
}

impl Sidedness {
    /// Splits off the entries from triangle `first` on.
    pub fn split_off(&mut self, first: usize) -> Self {
        Self { two_sided: self.two_sided.split_off(first), closed: self.closed.split_off(first) }
    }

    /// Appends entries of further triangles.
    pub fn append(&mut self, other: Self) {
        self.two_sided.extend(other.two_sided);
        self.closed.extend(other.closed);
    }
}

/// Classifies every triangle.
pub fn classify(scene: &Scene) -> Sidedness {
    let mesh = &scene.mesh;
    let pieces = Pieces::new(mesh);
    let ground: Vec<bool> = pieces.ground(mesh);
    let material_says = |t: usize| scene.materials[mesh.triangle_material[t] as usize].double_sided;
    // Surfaces behind a transparent one are visible, including its own back.
    let opacities = Opacities::of_scene(scene);
    let thin = opacities.thin();
    let is_thin = |t: usize| thin[opacities.material(mesh, t as u32) as usize].is_some();
    let piece = |t: usize| pieces.of_triangle[t] as usize;
    let is_open = |t: usize| pieces.open[piece(t)] || is_thin(t);
    let count = mesh.triangles.len();
    Sidedness {
        two_sided: (0..count).map(|t| material_says(t) || (is_open(t) && !ground[piece(t)])).collect(),
        closed: (0..count).map(|t| !is_open(t)).collect(),
    }
}

/// Connected pieces of a mesh, by welded positions.
struct Pieces {
    of_triangle: Vec<u32>,
    open: Vec<bool>,
}

impl Pieces {
    fn new(mesh: &Mesh) -> Self {
        let weld = weld_positions(mesh);
        let welded = |t: usize| mesh.triangles[t].map(|v| weld[v as usize]);
        let mut union = Union::new(mesh.positions.len());
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = welded(t);
            union.join(a, b);
            union.join(b, c);
        }
        let mut ids = FxHashMap::default();
        let of_triangle: Vec<u32> = (0..mesh.triangles.len())
            .map(|t| {
                let next = ids.len() as u32;
                *ids.entry(union.find(welded(t)[0])).or_insert(next)
            })
            .collect();
        let mut open = vec![false; ids.len()];
        for t in boundary_triangles(mesh, welded) {
            open[of_triangle[t] as usize] = true;
        }
        Self { of_triangle, open }
    }

    /// Whether each piece is flat with nothing of the scene behind it.
    fn ground(&self, mesh: &Mesh) -> Vec<bool> {
        let slack = 1e-3 * mesh.bounds().diagonal();
        // An added ground lies behind all objects on it.
        let of_scene = &mesh.positions[..mesh.vertices_of_scene()];
        let mut normal = vec![Vec3::ZERO; self.open.len()];
        let mut anchor = vec![Vec3::ZERO; self.open.len()];
        for (t, &piece) in self.of_triangle.iter().enumerate() {
            normal[piece as usize] += mesh.area_vector(t);
            anchor[piece as usize] = mesh.corners(t)[0];
        }
        let mut flat = self.open.clone();
        for (t, &piece) in self.of_triangle.iter().enumerate() {
            let (area, mean) = (mesh.area_vector(t), normal[piece as usize].normalize_or_zero());
            flat[piece as usize] &= area.dot(mean) > 0.99 * area.length();
        }
        let all_in_front = |piece: usize| {
            let n = normal[piece].normalize_or_zero();
            of_scene.iter().all(|p| (*p - anchor[piece]).dot(n) > -slack)
        };
        (0..self.open.len()).map(|piece| flat[piece] && all_in_front(piece)).collect()
    }
}

/// Triangles with an edge that no other triangle shares.
fn boundary_triangles(mesh: &Mesh, welded: impl Fn(usize) -> [u32; 3]) -> Vec<usize> {
    let mut edges: FxHashMap<(u32, u32), (usize, u32)> =
        FxHashMap::with_capacity_and_hasher(mesh.triangles.len() * 3 / 2, FxBuildHasher);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = welded(t);
        for (u, v) in [(a, b), (b, c), (c, a)] {
            edges.entry((u.min(v), u.max(v))).or_insert((t, 0)).1 += 1;
        }
    }
    edges.into_values().filter(|&(_, uses)| uses == 1).map(|(t, _)| t).collect()
}

/// Union-find with path halving.
struct Union(Vec<u32>);

impl Union {
    fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    fn find(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{cuboid, floor, quad, scene_of};

    #[test]
    fn boxes_are_closed_floors_are_ground_and_banners_two_sided() {
        let mut triangles = cuboid(Vec3::new(0.0, 1.0, 0.0), Vec3::splat(0.5));
        assert!(triangles.iter().all(|t| (t[1] - t[0]).cross(t[2] - t[0]).dot(t[0] - Vec3::Y) > 0.0), "outward");
        triangles.extend(floor(3.0, 0.0));
        let p = |x: f32, y: f32| Vec3::new(x, y, 1.0);
        triangles.extend(quad(p(-1.0, 0.5), p(1.0, 0.5), p(1.0, 2.0), p(-1.0, 2.0)));
        let sides = classify(&scene_of(&triangles));
        assert_eq!(sides.closed, [vec![true; 12], vec![false; 4]].concat());
        assert_eq!(sides.two_sided, [vec![false; 14], vec![true; 2]].concat());
    }

    #[test]
    fn both_sides_of_what_lets_light_through_are_seen() {
        let mut scene = scene_of(&cuboid(Vec3::ZERO, Vec3::ONE));
        let sides = |scene: &Scene| (classify(scene).two_sided[0], classify(scene).closed[0]);
        assert_eq!(sides(&scene), (false, true));
        scene.materials[0].parameters.set("geometry_opacity", 0.5);
        assert_eq!(sides(&scene), (true, false));
    }

    #[test]
    fn a_material_can_make_a_floor_two_sided() {
        let mut scene = scene_of(&floor(1.0, 0.0));
        assert_eq!(classify(&scene).two_sided, vec![false; 2]);
        scene.materials[0].double_sided = true;
        assert_eq!(classify(&scene).two_sided, vec![true; 2]);
    }
}
