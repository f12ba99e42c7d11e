//! Turns the mesh of a file into a clean one: checked, welded, with normals, texture coordinates and tangents.

use super::{polygon::Polygons, tangents};
use crate::import::report::ImportReport;
use glam::{DVec3, Vec2, Vec3, Vec4};
use lapidary_core::{
    bounds::MOST_COORDINATE,
    material::Material,
    mesh::check_extent,
    scene::{Mesh, MeshError},
};
pub(super) use normals::Smoothing;
use normals::smooth_normals;
use rustc_hash::FxHashMap;

mod normals;

/// A triangle has no area if its doubled area is below this fraction of its longest edge squared: `f32` positions
/// cannot express its normal.
const DEGENERATE_RATIO: f64 = 1e-7;

/// A mesh as in a file. All vertex arrays have the same length; missing values are marked, see the fields.
#[derive(Default)]
pub(super) struct RawMesh {
    pub positions: Vec<Vec3>,
    /// Not finite or zero where missing.
    pub normals: Vec<Vec3>,
    /// Not finite where missing.
    pub uvs: Vec<Vec2>,
    /// Zero where missing.
    pub tangents: Vec<Vec4>,
    /// A second set of texture coordinates. May be shorter: the others have the first ones.
    pub second_uvs: Vec<Vec2>,
    /// Linear colors. May be shorter: the others are white.
    pub colors: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub triangle_material: Vec<u32>,
    pub triangle_object: Vec<u32>,
    /// How missing normals of each triangle are rebuilt; empty for all by angle.
    pub triangle_smoothing: Vec<Smoothing>,
}

impl RawMesh {
    /// Marks a missing texture coordinate.
    pub const NO_UV: Vec2 = Vec2::NAN;

    /// Gives the vertices from `base` on a second set of texture coordinates.
    pub fn push_second_uvs(&mut self, base: usize, uvs: impl IntoIterator<Item = Vec2>) {
        self.second_uvs.resize(base, Self::NO_UV);
        self.second_uvs.extend(uvs);
    }

    /// Gives the vertices from `base` on colors. Returns whether these are not all white.
    pub fn push_colors(&mut self, base: usize, colors: &[Vec3]) -> bool {
        let is_colored = colors.iter().any(|color| *color != Vec3::ONE);
        if is_colored {
            self.colors.resize(base, Vec3::ONE);
            self.colors.extend(colors.iter().map(|color| color.clamp(Vec3::ZERO, Vec3::ONE)));
        }
        is_colored
    }

    /// Adds a triangle of vertices relative to `base`; an index past `u32` stays out of range.
    pub fn push_triangle(&mut self, base: usize, corners: [u32; 3], material: u32, object: u32) {
        self.triangles.push(corners.map(|c| u32::try_from(base + c as usize).unwrap_or(u32::MAX)));
        self.triangle_material.push(material);
        self.triangle_object.push(object);
    }

    /// Adds the triangles of a polygon of vertices relative to `base`, which has all of them.
    pub fn push_polygon(&mut self, base: usize, corners: &[u32], material: u32, object: u32, polygons: &mut Polygons) {
        let triangles = polygons.split(corners, &self.positions[base..]);
        triangles.for_each(|corners| self.push_triangle(base, corners, material, object));
    }

    fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Unit normal of a triangle, computed in double precision.
    fn face_normal(&self, triangle: usize) -> Vec3 {
        area_vector(self.corners(triangle)).normalize_or_zero().as_vec3()
    }

    /// Keeps the triangles with a set flag.
    fn retain_triangles(&mut self, keep: &[bool]) {
        fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
            let mut keep = keep.iter();
            items.retain(|_| *keep.next().expect("one flag per triangle"));
        }
        retain(&mut self.triangles, keep);
        retain(&mut self.triangle_material, keep);
        retain(&mut self.triangle_object, keep);
        if !self.triangle_smoothing.is_empty() {
            retain(&mut self.triangle_smoothing, keep);
        }
    }
}

fn area_vector([a, b, c]: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}

/// Makes a clean mesh, with tangents along the coordinates of its materials' normal maps, and counts the repairs in `report`.
///
/// # Errors
/// No triangles with an area, positions that are not finite or too far or in one place, indices out of range.
pub(super) fn repair(mut raw: RawMesh, materials: &[Material], report: &mut ImportReport) -> Result<Mesh, MeshError> {
    check(&raw)?;
    let referenced = count_referenced(&raw);
    report.unreferenced_vertices = raw.positions.len() - referenced;
    drop_degenerate(&mut raw, report);
    if raw.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    mark_invalid_attributes(&mut raw);
    turn_flipped_triangles(&mut raw, report);
    let referenced = count_referenced(&raw);
    let (mut mesh, has_uv) = weld(&raw, report);
    tangents::complete(&mut mesh, &has_uv, materials, report);
    report.welded_vertices = referenced.saturating_sub(mesh.positions.len());
    report.split_vertices = mesh.positions.len().saturating_sub(referenced);
    (report.vertices, report.triangles) = (mesh.positions.len(), mesh.triangles.len());
    Ok(mesh)
}

