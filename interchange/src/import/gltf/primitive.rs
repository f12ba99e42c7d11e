//! Primitives of a glTF mesh: vertices and triangles.

use super::buffers::Buffers;
use crate::import::{repair::RawMesh, source::Source};
use glam::{Vec2, Vec3};
use gltf::mesh::Mode;
use lapidary_core::{
    animation::{
        shape::{Deformation, Posture},
        surface::Surface,
    },
    parts::Part,
    scene::MeshError,
};

/// The attributes of a primitive in its own space, and its triangles.
pub(super) struct Primitive {
    pub surface: Surface,
    uvs: Vec<Vec2>,
    second_uvs: Option<Vec<Vec2>>,
    colors: Option<Vec<Vec3>>,
    /// Whether the colors of its vertices have an alpha below 1.
    pub has_alpha: bool,
    pub triangles: Vec<[u32; 3]>,
}

impl Primitive {
    pub fn read(primitive: &gltf::Primitive, buffers: &Buffers) -> Result<Self, String> {
        let positions = buffers.positions(primitive)?;
        let count = positions.len();
        let indices = buffers.indices(primitive)?.unwrap_or_else(|| (0..count as u32).collect());
        let (normals, tangents) = (buffers.normals(primitive, count)?, buffers.tangents(primitive, count)?);
        let (colors, has_alpha) = buffers.colors(primitive, count)?.unzip();
        Ok(Self {
            uvs: buffers.uvs(primitive, 0, count)?.unwrap_or_else(|| vec![RawMesh::NO_UV; count]),
            second_uvs: buffers.uvs(primitive, 1, count)?,
            colors,
            has_alpha: has_alpha.unwrap_or_default(),
            triangles: triangles(primitive.mode(), &indices),
            surface: Surface { positions, normals, tangents },
        })
    }

    /// Checks that positions are finite and that triangles refer to vertices.
    pub fn check(&self) -> Result<(), MeshError> {
        let count = self.surface.positions.len();
        if let Some(index) = self.surface.positions.iter().position(|place| !place.is_finite()) {
            return Err(MeshError::NotFinite { array: "position", index });
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&c| c as usize >= count) {
                return Err(MeshError::Index { triangle, array: "vertex", index, count });
            }
        }
        Ok(())
    }

    /// Whether its vertices have other colors than white.
    pub fn is_colored(&self) -> bool {
        self.colors.iter().flatten().any(|color| *color != Vec3::ONE)
    }

    /// Adds the primitive of a node, transformed to the world. If that mirrors it, the triangles are reversed.
    pub fn add_to(
        mut self,
        source: &mut Source,
        deformation: &Deformation,
        node: usize,
        posture: &Posture,
        Part { object, material }: Part,
    ) {
        let is_mirrored = deformation.place(&mut self.surface, node, posture);
        let raw = &mut source.mesh;
        let base = raw.positions.len();
        raw.positions.extend(self.surface.positions);
        raw.normals.extend(self.surface.normals);
        raw.tangents.extend(self.surface.tangents);
        raw.uvs.extend(self.uvs);
        if let Some(uvs) = self.second_uvs {
            raw.push_second_uvs(base, uvs);
        }
        if let Some(colors) = self.colors {
            raw.push_colors(base, &colors);
        }
        for [a, b, c] in self.triangles {
            raw.push_triangle(base, if is_mirrored { [a, c, b] } else { [a, b, c] }, material, object);
        }
    }
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            indices.get(1..).unwrap_or_default().windows(2).map(|w| [w[0], w[1], indices[0]]).collect()
        }
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

/// Whether it has triangles, not points or lines.
pub(super) fn is_surface(mode: Mode) -> bool {
    matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}
