//! Triangles by material and side, as binary PLY files.

use super::{bsdf, xml};
use lapidary_core::{dataset::Dataset, scene::Mesh};
use std::collections::{BTreeMap, HashMap};

/// Triangles of one material that reflect on one or on both sides.
pub struct Part {
    /// Index of the material.
    pub material: u32,
    /// Whether both sides reflect, which is decided triangle by triangle when a scene is baked.
    pub two_sided: bool,
    /// Indices of the triangles.
    pub triangles: Vec<usize>,
}

/// All triangles of a dataset.
pub fn parts(dataset: &Dataset) -> Vec<Part> {
    let mut parts: BTreeMap<(u32, bool), Vec<usize>> = BTreeMap::new();
    for (triangle, &material) in dataset.scene.mesh.triangle_material.iter().enumerate() {
        parts.entry((material, dataset.two_sided[triangle])).or_default().push(triangle);
    }
    parts.into_iter().map(|((material, two_sided), triangles)| Part { material, two_sided, triangles }).collect()
}

impl Part {
    /// Path of the mesh in the exported folder.
    pub fn file(&self) -> String {
        format!("meshes/{}.ply", bsdf::id(self.material, self.two_sided))
    }

    /// The element of the scene that shows it.
    pub fn shape(&self) -> String {
        let properties =
            xml::value("string", "filename", self.file()) + &xml::reference(&bsdf::id(self.material, self.two_sided));
        xml::plugin("shape", "ply", "", &properties)
    }

    /// Positions, normals, texture coordinates and triangles, little endian. Texture coordinates begin at the top left
    /// corner of a picture in both programs.
    pub fn ply(&self, mesh: &Mesh) -> Vec<u8> {
        let mut vertices = Vec::new();
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        let mut faces = Vec::with_capacity(13 * self.triangles.len());
        for &triangle in &self.triangles {
            faces.push(3);
            for vertex in mesh.triangles[triangle] {
                let number = *numbers.entry(vertex).or_insert_with(|| {
                    vertices.push(vertex as usize);
                    vertices.len() as u32 - 1
                });
                faces.extend(number.to_le_bytes());
            }
        }
        let mut bytes = header(vertices.len(), self.triangles.len()).into_bytes();
        for v in vertices {
            let place = [mesh.positions[v].to_array(), mesh.normals[v].to_array()].concat();
            let numbers = place.into_iter().chain(mesh.uvs[v].to_array());
            bytes.extend(numbers.flat_map(f32::to_le_bytes));
        }
        bytes.extend(faces);
        bytes
    }
}

fn header(vertices: usize, faces: usize) -> String {
    let properties: String =
        ["x", "y", "z", "nx", "ny", "nz", "u", "v"].map(|p| format!("property float {p}\n")).concat();
    format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\n{properties}\
         element face {faces}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
}