fn check(raw: &RawMesh) -> Result<(), MeshError> {
    if raw.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    if let Some(index) = raw.positions.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NotFinite { array: "position", index });
    }
    let count = raw.positions.len();
    for (triangle, corners) in raw.triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&v| v as usize >= count) {
            return Err(MeshError::Index { triangle, array: "vertex", index, count });
        }
    }
    // An unused vertex is dropped, and may be anywhere.
    let (referenced, anywhere) = (referenced(raw), raw.triangles[0][0] as usize);
    check_extent((0..count).map(|v| raw.positions[if referenced[v] { v } else { anywhere }]))
}

/// Flags of the vertices that triangles use.
fn referenced(raw: &RawMesh) -> Vec<bool> {
    let mut referenced = vec![false; raw.positions.len()];
    raw.triangles.iter().flatten().for_each(|&v| referenced[v as usize] = true);
    referenced
}

fn count_referenced(raw: &RawMesh) -> usize {
    referenced(raw).iter().filter(|r| **r).count()
}

fn drop_degenerate(raw: &mut RawMesh, report: &mut ImportReport) {
    let has_area = |corners: [Vec3; 3]| {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let longest_sq = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        area_vector(corners).length() > DEGENERATE_RATIO * longest_sq
    };
    let keep: Vec<bool> = (0..raw.triangles.len()).map(|t| has_area(raw.corners(t))).collect();
    report.degenerate_triangles = keep.iter().filter(|k| !**k).count();
    if report.degenerate_triangles > 0 {
        raw.retain_triangles(&keep);
    }
}

/// Normalizes normals and tangents. Marks null ones, and invalid texture coordinates, as missing.
fn mark_invalid_attributes(raw: &mut RawMesh) {
    for normal in &mut raw.normals {
        // Nearly unit normals stay unchanged, so that equal ones stay equal.
        let is_unit = (normal.length_squared() - 1.0).abs() < 1e-6;
        if !is_unit {
            *normal = normal.as_dvec3().normalize_or_zero().as_vec3();
        }
    }
    for uv in
        raw.uvs.iter_mut().chain(&mut raw.second_uvs).filter(|uv| !uv.abs().cmple(Vec2::splat(MOST_COORDINATE)).all())
    {
        *uv = RawMesh::NO_UV;
    }
    for color in raw.colors.iter_mut().filter(|color| !color.is_finite()) {
        *color = Vec3::ONE;
    }
    for tangent in &mut raw.tangents {
        let direction = tangent.truncate().normalize_or_zero();
        let sign = if tangent.w < 0.0 { -1.0 } else { 1.0 };
        *tangent = if direction == Vec3::ZERO { Vec4::ZERO } else { direction.extend(sign) };
    }
}

/// Reverses triangles whose stored normals are all on their back: programs shade by the normals, so a wrong winding
/// goes unnoticed in them. Triangles with normals on both sides are slivers of a curved surface and stay.
fn turn_flipped_triangles(raw: &mut RawMesh, report: &mut ImportReport) {
    for t in 0..raw.triangles.len() {
        let face = raw.face_normal(t);
        if raw.triangles[t].iter().all(|&v| raw.normals[v as usize].dot(face) < 0.0) {
            raw.triangles[t].swap(1, 2);
            report.flipped_triangles += 1;
        }
    }
    if report.flipped_triangles > 0 {
        report.warnings.push(format!(
            "{} of {} triangles were wound against their normals and were turned around; \
             if a surface now looks inside out, recalculate its normals in the modelling program",
            report.flipped_triangles,
            raw.triangles.len()
        ));
    }
}

/// All attributes of a vertex as bits, and its object: vertices with equal keys are merged.
type VertexKey = [u32; 18];

fn bits<const N: usize>(values: [f32; N]) -> [u32; N] {
    values.map(|x| (x + 0.0).to_bits()) // adding zero makes -0 and 0 agree
}

/// All attributes of a vertex.
struct Attributes {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    tangent: Vec4,
    second_uv: Vec2,
    color: Vec3,
}

impl Attributes {
    fn key(&self, object: u32) -> VertexKey {
        let mut key = [object; 18];
        key[1..4].copy_from_slice(&bits(self.position.to_array()));
        key[4..7].copy_from_slice(&bits(self.normal.to_array()));
        key[7..9].copy_from_slice(&bits(self.uv.to_array()));
        key[9..13].copy_from_slice(&bits(self.tangent.to_array()));
        key[13..15].copy_from_slice(&bits(self.second_uv.to_array()));
        key[15..18].copy_from_slice(&bits(self.color.to_array()));
        key
    }
}

