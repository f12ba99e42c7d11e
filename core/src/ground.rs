//! The ground that a lone object stands on: a plane fitted under the scene, endless to the eye.
//!
//! It is a part of the mesh, so that it is baked and rendered as all else is. It is as fine as its distance from the scene
//! asks, and [`Mesh::bounds`] leaves it out, since it says nothing about the size of what stands on it.

use crate::{
    bounds::Bounds,
    material::{BrdfModel, BrdfParameters, Material},
    scene::{MOST_COORDINATE, Mesh, Object, Scene},
};
use glam::{Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};
use std::{f32::consts::TAU, fmt, str::FromStr};

/// What the ground of a scene is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ground {
    /// There is none.
    #[default]
    Off,
    /// A surface with a material of its own.
    On,
    /// Only its shadows and the light that it catches are seen, over the background.
    Shadow,
}

impl Ground {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Off, Self::On, Self::Shadow];

    /// The name in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::On => "on",
            Self::Shadow => "shadow",
        }
    }

    /// What suits a scene: a lone object gets a ground that catches its shadow, and a scene with a floor gets none.
    pub fn suiting(mesh: &Mesh) -> Self {
        if has_floor(mesh) { Self::Off } else { Self::Shadow }
    }
}

impl fmt::Display for Ground {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Ground {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|ground| ground.name() == text);
        found.ok_or_else(|| format!("\"{text}\" is no ground; write off, on or shadow"))
    }
}

/// Where the ground of a mesh begins: its vertices and triangles are the last ones, and nothing else uses them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GroundStart {
    /// Its first vertex.
    pub vertex: u32,
    /// Its first triangle.
    pub triangle: u32,
}

/// Name of the ground's object and material.
pub const NAME: &str = "Ground";

/// Radii of the rings of its mesh as shares of the scene's radius, half of the diagonal. A bake splits them further.
const RINGS: [f32; 9] = [0.5, 1.0, 2.0, 4.0, REACH, 32.0, 128.0, 512.0, 2048.0];
/// Corners of a ring.
const SEGMENTS: u32 = 12;
/// How far the ground reflects light to other surfaces, in radii of the scene. What lies beyond has an elevation of 7 degrees
/// and less.
const REACH: f32 = 8.0;
/// How far it lies below the lowest point, as a share of the diagonal, so that flat bottoms do not lie in it.
const GAP: f32 = 1e-4;
/// Vertices of the mesh that is split further.
pub const LEAST_VERTICES: usize = 1 + RINGS.len() * SEGMENTS as usize;
/// Reflectance of a ground that has no other material yet.
const REFLECTANCE: f32 = 0.5;

/// Adds a ground under a scene, with an object and a material of its own. A scene that has one stays as it is.
pub fn add_ground(scene: &mut Scene) {
    if scene.mesh.ground.is_some() {
        return;
    }
    let [object, material] = [scene.objects.len() as u32, scene.materials.len() as u32];
    let ground = plane(scene.mesh.bounds(), object, material);
    scene.objects.push(Object { name: NAME.into() });
    let parameters = BrdfParameters { base_color: Vec3::splat(REFLECTANCE), ..BrdfParameters::default() };
    scene.materials.push(Material { name: NAME.into(), model: BrdfModel::Lambert, parameters, ..Material::default() });
    scene.mesh.append_ground(ground);
}

/// The plane under a scene of some bounds: rings around its centre.
fn plane(bounds: Bounds, object: u32, material: u32) -> Mesh {
    let (center, diagonal) = (bounds.center(), bounds.diagonal());
    let corner = |radius: f32, turn: f32| Vec2::from_angle(TAU * turn) * radius * 0.5 * diagonal;
    let around = |&radius| (0..SEGMENTS).map(move |i| corner(radius, i as f32 / SEGMENTS as f32));
    let offsets: Vec<Vec2> = std::iter::once(Vec2::ZERO).chain(RINGS.iter().flat_map(around)).collect();
    let limit = Vec3::splat(MOST_COORDINATE);
    let foot = Vec3::new(center.x, bounds.min.y - GAP * diagonal, center.z);
    let place = |offset: &Vec2| (foot + Vec3::new(offset.x, 0.0, offset.y)).clamp(-limit, limit);
    let triangles = triangles_of_rings();
    Mesh {
        positions: offsets.iter().map(place).collect(),
        normals: vec![Vec3::Y; offsets.len()],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); offsets.len()],
        // One repetition of a texture is as long as the diagonal.
        uvs: offsets.iter().map(|offset| Vec2::new(offset.x, -offset.y) / diagonal).collect(),
        triangle_material: vec![material; triangles.len()],
        triangle_object: vec![object; triangles.len()],
        triangles,
        ground: None,
    }
}

