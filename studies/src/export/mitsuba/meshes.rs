//! Triangles by material and side, as binary PLY files.
//!
//! A Mitsuba emitter shines only on the side of its normal. Triangles that shine on both sides become two meshes, each slightly in
//! front of its own side, so that a ray hits the one that shines toward it.

use super::{bsdf, xml};
use lapidary_core::{dataset::Dataset, scene::Mesh};
use std::collections::{BTreeMap, HashMap};

/// Offset of such a mesh, relative to its largest coordinate: 80 steps of 32-bit floats.
const LIFT: f32 = 1e-5;

/// The side of its triangles that a mesh shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// All reflecting sides.
    All,
    /// The side of the normal.
    Front,
    /// The opposite side.
    Back,
}

/// Triangles of one material that reflect on one or on both sides.
pub struct Part {
    /// Index of the material.
    pub material: u32,
    /// Whether both sides reflect; the bake decides this for each triangle.
    pub two_sided: bool,
    /// The side that the mesh shows.
    pub face: Face,
    /// Indices of the triangles.
    pub triangles: Vec<usize>,
}

/// All triangles of a dataset but those of hidden objects, twice for those that `shine` on both sides.
pub fn parts(dataset: &Dataset, shines: impl Fn(u32) -> bool) -> Vec<Part> {
    let mut parts: BTreeMap<(u32, bool), Vec<usize>> = BTreeMap::new();
    for (triangle, &material) in dataset.scene.mesh.triangle_material.iter().enumerate() {
        let [a, b, c] = dataset.scene.mesh.corners(triangle);
        if a != b || b != c {
            parts.entry((material, dataset.two_sided[triangle])).or_default().push(triangle);
        }
    }
    let faces = |material, two_sided| match two_sided && shines(material) {
        true => &[Face::Front, Face::Back][..],
        false => &[Face::All],
    };
    parts
        .into_iter()
        .flat_map(|((material, two_sided), triangles)| {
            let part = move |&face| Part { material, two_sided, face, triangles: triangles.clone() };
            faces(material, two_sided).iter().map(part)
        })
        .collect()
}

impl Part {
    /// Path of the mesh in the exported folder.
    pub fn file(&self) -> String {
        let face = match self.face {
            Face::All => "",
            Face::Front => "-front",
            Face::Back => "-back",
        };
        format!("meshes/{}{face}.ply", bsdf::id(self.material, self.two_sided))
    }

    /// The scene element of the mesh, with its `emitter` if any.
    pub fn shape(&self, emitter: &str) -> String {
        let properties =
            xml::value("string", "filename", self.file()) + &xml::reference(&bsdf::id(self.material, self.two_sided));
        xml::plugin("shape", "ply", "", &(properties + emitter))
    }

    /// Offset in meters from the triangles along their normals.
    fn lift(&self, mesh: &Mesh) -> f32 {
        let corners = self.triangles.iter().flat_map(|&triangle| mesh.corners(triangle));
        let largest = corners.fold(0.0, |largest: f32, corner| largest.max(corner.abs().max_element()));
        match self.face {
            Face::All => 0.0,
            Face::Front => LIFT * largest,
            Face::Back => -LIFT * largest,
        }
    }

    /// Positions, normals, texture coordinates and triangles, little endian. In both programs texture coordinates start at the top
    /// left corner of a picture.
    pub fn ply(&self, mesh: &Mesh) -> Vec<u8> {
        let lift = self.lift(mesh);
        let is_back = self.face == Face::Back;
        let mut vertices = Vec::new();
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        let mut faces = Vec::with_capacity(13 * self.triangles.len());
        for &triangle in &self.triangles {
            faces.push(3);
            let mut corners = mesh.triangles[triangle];
            if is_back {
                corners.reverse();
            }
            for vertex in corners {
                let number = *numbers.entry(vertex).or_insert_with(|| {
                    vertices.push(vertex as usize);
                    vertices.len() as u32 - 1
                });
                faces.extend(number.to_le_bytes());
            }
        }
        let mut bytes = header(vertices.len(), self.triangles.len()).into_bytes();
        for v in vertices {
            let place = mesh.positions[v] + lift * mesh.normals[v];
            let normal = if is_back { -mesh.normals[v] } else { mesh.normals[v] };
            let numbers = place.to_array().into_iter().chain(normal.to_array()).chain(mesh.uvs[v].to_array());
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
