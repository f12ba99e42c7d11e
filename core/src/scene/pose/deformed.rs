//! Objects whose vertices move individually, by a skin or a morph target.

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
