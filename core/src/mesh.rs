//! An indexed triangle mesh with a material and an object per triangle, and its checks.

use crate::{
    bounds::{Bounds, MOST_COORDINATE},
    material::SurfaceAttributes,
    sphere::frame_along,
    surfel::{MeshPlace, Surfel},
    texture::UvSet,
};
use glam::{Affine3A, Mat3, Quat, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, iter};
use thiserror::Error;

/// The smallest diagonal of a scene in meters. The fourth power of a distance must stay above the smallest `f32`.
pub const LEAST_DIAGONAL: f32 = 1e-6;

/// Tolerance of the length of a stored unit direction.
const UNIT_TOLERANCE: f32 = 0.1;

/// Whether a direction has about unit length.
pub fn is_unit(direction: Vec3) -> bool {
    (direction.length() - 1.0).abs() <= UNIT_TOLERANCE
}

/// An indexed triangle mesh in world space. All vertex arrays have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions in meters.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per vertex.
    pub normals: Vec<Vec3>,
    /// Unit tangents along +u (xyz) and the handedness of the frame (w = ±1): `bitangent = w · n × t`.
    pub tangents: Vec<Vec4>,
    /// Texture coordinates, at most [`MOST_COORDINATE`]; (0, 0) is the *top left* corner of an image, as in glTF.
    pub uvs: Vec<Vec2>,
    /// A second set of texture coordinates, see [`UvSet`]; empty without one.
    pub second_uvs: Vec<Vec2>,
    /// Linear Rec. 709 colors, one per vertex, see [`MaterialOf::vertex_colors`](crate::material::MaterialOf::vertex_colors);
    /// empty for white.
    pub colors: Vec<Vec3>,
    /// Vertex indices, counter-clockwise seen from the outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`](crate::scene::Scene::materials), one per triangle.
    pub triangle_material: Vec<u32>,
    /// Index into [`Scene::objects`](crate::scene::Scene::objects), one per triangle.
    pub triangle_object: Vec<u32>,
    /// Start of the ground under the scene, if there is one; see [`crate::ground`].
    pub ground: Option<GroundStart>,
}

/// Start of the ground in a mesh: its vertices and triangles are the last ones, and nothing else uses them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GroundStart {
    /// Its first vertex.
    pub vertex: u32,
    /// Its first triangle.
    pub triangle: u32,
}

/// Errors that make a mesh unusable. Importers repair or report earlier; a dataset is checked when loaded.
#[derive(Debug, Error, PartialEq)]
pub enum MeshError {
    /// There is nothing to show.
    #[error("the mesh has no triangles; check that the file holds faces and not only points or lines")]
    Empty,
    /// Corresponding arrays differ in length.
    #[error("the mesh has {found} {array} for {expected} {owner}; the file is damaged, export or bake it again")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// The elements it belongs to.
        owner: &'static str,
        /// Its length.
        found: usize,
        /// The expected length.
        expected: usize,
    },
    /// An index points past its array.
    #[error("triangle {triangle} refers to {array} {index}, but there are {count}; export the mesh again")]
    Index {
        /// Index of the triangle.
        triangle: usize,
        /// Name of the array that the index refers to.
        array: &'static str,
        /// The index.
        index: u32,
        /// Number of its elements.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("{array} {index} is not a finite number; repair the mesh in the program that wrote it")]
    NotFinite {
        /// Name of the array.
        array: &'static str,
        /// Index of the element.
        index: usize,
    },
    /// A coordinate is beyond [`MOST_COORDINATE`].
    #[error("{array} {index} is {value:e}, beyond the limit of {MOST_COORDINATE:e}; scale the scene down")]
    TooFar {
        /// Name of the array.
        array: &'static str,
        /// Index of the element.
        index: usize,
        /// The largest of its numbers.
        value: f32,
    },
    /// A normal or tangent is not of unit length.
    #[error("{array} {index} is not of length 1; recalculate it in the program that wrote the mesh")]
    NotUnit {
        /// Name of the array.
        array: &'static str,
        /// Index of the element.
        index: usize,
    },
    /// All vertices are at or near one place.
    #[error("the scene is {diagonal:e} m across, below the limit of {LEAST_DIAGONAL:e} m; scale the scene up")]
    TooSmall {
        /// Diagonal of its bounds in meters.
        diagonal: f32,
    },
    /// All objects are hidden.
    #[error("hidden objects leave nothing to see; show one of them")]
    NothingShown,
    /// Deformed vertices belong to another mesh.
    #[error("object {object} is deformed with {found} vertices and has {expected}; pose the scene as it is now")]
    Deformed {
        /// Index of the object.
        object: u32,
        /// Vertices of the pose.
        found: usize,
        /// Vertices of the object.
        expected: usize,
    },
    /// More objects than can be posed one by one.
    #[error("the scene has {found} objects, and at most {most} can be posed; join some of them")]
    TooManyObjects {
        /// Number of objects.
        found: usize,
        /// The largest number.
        most: usize,
    },
    /// The ground shares vertices with the scene, or has no valid start.
    #[error("the ground of the mesh is not apart from the rest; the file is damaged, bake the scene again")]
    Ground,
}