/// Gives every corner its normal and texture coordinates, and merges corners with equal attributes into vertices. Also
/// returns the flags of vertices with texture coordinates from the file.
fn weld(raw: &RawMesh, report: &mut ImportReport) -> (Mesh, Vec<bool>) {
    let rebuilt =
        (raw.triangles.iter().flatten().any(|&v| raw.normals[v as usize] == Vec3::ZERO)).then(|| smooth_normals(raw));
    let mut welder = Welder::new(raw);
    let mut triangles = Vec::with_capacity(raw.triangles.len());
    for (t, corners) in raw.triangles.iter().enumerate() {
        let vertex = |k: usize| {
            let stored = raw.normals[corners[k] as usize] != Vec3::ZERO;
            let normal = (!stored).then(|| rebuilt.as_ref().map_or(Vec3::Y, |r| r[t][k]));
            welder.vertex(corners[k], raw.triangle_object[t], normal)
        };
        triangles.push([0, 1, 2].map(vertex));
    }
    report.normals_rebuilt = welder.normals_rebuilt;
    let mut mesh = welder.mesh;
    report.uvs_projected = welder.has_uv.iter().filter(|has| !**has).count();
    mesh.triangles = triangles;
    mesh.triangle_material = raw.triangle_material.clone();
    mesh.triangle_object = raw.triangle_object.clone();
    (mesh, welder.has_uv)
}

struct Welder<'a> {
    raw: &'a RawMesh,
    mesh: Mesh,
    /// Whether the file had texture coordinates, per vertex of `mesh`.
    has_uv: Vec<bool>,
    normals_rebuilt: usize,
    by_key: FxHashMap<VertexKey, u32>,
    /// The object and the new index of raw vertices with stored normals; most corners end here.
    by_raw_vertex: Vec<Option<(u32, u32)>>,
}

impl<'a> Welder<'a> {
    fn new(raw: &'a RawMesh) -> Self {
        let by_raw_vertex = vec![None; raw.positions.len()];
        let (has_uv, by_key) = (Vec::new(), FxHashMap::default());
        Self { raw, mesh: Mesh::default(), has_uv, normals_rebuilt: 0, by_key, by_raw_vertex }
    }

    /// The new index of a corner at raw vertex `v`; `rebuilt` is its normal if the file has none.
    fn vertex(&mut self, v: u32, object: u32, rebuilt: Option<Vec3>) -> u32 {
        match self.by_raw_vertex[v as usize] {
            Some((known_object, index)) if known_object == object && rebuilt.is_none() => index,
            _ => {
                let index = self.add(v as usize, object, rebuilt);
                self.by_raw_vertex[v as usize] = rebuilt.is_none().then_some((object, index));
                index
            }
        }
    }

    fn add(&mut self, v: usize, object: u32, rebuilt: Option<Vec3>) -> u32 {
        let (raw, mesh) = (self.raw, &mut self.mesh);
        let (position, normal) = (raw.positions[v], rebuilt.unwrap_or(raw.normals[v]));
        let has_uv = !raw.uvs[v].is_nan();
        let (uv, tangent) = if has_uv { (raw.uvs[v], raw.tangents[v]) } else { box_projection(position, normal) };
        let second_uv = raw.second_uvs.get(v).copied().filter(|uv| !uv.is_nan()).unwrap_or(uv);
        let color = raw.colors.get(v).copied().unwrap_or(Vec3::ONE);
        let next = mesh.positions.len() as u32;
        let key = Attributes { position, normal, uv, tangent, second_uv, color }.key(object);
        let index = *self.by_key.entry(key).or_insert(next);
        if index == next {
            mesh.positions.push(position);
            mesh.normals.push(normal);
            mesh.uvs.push(uv);
            mesh.tangents.push(tangent);
            if !raw.second_uvs.is_empty() {
                mesh.second_uvs.push(second_uv);
            }
            if !raw.colors.is_empty() {
                mesh.colors.push(color);
            }
            self.has_uv.push(has_uv);
            self.normals_rebuilt += usize::from(rebuilt.is_some());
        }
        index
    }
}

/// Texture coordinates of one unit per meter, projected along the axis nearest to the normal, with their tangent.
/// Chosen by vertex and not by face, so no vertex is split; triangles across two axes are stretched.
fn box_projection(p: Vec3, normal: Vec3) -> (Vec2, Vec4) {
    let size = normal.abs();
    let (uv, axis) = if size.y >= size.x && size.y >= size.z {
        (Vec2::new(p.x, p.z * normal.y.signum()), Vec3::X)
    } else if size.x >= size.z {
        (Vec2::new(-p.z * normal.x.signum(), -p.y), -Vec3::Z * normal.x.signum())
    } else {
        (Vec2::new(p.x * normal.z.signum(), -p.y), Vec3::X * normal.z.signum())
    };
    let tangent = (axis - normal * normal.dot(axis)).normalize_or(normal.any_orthonormal_vector());
    (uv, tangent.extend(1.0))
}
