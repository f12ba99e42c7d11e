//! Writes a scene as glTF 2.0: one `.gltf`, one `.bin`, textures by file name.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use glam::{Affine3A, Mat3, Quat, Vec3};
use serde_json::{Map, Value, json};

use crate::mesh::Mesh;
use crate::scene::{Material, PunctualLight, Scene};

mod motion;

/// glTF component types and buffer targets.
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Extension for local lights.
const LIGHTS: &str = "KHR_lights_punctual";

/// Writes `NAME.gltf` and `NAME.bin` into `folder`.
pub fn write(scene: &Scene, folder: &Path) -> Result<()> {
    let mut file = Writer::default();
    let materials: Vec<Value> = scene.materials.iter().map(|m| file.material(m)).collect();
    let mut meshes = scene.pieces.iter().map(|piece| file.mesh(scene, piece)).collect::<Result<Vec<Value>>>()?;
    let (mut nodes, cameras) = nodes_and_cameras(scene);
    let motion = scene.motion.as_ref();
    let moving = motion.map(|motion| file.motion(scene, motion, &mut meshes, &mut nodes));
    let mut is_child = vec![false; nodes.len()];
    let children = nodes.iter().filter_map(|node| node["children"].as_array()).flatten().filter_map(Value::as_u64);
    children.for_each(|child| is_child[child as usize] = true);
    let roots: Vec<usize> = (0..nodes.len()).filter(|&node| !is_child[node]).collect();
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "lapidary-data-generator", "copyright": "CC0 1.0" },
        "scene": 0,
        "scenes": [{ "name": scene.name, "nodes": roots }],
        "nodes": nodes,
        "cameras": cameras,
        "materials": materials,
        "meshes": meshes,
        "textures": file.images.iter().enumerate().map(|(i, _)| json!({ "source": i, "sampler": 0 })).collect::<Vec<_>>(),
        "images": file.images.iter().map(|uri| json!({ "uri": uri })).collect::<Vec<_>>(),
        // Trilinear, repeating.
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "uri": format!("{}.bin", scene.name), "byteLength": file.bytes.len() }],
    });
    if !scene.lights.is_empty() {
        root["extensionsUsed"] = json!([LIGHTS]);
        root["extensions"] = json!({ LIGHTS: { "lights": scene.lights.iter().map(light).collect::<Vec<_>>() } });
    }
    if let Some([skins, animations]) = moving {
        (root["skins"], root["animations"]) = (skins, animations);
    }
    save(&folder.join(format!("{}.bin", scene.name)), &file.bytes)?;
    let mut text = serde_json::to_string_pretty(&root)?;
    text.push('\n');
    save(&folder.join(format!("{}.gltf", scene.name)), text.as_bytes())
}

fn save(path: &Path, bytes: &[u8]) -> Result<()> {
    fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<&'static str>,
}

impl Writer {
    fn mesh(&mut self, scene: &Scene, piece: &crate::scene::Piece) -> Result<Value> {
        let material = scene.materials.iter().position(|m| m.name == piece.material);
        let material =
            material.with_context(|| format!("{} wants the unknown material {}", piece.name, piece.material))?;
        let attributes = self.attributes(&piece.mesh);
        let indices = self.indices(&piece.mesh);
        Ok(json!({
            "name": piece.name,
            "primitives": [{ "attributes": attributes, "indices": indices, "material": material }],
        }))
    }

