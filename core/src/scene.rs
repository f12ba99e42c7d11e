//! A scene: one indexed mesh with per-triangle material and object, materials, textures and cameras.

pub mod placed;
pub mod pose;

use crate::{
    animation::ClipTime,
    bounds::Bounds,
    camera::Camera,
    ground::GroundStart,
    lights::Light,
    material::Material,
    opacity::PartOpacity,
    parts::Variants,
    surfel::{MeshPlace, Surfel},
    texture::Texture,
};
use glam::{Vec2, Vec3, Vec4};
use placed::Placed;
use std::sync::Arc;
use thiserror::Error;

/// The farthest from the origin, in metres along an axis, that anything of a scene may be. The fourth power of a distance
/// has to stay far below the largest `f32`.
pub const MOST_COORDINATE: f32 = 1e9;

/// The least diagonal of a scene in metres. The fourth power of a distance has to stay above the smallest `f32`.
pub const LEAST_DIAGONAL: f32 = 1e-6;

/// Whether a place is finite and no farther than [`MOST_COORDINATE`] along any axis.
pub fn is_within_reach(place: Vec3) -> bool {
    place.abs().cmple(Vec3::splat(MOST_COORDINATE)).all()
}

/// How much the length of a stored direction may differ from 1.
const UNIT_TOLERANCE: f32 = 0.1;

/// Whether a direction is about of length 1.
pub fn is_unit(direction: Vec3) -> bool {
    (direction.length() - 1.0).abs() <= UNIT_TOLERANCE
}

/// An indexed triangle mesh in world space. All vertex arrays have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions in metres.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per vertex.
    pub normals: Vec<Vec3>,
    /// Unit tangents along +u (xyz) and the handedness of the frame (w = ±1): `bitangent = w · n × t`.
    pub tangents: Vec<Vec4>,
    /// Texture coordinates, at most [`MOST_COORDINATE`]; (0, 0) is the *top left* corner of an image, as in glTF.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, counter-clockwise seen from the outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`], one per triangle.
    pub triangle_material: Vec<u32>,
    /// Index into [`Scene::objects`], one per triangle.
    pub triangle_object: Vec<u32>,
    /// Where the ground under the scene begins, if there is one; see [`crate::ground`].
    pub ground: Option<GroundStart>,
}

/// A named part of the scene that can be selected as one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Object {
    /// Name from the source file, or one made up from its position there.
    pub name: String,
}

/// Everything that an import yields.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// All triangles of all objects, in world space.
    pub mesh: Mesh,
    /// Materials; at least one if there are triangles.
    pub materials: Vec<Material>,
    /// Textures that the materials refer to by index; shared, since they are large and never change.
    pub textures: Vec<Arc<Texture>>,
    /// Objects that the triangles refer to by index.
    pub objects: Vec<Object>,
    /// Cameras of the source file; may be empty.
    pub cameras: Vec<Camera>,
    /// Local lights of the source file; may be empty.
    pub lights: Vec<Light>,
    /// Variants of the materials.
    pub variants: Variants,
    /// Parts that let through other light than their materials, as a bake of them takes it; a file has none.
    pub part_opacities: Vec<PartOpacity>,
    /// Objects that a bake has elsewhere than its file, or deformed; a file has none.
    pub placed: Vec<Placed>,
    /// The time of an animation that a bake has it at; `None` at rest, as a file is.
    pub clip_time: Option<ClipTime>,
}

impl Scene {
    /// The same with another mesh, of the same objects and materials.
    #[must_use]
    pub fn with_mesh(&self, mesh: Mesh) -> Self {
        Self {
            mesh,
            materials: self.materials.clone(),
            textures: self.textures.clone(),
            objects: self.objects.clone(),
            cameras: self.cameras.clone(),
            lights: self.lights.clone(),
            variants: self.variants.clone(),
            part_opacities: self.part_opacities.clone(),
            placed: self.placed.clone(),
            clip_time: self.clip_time.clone(),
        }
    }

    /// The camera of a name.
    ///
    /// # Errors
    /// [`NoSuchCamera`], which lists those that there are.
    pub fn camera(&self, name: &str) -> Result<&Camera, NoSuchCamera> {
        camera_named(self.cameras.iter(), name)
    }

    /// The first camera, or a view of all of the scene if it has none.
    pub fn first_view(&self) -> Camera {
        let bounds = self.mesh.bounds();
        let whole = || Camera::framing(bounds.center(), 0.5 * bounds.diagonal());
        self.cameras.first().cloned().unwrap_or_else(whole)
    }
}

/// The first camera of a name.
///
/// # Errors
/// [`NoSuchCamera`], which lists those that there are.
pub fn camera_named<'a>(
    mut cameras: impl Iterator<Item = &'a Camera> + Clone,
    name: &str,
) -> Result<&'a Camera, NoSuchCamera> {
    let all = cameras.clone();
    cameras
        .find(|camera| camera.name == name)
        .ok_or_else(|| NoSuchCamera { name: name.to_owned(), known: all.map(|camera| camera.name.clone()).collect() })
}

