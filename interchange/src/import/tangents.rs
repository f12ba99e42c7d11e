//! Computes missing tangents: by MikkTSpace from texture coordinates, like the programs that bake normal maps.

use crate::import::report::ImportReport;
use bevy_mikktspace::{Geometry, TangentSpace};
use glam::{Vec3, Vec4};
use lapidary_core::{
    material::{Material, NORMAL},
    scene::Mesh,
    texture::UvSet,
};

/// Fills in all zero tangents, along the coordinates of the materials' normal maps. `has_uv` marks the vertices with texture
/// coordinates from the file. A vertex is split where mirrored texture coordinates meet; otherwise the tangents of its corners are
/// averaged.
pub(super) fn complete(mesh: &mut Mesh, has_uv: &[bool], materials: &[Material], report: &mut ImportReport) {
    let missing = |v: u32| mesh.tangents[v as usize] == Vec4::ZERO;
    let from_file = |v: usize| has_uv[v] && !missing(v as u32);
    report.tangents_rebuilt = (0..mesh.tangents.len()).filter(|v| !from_file(*v)).count();
    let usable = |t: &usize| {
        let corners = mesh.triangles[*t];
        corners.iter().all(|&v| has_uv[v as usize]) && corners.iter().any(|&v| missing(v))
    };
    let faces: Vec<usize> = (0..mesh.triangles.len()).filter(usable).collect();
    if !faces.is_empty() {
        let normals =
            materials.iter().map(|material| material.maps.get(NORMAL).map_or(UvSet::First, |slot| slot.uv_set));
        let sets = normals.collect();
        let mut geometry = Faces { mesh, tangents: vec![[Vec4::ZERO; 3]; faces.len()], sets, faces };
        // Its error has no variant yet; unset tangents stay zero and are filled in below.
        bevy_mikktspace::generate_tangents(&mut geometry).ok();
        let Faces { faces, tangents, .. } = geometry;
        apply(mesh, &faces, &tangents);
    }
    for (tangent, normal) in mesh.tangents.iter_mut().zip(&mesh.normals) {
        if *tangent == Vec4::ZERO {
            *tangent = normal.any_orthonormal_vector().extend(1.0);
        }
    }
}

/// The triangles whose tangents are computed, and the results.
struct Faces<'a> {
    mesh: &'a Mesh,
    faces: Vec<usize>,
    /// The coordinates of each material's normal map.
    sets: Vec<UvSet>,
    tangents: Vec<[Vec4; 3]>,
}

impl Faces<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[self.faces[face]][corner] as usize
    }
}

impl Geometry for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].to_array()
    }

    /// MikkTSpace has v upward; with ours, downward, the bitangent of a normal map would point down.
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let material = self.mesh.triangle_material[self.faces[face]] as usize;
        let set = self.sets.get(material).copied().unwrap_or_default();
        let uv = self.mesh.uv_set(set)[self.vertex(face, corner)];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[face][corner] = space.map_or(Vec4::ZERO, |s| Vec4::from_array(s.tangent_encoded()));
    }
}

/// Averages corner tangents into vertices without one, separately by handedness.
fn apply(mesh: &mut Mesh, faces: &[usize], tangents: &[[Vec4; 3]]) {
    let mut sums = [vec![Vec3::ZERO; mesh.positions.len()], vec![Vec3::ZERO; mesh.positions.len()]];
    let mirrored = |tangent: Vec4| usize::from(tangent.w < 0.0);
    let mut corners = Vec::new();
    for (face, tangents) in faces.iter().zip(tangents) {
        for (k, tangent) in tangents.iter().enumerate() {
            let v = mesh.triangles[*face][k] as usize;
            if mesh.tangents[v] == Vec4::ZERO && tangent.is_finite() && *tangent != Vec4::ZERO {
                sums[mirrored(*tangent)][v] += tangent.truncate();
                corners.push((*face, k, mirrored(*tangent)));
            }
        }
    }
    let clones = split_mirrored(mesh, &sums);
    for (face, k, side) in corners {
        let v = mesh.triangles[face][k];
        if side == 1 && clones[v as usize] != v {
            mesh.triangles[face][k] = clones[v as usize];
        }
    }
}

/// Writes the tangents, and duplicates the vertices that need both hands. Returns the mirrored vertex of each.
fn split_mirrored(mesh: &mut Mesh, sums: &[Vec<Vec3>; 2]) -> Vec<u32> {
    let count = mesh.positions.len();
    let mut clones: Vec<u32> = (0..count as u32).collect();
    for v in 0..count {
        let tangent = |side: usize| orthogonal_unit(sums[side][v], mesh.normals[v]);
        match (tangent(0), tangent(1)) {
            (Some(t), None) => mesh.tangents[v] = t.extend(1.0),
            (None, Some(t)) => mesh.tangents[v] = t.extend(-1.0),
            (Some(t), Some(m)) => {
                mesh.tangents[v] = t.extend(1.0);
                clones[v] = mesh.positions.len() as u32;
                mesh.positions.push(mesh.positions[v]);
                mesh.normals.push(mesh.normals[v]);
                mesh.uvs.push(mesh.uvs[v]);
                let copied = |len: usize| (len > 0).then_some(v);
                mesh.second_uvs.extend(copied(mesh.second_uvs.len()).map(|v| mesh.second_uvs[v]));
                mesh.colors.extend(copied(mesh.colors.len()).map(|v| mesh.colors[v]));
                mesh.tangents.push(m.extend(-1.0));
            }
            (None, None) => {}
        }
    }
    clones
}

fn orthogonal_unit(tangent: Vec3, normal: Vec3) -> Option<Vec3> {
    (tangent - normal * normal.dot(tangent)).try_normalize()
}
