//! A new glTF file of a scene: its meshes and materials, in world space, without the ground.

use super::{container, original::mime_type};
use crate::export::{
    error::{ExportError, Exported},
    gltf::{compose::Textures, materials::MaterialWriter},
};
use base64::Engine;
use glam::{DVec3, Vec3};
use lapidary_core::{
    output::write_atomically,
    scene::{Mesh, Scene},
};
use serde_json::{Value, json};
use std::{
    collections::{BTreeMap, HashMap},
    path::Path,
};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Writes meshes and materials; a `.gltf` file embeds its data.
pub fn write(scene: &Scene, path: &Path) -> Result<Exported, ExportError> {
    // The ground's material is the last, and no triangle here uses it.
    let count = scene.materials.len();
    let ground = scene.mesh.ground_material().map(|ground| ground as usize);
    let kept = &scene.materials[..ground.filter(|ground| ground + 1 == count).unwrap_or(count)];
    let mut writer = MaterialWriter::new(&scene.textures, Textures::default());
    let materials: Vec<Value> = kept.iter().map(|material| writer.material(material, Value::Null)).collect();
    let mut file = FileWriter::default();
    for (object, parts) in parts(&scene.mesh) {
        let name = scene.objects.get(object as usize).map_or("", |object| &object.name);
        file.add_object(scene, name, parts);
    }
    let images: Vec<Value> = writer
        .textures
        .pictures
        .iter()
        .map(|bytes| json!({"bufferView": file.view(bytes, None), "mimeType": mime_type(bytes)}))
        .collect();
    let is_binary = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
    let mut buffer = json!({"byteLength": file.data.len()});
    if !is_binary {
        let data = base64::engine::general_purpose::STANDARD.encode(&file.data);
        buffer["uri"] = format!("data:application/octet-stream;base64,{data}").into();
    }
    let nodes: Vec<usize> = (0..file.nodes.len()).collect();
    let mut document = json!({
        "asset": {"version": "2.0", "generator": "Lapidary"},
        "scene": 0,
        "scenes": [{"nodes": nodes}],
        "nodes": file.nodes,
        "meshes": file.meshes,
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [buffer],
        "materials": materials,
    });
    if !images.is_empty() {
        document["textures"] = writer.textures.new_textures().into();
        let samplers = writer.textures.new_samplers();
        if !samplers.is_empty() {
            document["samplers"] = samplers.into();
        }
        document["images"] = images.into();
    }
    if !writer.used.is_empty() {
        document["extensionsUsed"] = json!(writer.used);
    }
    let text = document.to_string();
    let bytes = match is_binary {
        true => container::binary(&text, &container::binary_chunk(file.data)),
        false => Ok(text.into_bytes()),
    };
    let bytes = bytes.map_err(|reason| ExportError::text(path, reason))?;
    write_atomically(path, &bytes).map_err(ExportError::write(path))?;
    Ok(Exported { files: vec![path.into()], materials: materials.len(), remarks: writer.remarks })
}

/// Triangles by object, then by material.
fn parts(mesh: &Mesh) -> BTreeMap<u32, BTreeMap<u32, Vec<[u32; 3]>>> {
    let count = mesh.ground.map_or(mesh.triangles.len(), |ground| ground.triangle as usize);
    let mut parts: BTreeMap<u32, BTreeMap<u32, Vec<[u32; 3]>>> = BTreeMap::new();
    for triangle in 0..count {
        let of_object = parts.entry(mesh.triangle_object[triangle]).or_default();
        of_object.entry(mesh.triangle_material[triangle]).or_default().push(mesh.triangles[triangle]);
    }
    parts
}

#[derive(Default)]
struct FileWriter {
    data: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

impl FileWriter {
    /// Adds bytes; returns the index of their view.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.data.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.data.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str, target: u32) -> usize {
        let view = self.view(bytes, Some(target));
        self.accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        self.accessors.len() - 1
    }

    fn add_object(&mut self, scene: &Scene, name: &str, parts: BTreeMap<u32, Vec<[u32; 3]>>) {
        let primitives: Vec<Value> =
            parts.into_iter().map(|(material, triangles)| self.primitive(scene, material, &triangles)).collect();
        let mut node = json!({"name": name, "mesh": self.meshes.len()});
        if scene.origin != DVec3::ZERO {
            // In the double precision of JSON.
            node["translation"] = json!(scene.origin.to_array());
        }
        self.nodes.push(node);
        self.meshes.push(json!({"name": name, "primitives": primitives}));
    }

    fn primitive(&mut self, scene: &Scene, material: u32, triangles: &[[u32; 3]]) -> Value {
        const VERTICES: u32 = 34_962;
        const INDICES: u32 = 34_963;
        let mesh = &scene.mesh;
        let mut own: HashMap<u32, u32> = HashMap::new();
        let mut vertices: Vec<usize> = Vec::new();
        let mut indices: Vec<u32> = Vec::with_capacity(3 * triangles.len());
        for &vertex in triangles.as_flattened() {
            indices.push(*own.entry(vertex).or_insert_with(|| {
                vertices.push(vertex as usize);
                vertices.len() as u32 - 1
            }));
        }
        let of = |array: &[Vec3]| -> Vec<Vec3> { vertices.iter().map(|&v| array[v]).collect() };
        let (positions, normals) = (of(&mesh.positions), of(&mesh.normals));
        let count = vertices.len();
        let position = self.accessor(bytemuck::cast_slice(&positions), FLOAT, count, "VEC3", VERTICES);
        let (low, high) =
            positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
        self.accessors[position]["min"] = json!(low.to_array());
        self.accessors[position]["max"] = json!(high.to_array());
        let normal = self.accessor(bytemuck::cast_slice(&normals), FLOAT, count, "VEC3", VERTICES);
        let mut attributes = json!({"POSITION": position, "NORMAL": normal});
        let sets = [("TEXCOORD_0", &mesh.uvs), ("TEXCOORD_1", &mesh.second_uvs)];
        for (name, uvs) in sets.into_iter().filter(|(_, uvs)| !uvs.is_empty()) {
            let uvs: Vec<_> = vertices.iter().map(|&v| uvs[v]).collect();
            attributes[name] = self.accessor(bytemuck::cast_slice(&uvs), FLOAT, count, "VEC2", VERTICES).into();
        }
        let shows_colors = scene.materials.get(material as usize).is_some_and(|material| material.vertex_colors);
        if shows_colors && !mesh.colors.is_empty() {
            let colors = of(&mesh.colors);
            attributes["COLOR_0"] = self.accessor(bytemuck::cast_slice(&colors), FLOAT, count, "VEC3", VERTICES).into();
        }
        let index = self.accessor(bytemuck::cast_slice(&indices), UNSIGNED_INT, indices.len(), "SCALAR", INDICES);
        json!({
            "attributes": attributes,
            "indices": index,
            "material": material,
        })
    }
}
