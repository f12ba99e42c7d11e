//! The ground under a lone object: a plane fitted under the scene, practically endless.
//!
//! It is part of the mesh, so it is baked and rendered like everything else. Its tessellation follows the distance from
//! the scene. [`Mesh::bounds`] leaves it out, because it says nothing about the size of the objects on it.

mod floor;

pub use floor::has_floor;

use crate::{
    bounds::{Bounds, MOST_COORDINATE},
    brdf::GgxParameters,
    material::{BrdfModel, Material},
    mesh::Mesh,
    scene::{Object, Scene},
};
use glam::{Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};
use std::{f32::consts::TAU, fmt};

/// Kind of ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ground {
    /// No ground.
    #[default]
    Off,
    /// A surface with its own material.
    On,
    /// Only its shadows and caught light show, over the background.
    Shadow,
}

impl Ground {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Off, Self::On, Self::Shadow];

    /// The name in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::On => "on",
            Self::Shadow => "shadow",
        }
    }

    /// The default for a scene: a lone object gets a ground that catches its shadow, a scene with a floor gets none.
    pub fn suiting(mesh: &Mesh) -> Self {
        if has_floor(mesh) { Self::Off } else { Self::Shadow }
    }
}

impl fmt::Display for Ground {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Name of the ground's object and material.
pub const NAME: &str = "Ground";

/// Radii of the rings of its mesh as shares of the scene's radius, half of the diagonal. A bake subdivides them.
const RINGS: [f32; 9] = [0.5, 1.0, 2.0, 4.0, REACH, 32.0, 128.0, 512.0, 2048.0];
/// Corners of a ring.
const SEGMENTS: u32 = 12;
/// Distance up to which the ground reflects light to other surfaces, in radii of the scene. Ground beyond it has an
/// elevation of at most 7 degrees.
const REACH: f32 = 8.0;
/// Distance below the lowest point, as a share of the diagonal, so that flat bottoms do not coincide with it.
const GAP: f32 = 1e-4;
/// Vertices of the mesh before subdivision.
pub const LEAST_VERTICES: usize = 1 + RINGS.len() * SEGMENTS as usize;
/// Reflectance of a ground without another material.
const REFLECTANCE: f32 = 0.5;

/// Adds a ground under a scene, with its own object and material. A scene with a ground stays unchanged.
pub fn add_ground(scene: &mut Scene) {
    if scene.mesh.ground.is_some() {
        return;
    }
    let [object, material] = [scene.objects.len() as u32, scene.materials.len() as u32];
    let ground = plane(scene.mesh.bounds(), object, material);
    scene.objects.push(Object { name: NAME.into() });
    let parameters = GgxParameters { base_color: Vec3::splat(REFLECTANCE), ..GgxParameters::default() };
    scene.materials.push(Material {
        name: NAME.into(),
        model: BrdfModel::Lambert,
        parameters: parameters.into(),
        ..Material::default()
    });
    scene.mesh.append_ground(ground);
}

/// The plane under a scene with these bounds: rings around its center.
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
        ..Default::default()
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
    /// 0 for a triangle of the scene; 1 or more for a triangle of the ground, increasing with distance by factors of four.
    pub(crate) fn shell_of_ground(&self, triangle: u32, bounds: Bounds) -> u32 {
        if !self.is_ground(triangle) {
            return 0;
        }
        1 + (self.radii_of_ground(triangle, bounds).clamp(1.0, 1e9).log2() / 2.0) as u32
    }

    /// Distance of the center of a ground triangle from the center of bounds, along the ground, in their radii.
    pub(crate) fn radii_of_ground(&self, triangle: u32, bounds: Bounds) -> f32 {
        self.distance_of(triangle, bounds) / (0.5 * bounds.diagonal())
    }

    /// Distance in meters of the center of a triangle from the center of bounds, along the ground.
    fn distance_of(&self, triangle: u32, bounds: Bounds) -> f32 {
        let middle = self.corners(triangle as usize).iter().sum::<Vec3>() / 3.0;
        middle.with_y(0.0).distance(bounds.center().with_y(0.0))
    }

    /// Whether a triangle lies so far out on the ground that its light reaches no other surface. `bounds` are the mesh's.
    pub fn is_far_ground(&self, triangle: u32, bounds: Bounds) -> bool {
        self.is_ground(triangle) && self.distance_of(triangle, bounds) > REACH * 0.5 * bounds.diagonal()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{dataset::scene_hash, ground::floor::tests::cube};

    fn scene_of(mesh: Mesh) -> Scene {
        let objects = vec![Object { name: "object".into() }];
        Scene { mesh, materials: vec![Material::default()], objects, ..Scene::default() }
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
    fn grounds_have_the_same_names_in_files_and_in_words() {
        for ground in Ground::ALL {
            assert_eq!(serde_json::to_string(&ground).unwrap(), format!("\"{ground}\""));
        }
    }
}