    fn attributes(&mut self, mesh: &Mesh) -> Value {
        let (count, target) = (mesh.positions.len(), Some(ARRAY_BUFFER));
        let position = self.positions(&mesh.positions);
        let normal = self.accessor(bytemuck::cast_slice(&mesh.normals), target, FLOAT, count, "VEC3");
        let uv = self.accessor(bytemuck::cast_slice(&mesh.uvs), target, FLOAT, count, "VEC2");
        json!({ "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv })
    }

    fn indices(&mut self, mesh: &Mesh) -> usize {
        let (count, target) = (mesh.indices.len(), Some(ELEMENT_ARRAY_BUFFER));
        // 65,535 itself is reserved for primitive restart.
        if mesh.positions.len() < 0xFFFF {
            let short: Vec<u16> = mesh.indices.iter().map(|i| *i as u16).collect();
            self.accessor(bytemuck::cast_slice(&short), target, UNSIGNED_SHORT, count, "SCALAR")
        } else {
            self.accessor(bytemuck::cast_slice(&mesh.indices), target, UNSIGNED_INT, count, "SCALAR")
        }
    }

    /// `target` is the use of vertices and indices; other data have none.
    fn accessor(&mut self, data: &[u8], target: Option<u32>, component: u32, count: usize, kind: &str) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": data.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.bytes.extend_from_slice(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = self.views.len() - 1;
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    fn texture(&mut self, uri: &'static str) -> Value {
        let known = self.images.iter().position(|image| *image == uri);
        let index = known.unwrap_or_else(|| {
            self.images.push(uri);
            self.images.len() - 1
        });
        json!({ "index": index })
    }

    fn material(&mut self, material: &Material) -> Value {
        let [r, g, b] = material.base_color;
        let mut surface = Map::new();
        surface.insert("baseColorFactor".into(), json!([r, g, b, 1.0]));
        surface.insert("metallicFactor".into(), json!(material.metallic));
        surface.insert("roughnessFactor".into(), json!(material.roughness));
        if let Some(uri) = material.base_color_texture {
            surface.insert("baseColorTexture".into(), self.texture(uri));
        }
        if let Some(uri) = material.roughness_texture {
            surface.insert("metallicRoughnessTexture".into(), self.texture(uri));
        }
        let mut value = json!({ "name": material.name, "pbrMetallicRoughness": surface });
        if let Some(uri) = material.normal_texture {
            value["normalTexture"] = self.texture(uri);
            value["normalTexture"]["scale"] = json!(material.normal_scale);
        }
        if material.double_sided {
            value["doubleSided"] = json!(true);
        }
        value
    }
}

/// The smallest and the largest of each coordinate.
fn bounds(positions: &[Vec3]) -> [[f32; 3]; 2] {
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    [low, high].map(Vec3::into)
}

fn nodes_and_cameras(scene: &Scene) -> (Vec<Value>, Vec<Value>) {
    let placed_pieces = scene.nodes.iter().map(|node| placed(&node.name, "mesh", node.piece, node.world_from_object));
    let watching = scene.cameras.iter().enumerate();
    let watching = watching.map(|(i, camera)| placed(camera.name, "camera", i, looking(camera.eye, camera.target)));
    let shining = scene.lights.iter().enumerate().map(|(i, light)| placed_light(i, light));
    let nodes = placed_pieces.chain(watching).chain(shining).collect();
    let cameras = scene.cameras.iter().map(|camera| {
        json!({
            "name": camera.name,
            "type": "perspective",
            "perspective": { "yfov": camera.vertical_fov.to_radians(), "znear": 0.01, "zfar": 100.0 },
        })
    });
    (nodes, cameras.collect())
}

fn placed(name: &str, kind: &str, index: usize, world_from_object: Affine3A) -> Value {
    let (_, rotation, translation) = world_from_object.to_scale_rotation_translation();
    json!({
        "name": name,
        kind: index,
        "translation": translation.to_array(),
        "rotation": rotation.normalize().to_array(),
    })
}

fn placed_light(index: usize, light: &PunctualLight) -> Value {
    let mut node = placed(light.name, "mesh", index, looking(light.position, light.target));
    // A node refers to its light through the extension.
    if let Some(fields) = node.as_object_mut() {
        fields.remove("mesh");
    }
    node["extensions"] = json!({ LIGHTS: { "light": index } });
    node
}

/// The color is the intensity normalized by its largest channel.
fn light(light: &PunctualLight) -> Value {
    let largest = light.intensity.into_iter().fold(0.0, f32::max);
    let mut value = json!({
        "name": light.name,
        "type": if light.cone.is_some() { "spot" } else { "point" },
        "color": light.intensity.map(|channel| channel / largest),
        "intensity": largest,
    });
    if let Some([inner, outer]) = light.cone {
        value["spot"] = json!({ "innerConeAngle": inner.to_radians(), "outerConeAngle": outer.to_radians() });
    }
    value
}

/// glTF's cameras and lights look along their own -Z.
fn looking(eye: Vec3, target: Vec3) -> Affine3A {
    let back = (eye - target).normalize();
    let right = Vec3::Y.cross(back).try_normalize().unwrap_or(Vec3::X);
    let rotation = Quat::from_mat3(&Mat3::from_cols(right, back.cross(right), back));
    Affine3A::from_rotation_translation(rotation, eye)
}