/// A fan around the first vertex, and strips between the rings; they face up.
fn triangles_of_rings() -> Vec<[u32; 3]> {
    let at = |ring: u32, i: u32| 1 + ring * SEGMENTS + i % SEGMENTS;
    let fan = (0..SEGMENTS).map(|i| [0, at(0, i + 1), at(0, i)]);
    let strip = |ring: u32| {
        (0..SEGMENTS).flat_map(move |i| {
            let [a, b, c, d] = [at(ring, i), at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)];
            [[a, b, d], [a, d, c]]
        })
    };
    fan.chain((0..RINGS.len() as u32 - 1).flat_map(strip)).collect()
}

impl Mesh {
    /// Whether a triangle belongs to the ground.
    #[inline]
    pub fn is_ground(&self, triangle: u32) -> bool {
        self.ground.is_some_and(|start| triangle >= start.triangle)
    }

    /// The material of the ground, if there is one.
    pub fn ground_material(&self) -> Option<u32> {
        self.triangle_material.get(self.ground?.triangle as usize).copied()
    }

    /// 0 for a triangle of the scene; for one of the ground 1 and more, the larger the farther out it is, by factors of four.
    pub(crate) fn shell_of_ground(&self, triangle: u32, bounds: Bounds) -> u32 {
        if !self.is_ground(triangle) {
            return 0;
        }
        let radii = self.distance_of(triangle, bounds) / (0.5 * bounds.diagonal());
        1 + (radii.clamp(1.0, 1e9).log2() / 2.0) as u32
    }

    /// Distance in metres of the middle of a triangle from the centre of bounds, along the ground.
    fn distance_of(&self, triangle: u32, bounds: Bounds) -> f32 {
        let middle = self.corners(triangle as usize).iter().sum::<Vec3>() / 3.0;
        middle.with_y(0.0).distance(bounds.center().with_y(0.0))
    }

    /// The object of the ground, if there is one.
    pub fn ground_object(&self) -> Option<u32> {
        self.triangle_object.get(self.ground?.triangle as usize).copied()
    }

    /// Whether a triangle lies so far out on the ground that its light reaches no other surface. `bounds` are those of the mesh.
    pub fn is_far_ground(&self, triangle: u32, bounds: Bounds) -> bool {
        self.is_ground(triangle) && self.distance_of(triangle, bounds) > REACH * 0.5 * bounds.diagonal()
    }

    /// Appends a ground, which is a mesh of its own with the objects and materials of this one.
    pub fn append_ground(&mut self, ground: Self) {
        let start = GroundStart { vertex: self.positions.len() as u32, triangle: self.triangles.len() as u32 };
        self.positions.extend(ground.positions);
        self.normals.extend(ground.normals);
        self.tangents.extend(ground.tangents);
        self.uvs.extend(ground.uvs);
        self.triangles.extend(ground.triangles.into_iter().map(|corners| corners.map(|v| start.vertex + v)));
        self.triangle_material.extend(ground.triangle_material);
        self.triangle_object.extend(ground.triangle_object);
        self.ground = Some(start);
    }

    /// Takes the ground away, as a mesh of its own.
    pub fn split_off_ground(&mut self) -> Option<Self> {
        let GroundStart { vertex, triangle } = self.ground.take()?;
        let (from_vertex, from_triangle) = (vertex as usize, triangle as usize);
        let triangles = self.triangles.split_off(from_triangle);
        Some(Self {
            positions: self.positions.split_off(from_vertex),
            normals: self.normals.split_off(from_vertex),
            tangents: self.tangents.split_off(from_vertex),
            uvs: self.uvs.split_off(from_vertex),
            triangles: triangles.into_iter().map(|corners| corners.map(|v| v - vertex)).collect(),
            triangle_material: self.triangle_material.split_off(from_triangle),
            triangle_object: self.triangle_object.split_off(from_triangle),
            ground: None,
        })
    }
}

