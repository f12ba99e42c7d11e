//! A glTF file that a test writes.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Parts of the file; the buffer is embedded.
pub struct TestFile {
    pub json: Value,
    bytes: Vec<u8>,
    folder: tempfile::TempDir,
}

impl TestFile {
    /// A file with nodes; the first `roots` are in the scene.
    pub fn new(nodes: Value, roots: usize) -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": (0..roots).collect::<Vec<_>>() }],
            "nodes": nodes, "meshes": [], "accessors": [], "bufferViews": [],
        });
        Self { json, bytes: Vec::new(), folder: tempfile::tempdir().unwrap() }
    }

    /// Adds an accessor of floats.
    pub fn floats(&mut self, numbers: &[f32], kind: &str) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, numbers.len() / width(kind), kind)
    }

    /// Adds an accessor of two-byte integers.
    pub fn shorts(&mut self, numbers: &[u16], kind: &str) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5123, numbers.len() / width(kind), kind)
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        let (views, accessors) = (list(&mut self.json, "bufferViews").len(), list(&mut self.json, "accessors").len());
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        list(&mut self.json, "bufferViews").push(view);
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let accessor = json!({ "bufferView": views, "componentType": component, "count": count, "type": kind });
        list(&mut self.json, "accessors").push(accessor);
        accessors
    }

    /// Adds a mesh of triangles, and its other attributes by name.
    pub fn mesh(&mut self, positions: &[f32], indices: &[u16], attributes: &[(&str, usize)]) -> usize {
        let position = self.floats(positions, "VEC3");
        let corner = |k: usize, pick: fn(f32, f32) -> f32| {
            positions.iter().skip(k).step_by(3).copied().reduce(pick).unwrap_or_default()
        };
        self.json["accessors"][position]["min"] = json!([0, 1, 2].map(|k| corner(k, f32::min)));
        self.json["accessors"][position]["max"] = json!([0, 1, 2].map(|k| corner(k, f32::max)));
        let indices = self.shorts(indices, "SCALAR");
        let mut primitive = json!({ "attributes": { "POSITION": position }, "indices": indices });
        attributes.iter().for_each(|(name, accessor)| primitive["attributes"][name] = json!(accessor));
        list(&mut self.json, "meshes").push(json!({ "primitives": [primitive] }));
        list(&mut self.json, "meshes").len() - 1
    }

    /// Adds a skin of joints with inverse bind matrices that translate by `shifts`.
    pub fn skin(&mut self, joints: &[usize], shifts: &[[f32; 3]]) {
        let matrix = |[x, y, z]: [f32; 3]| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, y, z, 1.];
        let matrices: Vec<f32> = shifts.iter().flat_map(|shift| matrix(*shift)).collect();
        let accessor = self.floats(&matrices, "MAT4");
        list(&mut self.json, "skins").push(json!({ "joints": joints, "inverseBindMatrices": accessor }));
    }

    /// Adds a clip of one channel.
    pub fn clip(&mut self, name: &str, node: usize, path: &str, times: &[f32], values: &[f32], interpolation: &str) {
        let kind = match path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let (input, output) = (self.floats(times, "SCALAR"), self.floats(values, kind));
        list(&mut self.json, "animations").push(json!({
            "name": name,
            "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
            "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
        }));
    }

    /// Writes the file and returns its path.
    pub fn write(&mut self) -> PathBuf {
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
        self.json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        let path = self.folder.path().join("moving.gltf");
        std::fs::write(&path, self.json.to_string()).unwrap();
        path
    }
}

fn width(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 16,
    }
}

fn list<'a>(json: &'a mut Value, name: &str) -> &'a mut Vec<Value> {
    if json[name].is_null() {
        json[name] = json!([]);
    }
    json[name].as_array_mut().unwrap()
}
