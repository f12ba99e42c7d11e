//! Objects whose vertices move individually, by a skin or a morph target.

use crate::mesh::{Mesh, MeshError};
use glam::{Affine3A, Quat, Vec3, Vec4};
use std::sync::Arc;

/// The vertices of an object, in the order of [`Objects::vertices`](super::Objects::vertices).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosedVertices {
    /// Positions in meters, within reach.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Tangents with the handedness of their frames.
    pub tangents: Vec<Vec4>,
}

impl PosedVertices {
    /// Transforms the vertices by a similarity with this rotation.
    pub(crate) fn turned(mut self, similarity: Affine3A, rotation: Quat) -> Self {
        self.positions.iter_mut().for_each(|position| *position = similarity.transform_point3(*position));
        self.normals.iter_mut().for_each(|normal| *normal = rotation * *normal);
        self.tangents.iter_mut().for_each(|tangent| *tangent = (rotation * tangent.truncate()).extend(tangent.w));
        self
    }
}

/// A deformed object. Copies and comparisons are cheap: equal revisions mean equal vertices.
#[derive(Clone, Debug)]
pub struct DeformedObject {
    vertices: Arc<PosedVertices>,
    revision: [u32; 3],
}

impl DeformedObject {
    /// Creates an object from vertices. `revision` identifies their maker and its inputs: equal revisions mean equal vertices.
    pub fn new(vertices: PosedVertices, revision: [u32; 3]) -> Self {
        Self { vertices: vertices.into(), revision }
    }

    /// An object with the present vertices of a mesh.
    pub(crate) fn of_mesh(mesh: &Mesh, vertices: &[u32]) -> Self {
        let mut of = PosedVertices::default();
        for vertex in vertices.iter().map(|&vertex| vertex as usize) {
            of.positions.push(mesh.positions[vertex]);
            of.normals.push(mesh.normals[vertex]);
            of.tangents.push(mesh.tangents[vertex]);
        }
        let hash = *blake3::hash(bytemuck::cast_slice(&of.positions)).as_bytes();
        let word = |i: usize| u32::from_le_bytes([hash[i], hash[i + 1], hash[i + 2], hash[i + 3]]);
        Self::new(of, [word(0), word(4), word(8)])
    }

    /// Puts its vertices into a mesh.
    pub(super) fn put(&self, mesh: &mut Mesh, object: u32, vertices: &[u32]) -> Result<(), MeshError> {
        let PosedVertices { positions, normals, tangents } = self.vertices();
        let (found, expected) = (positions.len(), vertices.len());
        if found != expected {
            return Err(MeshError::Deformed { object, found, expected });
        }
        for (k, vertex) in vertices.iter().map(|&vertex| vertex as usize).enumerate() {
            (mesh.positions[vertex], mesh.normals[vertex], mesh.tangents[vertex]) =
                (positions[k], normals[k], tangents[k]);
        }
        Ok(())
    }

    /// Its vertices.
    pub fn vertices(&self) -> &PosedVertices {
        &self.vertices
    }
}

impl PartialEq for DeformedObject {
    fn eq(&self, other: &Self) -> bool {
        self.revision == other.revision
    }
}