/// Cells along each side of the grid over a scene's footprint.
const CELLS: usize = 64;
/// Share of the footprint that a floor covers.
const FLOOR_COVERS: f32 = 0.5;
/// How high above the lowest point a floor may lie, as a share of the diagonal: slabs are thin.
const FLOOR_HEIGHT: f32 = 0.05;

/// Whether a scene has a floor of its own: over most of its footprint there is something to stand on, close above the lowest point,
/// or in the lower half of the scene with nothing below it, as land is.
pub fn has_floor(mesh: &Mesh) -> bool {
    let bounds = mesh.bounds();
    let mut cells = vec![Column::default(); CELLS * CELLS];
    let triangles = mesh.ground.map_or(mesh.triangles.len(), |start| start.triangle as usize);
    (0..triangles).for_each(|t| Column::add_triangle(&mut cells, mesh, t, bounds));
    let highest = [bounds.min.y + FLOOR_HEIGHT * bounds.diagonal(), bounds.center().y];
    let floors = cells.iter().filter(|column| column.has_floor(highest)).count();
    floors as f32 >= FLOOR_COVERS * cells.len() as f32
}

/// The lowest surfaces over a cell of the footprint, by height.
#[derive(Clone, Copy)]
struct Column {
    facing_up: f32,
    facing_down: f32,
}

impl Default for Column {
    fn default() -> Self {
        Self { facing_up: f32::INFINITY, facing_down: f32::INFINITY }
    }
}

impl Column {
    /// For the highest floor with something below it, and the highest one without.
    fn has_floor(&self, [slab, land]: [f32; 2]) -> bool {
        self.facing_up <= slab || self.facing_up <= land && self.facing_up <= self.facing_down
    }