/// A name that no camera of a scene has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("the scene has no camera \"{name}\"; it has {}", if known.is_empty() { "none".into() } else { known.join(", ") })]
pub struct NoSuchCamera {
    /// What was asked for.
    pub name: String,
    /// Those of the scene.
    pub known: Vec<String>,
}

/// Errors that make a mesh unusable. Importers repair or report before this; a dataset is checked when loaded.
#[derive(Debug, Error, PartialEq)]
pub enum MeshError {
    /// Nothing to show.
    #[error("the mesh has no triangles; check that the file holds faces and not only points or lines")]
    Empty,
    /// Arrays that belong together differ in length.
    #[error("the mesh has {found} {array} for {expected} {owner}; the file is damaged, export or bake it again")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// What it is counted per.
        owner: &'static str,
        /// Its length.
        found: usize,
        /// The length that it needs.
        expected: usize,
    },
    /// An index points past its array.
    #[error("triangle {triangle} refers to {array} {index}, but there are {count}; export the mesh again")]
    Index {
        /// Which triangle.
        triangle: usize,
        /// What the index is into.
        array: &'static str,
        /// The index.
        index: u32,
        /// Number of elements there.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("{array} {index} is not a finite number; repair the mesh in the program that wrote it")]
    NotFinite {
        /// Name of the array.
        array: &'static str,
        /// Which element.
        index: usize,
    },
    /// A coordinate is beyond [`MOST_COORDINATE`].
    #[error("{array} {index} is {value:e}, beyond the limit of {MOST_COORDINATE:e}; scale the scene down")]
    TooFar {
        /// Name of the array.
        array: &'static str,
        /// Which element.
        index: usize,
        /// The largest of its numbers.
        value: f32,
    },
    /// A normal or tangent that is no direction.
    #[error("{array} {index} is not of length 1; recalculate it in the program that wrote the mesh")]
    NotUnit {
        /// Name of the array.
        array: &'static str,
        /// Which element.
        index: usize,
    },
    /// Everything is in one place, or nearly.
    #[error("the scene is {diagonal:e} m across, below the limit of {LEAST_DIAGONAL:e} m; scale the scene up")]
    TooSmall {
        /// Diagonal of its bounds in metres.
        diagonal: f32,
    },
    /// Vertices that an animation made for another mesh.
    #[error("object {object} is deformed with {found} vertices and has {expected}; pose the scene as it is now")]
    Deformed {
        /// Which object.
        object: u32,
        /// Vertices of the pose.
        found: usize,
        /// Vertices of the object.
        expected: usize,
    },
    /// More objects than can be moved one by one.
    #[error("the scene has {found} objects, and at most {most} can be posed; join some of them")]
    TooManyObjects {
        /// How many there are.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// The ground shares vertices with the scene, or begins nowhere.
    #[error("the ground of the mesh is not apart from the rest; the file is damaged, bake the scene again")]
    Ground,
}

/// Checks that places are finite and within reach, and that they are not all in one.
///
/// # Errors
/// [`MeshError::NotFinite`], [`MeshError::TooFar`] or [`MeshError::TooSmall`].
pub fn check_extent(positions: impl Iterator<Item = Vec3> + Clone) -> Result<(), MeshError> {
    check_numbers("position", positions.clone().map(|p| size(p.as_ref())))?;
    let diagonal = Bounds::around(positions).diagonal();
    if diagonal >= LEAST_DIAGONAL { Ok(()) } else { Err(MeshError::TooSmall { diagonal }) }
}

/// The largest of some numbers without their signs; NaN if one of them is.
fn size(numbers: &[f32]) -> f32 {
    numbers.iter().map(|x| x.abs()).fold(0.0, |a, b| if a.is_nan() || b <= a { a } else { b })
}

/// Checks that numbers are finite and within reach.
fn check_numbers(array: &'static str, sizes: impl Iterator<Item = f32>) -> Result<(), MeshError> {
    let wrong = |(_, value): &(usize, f32)| !(*value <= MOST_COORDINATE);
    match sizes.enumerate().find(wrong) {
        None => Ok(()),
        Some((index, value)) if value.is_finite() => Err(MeshError::TooFar { array, index, value }),
        Some((index, _)) => Err(MeshError::NotFinite { array, index }),
    }
}

impl Mesh {
    /// By vertex, the object that it goes with: the first of those of its triangles, or `u32::MAX` without triangles.
    pub fn owners(&self) -> Vec<u32> {
        let mut owners = vec![u32::MAX; self.positions.len()];
        for (corners, &object) in self.triangles.iter().zip(&self.triangle_object) {
            for &vertex in corners {
                owners[vertex as usize] = object.min(owners[vertex as usize]);
            }
        }
        owners
    }

    /// Bounds of all vertices but those of the ground.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.positions[..self.vertices_of_scene()].iter().copied())
    }

    /// The three corners of a triangle in metres.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Cross product of two edges: normal direction, twice the area long.
    #[inline]
    pub fn area_vector(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// A point of a triangle by the weights of its second and third corner, seen from the front or the back.
    pub fn surfel(&self, triangle: u32, barycentric: Vec2, from_behind: bool) -> Surfel {
        let [a, b, c] = self.corners(triangle as usize);
        let front = self.area_vector(triangle as usize).normalize_or(Vec3::Y);
        Surfel {
            position: a + (b - a) * barycentric.x + (c - a) * barycentric.y,
            normal: if from_behind { -front } else { front },
            place: MeshPlace { triangle, barycentric },
        }
    }

    /// The unit normal by which a surface point receives light: that of the vertices, interpolated, on the point's
    /// side.
    pub fn shading_normal(&self, at: &Surfel) -> Vec3 {
        let MeshPlace { triangle, barycentric: b } = at.place;
        let weights = [1.0 - b.x - b.y, b.x, b.y];
        let weighted = |(&v, w): (&u32, f32)| self.normals[v as usize] * w;
        let smooth: Vec3 = self.triangles[triangle as usize].iter().zip(weights).map(weighted).sum();
        let side = self.area_vector(triangle as usize).dot(at.normal).signum();
        (smooth * side).try_normalize().unwrap_or(at.normal)
    }

    /// Checks lengths, indices, finiteness, extent, and that directions are of length 1, against `materials` and `objects`
    /// entries to refer to.
    ///
    /// # Errors
    /// The first [`MeshError`] found.
    pub fn validate(&self, materials: usize, objects: usize) -> Result<(), MeshError> {
        if self.triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        self.validate_lengths()?;
        self.validate_indices(materials, objects)?;
        self.validate_numbers()?;
        self.validate_directions()
    }

    fn validate_lengths(&self) -> Result<(), MeshError> {
        let (v, t) = (self.positions.len(), self.triangles.len());
        for (array, owner, found, expected) in [
            ("normals", "vertices", self.normals.len(), v),
            ("tangents", "vertices", self.tangents.len(), v),
            ("texture coordinates", "vertices", self.uvs.len(), v),
            ("material indices", "triangles", self.triangle_material.len(), t),
            ("object indices", "triangles", self.triangle_object.len(), t),
        ] {
            if found != expected {
                return Err(MeshError::Length { array, owner, found, expected });
            }
        }
        Ok(())
    }

    fn validate_indices(&self, materials: usize, objects: usize) -> Result<(), MeshError> {
        let check = |triangle, array, index: u32, count| {
            if (index as usize) < count { Ok(()) } else { Err(MeshError::Index { triangle, array, index, count }) }
        };
        for (t, corners) in self.triangles.iter().enumerate() {
            for &vertex in corners {
                check(t, "vertex", vertex, self.positions.len())?;
            }
            check(t, "material", self.triangle_material[t], materials)?;
            check(t, "object", self.triangle_object[t], objects)?;
        }
        self.validate_ground()
    }

    /// The ground has its own triangles and vertices, and is not all there is.
    fn validate_ground(&self) -> Result<(), MeshError> {
        let Some(GroundStart { vertex, triangle }) = self.ground else { return Ok(()) };
        let (of_scene, of_ground) = self.triangles.split_at_checked(triangle as usize).ok_or(MeshError::Ground)?;
        let is_apart =
            of_scene.iter().flatten().all(|&v| v < vertex) && of_ground.iter().flatten().all(|&v| v >= vertex);
        if is_apart && !of_scene.is_empty() && !of_ground.is_empty() { Ok(()) } else { Err(MeshError::Ground) }
    }

    fn validate_numbers(&self) -> Result<(), MeshError> {
        fn check(array: &'static str, mut finite: impl Iterator<Item = bool>) -> Result<(), MeshError> {
            finite.position(|f| !f).map_or(Ok(()), |index| Err(MeshError::NotFinite { array, index }))
        }
        let (of_scene, of_ground) = self.positions.split_at(self.vertices_of_scene());
        check_extent(of_scene.iter().copied())?;
        check_numbers("position", of_ground.iter().map(|p| size(p.as_ref())))?;
        check("normal", self.normals.iter().map(|n| n.is_finite()))?;
        check("tangent", self.tangents.iter().map(|t| t.is_finite()))?;
        check_numbers("texture coordinate", self.uvs.iter().map(|uv| size(uv.as_ref())))
    }

    /// Tangents may be zero where there is no direction of u.
    fn validate_directions(&self) -> Result<(), MeshError> {
        fn check(array: &'static str, mut unit: impl Iterator<Item = bool>) -> Result<(), MeshError> {
            unit.position(|u| !u).map_or(Ok(()), |index| Err(MeshError::NotUnit { array, index }))
        }
        let longest = 1.0 + UNIT_TOLERANCE;
        let is_tangent = |t: &Vec4| t.w.abs() <= longest && t.truncate().length() <= longest;
        check("normal", self.normals.iter().map(|&n| is_unit(n)))?;
        check("tangent", self.tangents.iter().map(is_tangent))
    }
}