/// Checks that places are finite, within reach and not all at one place.
///
/// # Errors
/// [`MeshError::NotFinite`], [`MeshError::TooFar`] or [`MeshError::TooSmall`].
pub fn check_extent(positions: impl Iterator<Item = Vec3> + Clone) -> Result<(), MeshError> {
    check_numbers("position", positions.clone().map(|p| size(p.as_ref())))?;
    let diagonal = Bounds::around(positions).diagonal();
    if diagonal >= LEAST_DIAGONAL { Ok(()) } else { Err(MeshError::TooSmall { diagonal }) }
}

/// The largest magnitude of some numbers; NaN if one of them is NaN.
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
    /// For each vertex the first object among its triangles, or `u32::MAX` without triangles.
    pub fn owners(&self) -> Vec<u32> {
        let mut owners = vec![u32::MAX; self.positions.len()];
        for (corners, &object) in self.triangles.iter().zip(&self.triangle_object) {
            for &vertex in corners {
                owners[vertex as usize] = object.min(owners[vertex as usize]);
            }
        }
        owners
    }

    /// Bounds of all vertices except the ground's.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.positions[..self.vertices_of_scene()].iter().copied())
    }

    /// A box around each group of some triangles, in the order of the groups' keys.
    pub fn bounds_by<K: Ord>(
        &self,
        triangles: impl IntoIterator<Item = usize>,
        key: impl Fn(usize) -> K,
    ) -> Vec<Bounds> {
        let mut boxes: BTreeMap<K, Bounds> = BTreeMap::new();
        for triangle in triangles {
            let own = Bounds::around(self.corners(triangle));
            let all = boxes.entry(key(triangle)).or_insert(own);
            *all = Bounds::around([all.min, all.max, own.min, own.max]);
        }
        boxes.into_values().collect()
    }

    /// The three corners of a triangle in meters.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Cross product of two edges: the normal direction, with the length of twice the area.
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

    /// The texture coordinates of a set; the first where there is no second.
    #[inline]
    pub fn uv_set(&self, set: UvSet) -> &[Vec2] {
        if set == UvSet::First || self.second_uvs.is_empty() { &self.uvs } else { &self.second_uvs }
    }

    /// Interpolated attributes of a point of a triangle, by the weights of its corners.
    pub fn attributes(&self, triangle: usize, weights: [f32; 3]) -> SurfaceAttributes {
        let corners = self.triangles[triangle];
        let uv = |set| corners.iter().zip(weights).map(|(&v, w)| self.uv_set(set)[v as usize] * w).sum::<Vec2>().into();
        SurfaceAttributes { uv: [uv(UvSet::First), uv(UvSet::Second)], color: self.color(corners, weights) }
    }

    /// The interpolated color of three vertices; white without colors.
    #[inline]
    pub fn color(&self, corners: [u32; 3], weights: [f32; 3]) -> Vec3 {
        if self.colors.is_empty() {
            return Vec3::ONE;
        }
        corners.iter().zip(weights).map(|(&v, w)| self.colors[v as usize] * w).sum()
    }

    /// The unit shading normal of a surface point, interpolated from the vertices, on the point's side.
    pub fn shading_normal(&self, at: &Surfel) -> Vec3 {
        let MeshPlace { triangle, barycentric: b } = at.place;
        let weights = [1.0 - b.x - b.y, b.x, b.y];
        let weighted = |(&v, w): (&u32, f32)| self.normals[v as usize] * w;
        let smooth: Vec3 = self.triangles[triangle as usize].iter().zip(weights).map(weighted).sum();
        let side = self.area_vector(triangle as usize).dot(at.normal).signum();
        (smooth * side).try_normalize().unwrap_or(at.normal)
    }

    /// Tangent, bitangent and shading normal of a surface point, as columns.
    pub fn frame(&self, at: &Surfel) -> Mat3 {
        let MeshPlace { triangle, barycentric: b } = at.place;
        let corners = self.triangles[triangle as usize];
        let weighted = |(&v, w): (&u32, f32)| self.tangents[v as usize].truncate() * w;
        let tangent = corners.iter().zip([1.0 - b.x - b.y, b.x, b.y]).map(weighted).sum();
        let side = self.area_vector(triangle as usize).dot(at.normal).signum();
        frame_along(self.shading_normal(at), tangent, self.tangents[corners[0] as usize].w * side)
    }

    /// Checks lengths, indices, finiteness, extent and unit directions. `materials` and `objects` are the numbers of
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
        // Those that may be left out.
        let given = |len: usize| if len == 0 { v } else { len };
        for (array, owner, found, expected) in [
            ("normals", "vertices", self.normals.len(), v),
            ("tangents", "vertices", self.tangents.len(), v),
            ("texture coordinates", "vertices", self.uvs.len(), v),
            ("second texture coordinates", "vertices", given(self.second_uvs.len()), v),
            ("colors", "vertices", given(self.colors.len()), v),
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

    /// The ground has its own triangles and vertices, and is not the whole mesh.
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
        check_numbers("texture coordinate", self.uvs.iter().map(|uv| size(uv.as_ref())))?;
        check_numbers("second texture coordinate", self.second_uvs.iter().map(|uv| size(uv.as_ref())))?;
        check_numbers("color", self.colors.iter().map(|color| size(color.as_ref())))
    }

    /// Tangents may be zero where u has no direction.
    fn validate_directions(&self) -> Result<(), MeshError> {
        fn check(array: &'static str, mut unit: impl Iterator<Item = bool>) -> Result<(), MeshError> {
            unit.position(|u| !u).map_or(Ok(()), |index| Err(MeshError::NotUnit { array, index }))
        }
        let longest = 1.0 + UNIT_TOLERANCE;
        let is_tangent = |t: &Vec4| t.w.abs() <= longest && t.truncate().length() <= longest;
        check("normal", self.normals.iter().map(|&n| is_unit(n)))?;
        check("tangent", self.tangents.iter().map(is_tangent))
    }

    /// Number of vertices except the ground's.
    pub fn vertices_of_scene(&self) -> usize {
        self.ground.map_or(self.positions.len(), |start| start.vertex as usize)
    }

    /// Number of triangles except the ground's.
    pub(crate) fn triangles_of_scene(&self) -> usize {
        self.ground.map_or(self.triangles.len(), |start| start.triangle as usize)
    }

    /// Whether a triangle belongs to the ground.
    #[inline]
    pub fn is_ground(&self, triangle: u32) -> bool {
        self.ground.is_some_and(|start| triangle >= start.triangle)
    }

    /// The material of the ground, if there is one.
    pub fn ground_material(&self) -> Option<u32> {
        self.triangle_material.get(self.ground?.triangle as usize).copied()
    }

    /// The object of the ground, if there is one.
    pub fn ground_object(&self) -> Option<u32> {
        self.triangle_object.get(self.ground?.triangle as usize).copied()
    }

    /// Appends a ground: a separate mesh that uses the objects and materials of this one.
    pub fn append_ground(&mut self, ground: Self) {
        let start = GroundStart { vertex: self.positions.len() as u32, triangle: self.triangles.len() as u32 };
        self.positions.extend(ground.positions);
        self.normals.extend(ground.normals);
        self.tangents.extend(ground.tangents);
        if !self.second_uvs.is_empty() {
            self.second_uvs.extend(&ground.uvs);
        }
        if !self.colors.is_empty() {
            self.colors.extend(iter::repeat_n(Vec3::ONE, ground.uvs.len()));
        }
        self.uvs.extend(ground.uvs);
        self.triangles.extend(ground.triangles.into_iter().map(|corners| corners.map(|v| start.vertex + v)));
        self.triangle_material.extend(ground.triangle_material);
        self.triangle_object.extend(ground.triangle_object);
        self.ground = Some(start);
    }

    /// Removes the ground and returns it as a separate mesh.
    pub fn split_off_ground(&mut self) -> Option<Self> {
        let GroundStart { vertex, triangle } = self.ground.take()?;
        let (from_vertex, from_triangle) = (vertex as usize, triangle as usize);
        let triangles = self.triangles.split_off(from_triangle);
        self.second_uvs.truncate(from_vertex);
        self.colors.truncate(from_vertex);
        Some(Self {
            positions: self.positions.split_off(from_vertex),
            normals: self.normals.split_off(from_vertex),
            tangents: self.tangents.split_off(from_vertex),
            uvs: self.uvs.split_off(from_vertex),
            triangles: triangles.into_iter().map(|corners| corners.map(|v| v - vertex)).collect(),
            triangle_material: self.triangle_material.split_off(from_triangle),
            triangle_object: self.triangle_object.split_off(from_triangle),
            ..Self::default()
        })
    }

    /// Moves vertices to one point, so that their triangles have no area. Normals and tangents stay.
    pub(crate) fn collapse(&mut self, vertices: &[u32], to: Vec3) {
        vertices.iter().for_each(|&vertex| self.positions[vertex as usize] = to);
    }

    /// Transforms a vertex by a similarity with this rotation.
    pub(crate) fn turn_vertex(&mut self, vertex: usize, similarity: Affine3A, rotation: Quat) {
        self.positions[vertex] = similarity.transform_point3(self.positions[vertex]);
        self.normals[vertex] = rotation * self.normals[vertex];
        let tangent = self.tangents[vertex];
        self.tangents[vertex] = (rotation * tangent.truncate()).extend(tangent.w);
    }
}