    /// Adds the heights of a triangle over the middles of the cells that it covers.
    fn add_triangle(cells: &mut [Self], mesh: &Mesh, triangle: usize, bounds: Bounds) {
        let extent = (bounds.max - bounds.min).max(Vec3::splat(1e-6 * bounds.diagonal()));
        let corners = mesh.corners(triangle).map(|corner| (corner - bounds.min) / extent * CELLS as f32);
        let [a, b, c] = corners.map(|corner| Vec2::new(corner.x, corner.z));
        let heights = mesh.corners(triangle).map(|corner| corner.y);
        let twice_area = (b - a).perp_dot(c - a);
        if twice_area == 0.0 {
            return;
        }
        let covered = |low: f32, high: f32| {
            (low - 0.5).ceil().max(0.0) as usize..((high - 0.5).floor() + 1.0).clamp(0.0, CELLS as f32) as usize
        };
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for z in covered(low.y, high.y) {
            for x in covered(low.x, high.x) {
                let middle = Vec2::new(x as f32 + 0.5, z as f32 + 0.5);
                let weights =
                    [(c - b).perp_dot(middle - b), (a - c).perp_dot(middle - c), (b - a).perp_dot(middle - a)]
                        .map(|weight| weight / twice_area);
                if weights.iter().all(|&weight| weight >= 0.0) {
                    let height: f32 = weights.iter().zip(heights).map(|(weight, height)| weight * height).sum();
                    // Counter-clockwise in x and z is downward.
                    let cell = &mut cells[z * CELLS + x];
                    let lowest = if twice_area < 0.0 { &mut cell.facing_up } else { &mut cell.facing_down };
                    *lowest = lowest.min(height);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::scene_hash;

    /// A box between two corners, seen from outside, or a floor of no thickness if its corners have one height.
    fn block(min: Vec3, max: Vec3) -> Mesh {
        let corner = |i: u32| Vec3::from_array(std::array::from_fn(|k| if i >> k & 1 == 1 { max[k] } else { min[k] }));
        let quads: &[[u32; 4]] = match min.y == max.y {
            true => &[[2, 6, 7, 3]],
            false => &[[2, 6, 7, 3], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [0, 2, 3, 1], [4, 5, 7, 6]],
        };
        let triangles: Vec<_> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh {
            positions: (0..8).map(corner).collect(),
            normals: vec![Vec3::Y; 8],
            tangents: vec![Vec4::X; 8],
            uvs: vec![Vec2::ZERO; 8],
            triangle_material: vec![0; triangles.len()],
            triangle_object: vec![0; triangles.len()],
            triangles,
            ground: None,
        }
    }

    /// Both as one mesh.
    fn both(mut a: Mesh, b: Mesh) -> Mesh {
        a.append_ground(b);
        Mesh { ground: None, ..a }
    }

    fn cube() -> Mesh {
        block(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 1.0, 0.5))
    }

    fn scene_of(mesh: Mesh) -> Scene {
        let objects = vec![Object { name: "object".into() }];
        Scene { mesh, materials: vec![Material::default()], objects, ..Scene::default() }
    }

    #[test]
    fn a_cube_is_a_lone_object_and_one_on_a_floor_or_slab_is_not() {
        assert!(!has_floor(&cube()));
        for (bottom, name) in [(0.0, "floor"), (-0.1, "slab")] {
            let mut mesh = both(cube(), block(Vec3::new(-2.0, bottom, -2.0), Vec3::new(2.0, 0.0, 2.0)));
            assert!(has_floor(&mesh), "{name}");
            // Upside down it hangs from a ceiling.
            mesh.positions.iter_mut().for_each(|p| *p *= Vec3::new(1.0, -1.0, -1.0));
            assert!(!has_floor(&mesh), "{name}");
        }
        let mut open = cube();
        open.triangles.retain(|corners| corners.iter().any(|&v| open.positions[v as usize].y > 0.0));
        open.triangle_material.truncate(open.triangles.len());
        assert!(open.triangles.len() == 10 && !has_floor(&open), "without a bottom");
        let small = both(cube(), block(Vec3::ZERO, Vec3::new(0.1, 0.0, 0.1)));
        assert!(!has_floor(&small), "negative control");
    }

    #[test]
    fn the_ground_lies_under_scenes_of_all_sizes_and_reaches_the_horizon() {
        for size in [1e-3, 1.0, 1e5] {
            let mut mesh = cube();
            mesh.positions.iter_mut().for_each(|p| *p = *p * size + Vec3::new(3.0, -7.0, 1.0) * size);
            let (bounds, hash) = (mesh.bounds(), scene_hash(&scene_of(mesh.clone())));
            let mut scene = scene_of(mesh);
            add_ground(&mut scene);
            scene.mesh.validate(scene.materials.len(), scene.objects.len()).unwrap();
            assert_eq!(scene.mesh.bounds(), bounds);
            assert_ne!(scene_hash(&scene), hash);
            let ground = scene.mesh.clone().split_off_ground().unwrap();
            assert!((0..ground.triangles.len()).all(|t| ground.area_vector(t).y > 0.0));
            let all = Bounds::around(ground.positions.iter().copied());
            assert!(all.max.y < bounds.min.y && bounds.min.y - all.max.y < 1e-3 * size);
            // A viewer one diagonal high sees its edge a twentieth of a degree below the horizon.
            assert!((all.max - all.min).min_element() == 0.0 && all.diagonal() > 3900.0 * 0.5 * bounds.diagonal());
        }
    }

    #[test]
    fn a_ground_that_is_split_off_and_appended_is_the_same() {
        let mut scene = scene_of(cube());
        add_ground(&mut scene);
        let whole = scene.mesh.clone();
        let ground = scene.mesh.split_off_ground().unwrap();
        assert_eq!(scene.mesh, cube());
        assert!(scene.mesh.clone().split_off_ground().is_none());
        scene.mesh.append_ground(ground);
        assert_eq!(scene.mesh, whole);
        let objects = scene.objects.len();
        add_ground(&mut scene);
        assert!(scene.objects.len() == objects && scene.mesh == whole, "a second ground is not added");
    }

    #[test]
    fn only_the_near_ground_reflects_light_to_other_surfaces() {
        let mut scene = scene_of(cube());
        add_ground(&mut scene);
        let (mesh, bounds) = (&scene.mesh, scene.mesh.bounds());
        let count = |wanted: &dyn Fn(u32) -> bool| (0..mesh.triangles.len() as u32).filter(|&t| wanted(t)).count();
        let (ground, far) = (count(&|t| mesh.is_ground(t)), count(&|t| mesh.is_far_ground(t, bounds)));
        assert_eq!(ground, mesh.triangles.len() - 12);
        assert_eq!(far, 4 * 2 * SEGMENTS as usize, "rings beyond 8 radii");
    }

    #[test]
    fn names_of_grounds_are_read_back() {
        for ground in Ground::ALL {
            assert_eq!(ground.to_string().parse(), Ok(ground));
            assert_eq!(serde_json::to_string(&ground).unwrap(), format!("\"{ground}\""));
        }
        assert!("grass".parse::<Ground>().unwrap_err().contains("off, on or shadow"));
    }
}
