//! glTF 2.0 and GLB, parsed by the `gltf` crate; buffers and pictures are loaded here.

use super::{
    ImportError, Source, check_count,
    files::{Files, Trouble},
    listed,
    textures::TextureLibrary,
};
use crate::{camera::Camera, parts::Part, scene::MeshError};
use buffers::Buffers;
use glam::{DVec4, Mat3, Mat4, Quat, Vec2, Vec3, Vec4};
use gltf::{
    mesh::{Mode, Semantic},
    scene::Transform,
};
use serde_json::Value;
use std::{borrow::Cow, path::Path};
use variants::FileVariants;

mod buffers;
mod layers;
mod lights;
mod materials;
mod variants;

pub(crate) use buffers::percent_decoded;

/// Extensions that are honoured; others are named in a warning.
const EXTENSIONS: [&str; 10] = [
    lights::EXTENSION,
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_texture_transform",
    layers::EXTENSIONS[0],
    layers::EXTENSIONS[1],
    layers::EXTENSIONS[2],
    layers::EXTENSIONS[3],
    layers::EXTENSIONS[4],
    variants::EXTENSION,
];

pub(super) fn read(bytes: &[u8], path: &Path, mut files: Files, variant: Option<&str>) -> Result<Source, ImportError> {
    let failed = |trouble: Trouble| trouble.at(path, "glTF");
    let parse_error = |reason: String| failed(reason.into());
    check_glb_header(bytes).map_err(parse_error)?;
    files.budget.take_json(&json_of(bytes)).map_err(|over| over.at(path))?;
    check_extensions(bytes, path)?;
    let gltf = parse(bytes).map_err(parse_error)?;
    let variants = FileVariants::of(bytes, variant).map_err(|known| no_variant(path, variant, known))?;
    let buffers = Buffers::load(&gltf, &mut files).map_err(failed)?;
    let mut notes = Notes::default();
    let nodes = all_nodes(&gltf, &mut notes);
    check_size(&nodes, &mut files, path)?;

    let mut library = TextureLibrary::new(files);
    let mut source = Source::default();
    source.variants.names.clone_from(&variants.names);
    source.warnings.extend(variants.remark());
    materials::add_materials(&mut source, &gltf, bytes, &buffers, &mut library).map_err(failed)?;
    if let Some(document) = document_with(bytes, lights::EXTENSION) {
        lights::add_lights(&mut source, &document, &nodes);
    }
    for (node, world_from_node) in &nodes {
        if let Some(camera) = node.camera() {
            add_camera(&mut source, node, &camera, *world_from_node);
        }
        if let Some(mesh) = node.mesh() {
            let name = node_name(node);
            notes.inspect(&name, node, &mesh);
            let mut parts = variants::PartsOfNode::new(&mut source, name);
            for primitive in mesh.primitives().filter(|p| is_surface(p.mode())) {
                let read = Primitive::read(&primitive, &buffers).map_err(parse_error)?;
                read.check_indices().map_err(|source| ImportError::Mesh { path: path.into(), source })?;
                let mut material = |chosen| materials::index_of(&mut source, &gltf, &primitive, chosen);
                let place = [mesh.index(), primitive.index()];
                let (own, looks) = (material(variants.chosen(place)), variants.looks(place, &mut material));
                let part = parts.add(&mut source, own, looks);
                read.add_to(&mut source, *world_from_node, part);
            }
        }
    }
    notes.warn(&mut source.warnings);
    warn_of_extensions(&gltf, &mut source.warnings);
    library.finish(&mut source);
    Ok(source)
}

/// Parses and validates. The validation of the `gltf` crate looks up accessors of attributes before it checks their
/// indices, so these are checked first.
fn parse(bytes: &[u8]) -> Result<gltf::Gltf, String> {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(bytes).map_err(|e| e.to_string())?;
    let mut json = document.into_json();
    // Read here; the crate would refuse a file that requires it.
    json.extensions_required.retain(|e| !EXTENSIONS.contains(&e.as_str()));
    let mut attributes = json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values());
    if let Some(bad) = attributes.find(|accessor| accessor.value() >= json.accessors.len()) {
        return Err(format!("a mesh refers to accessor {bad}, but there are {}", json.accessors.len()));
    }
    let document = gltf::Document::from_json(json).map_err(|e| e.to_string())?;
    Ok(gltf::Gltf { document, blob })
}

/// Checks that all extensions that a file requires are read.
///
/// # Errors
/// [`ImportError::Extensions`].
fn check_extensions(bytes: &[u8], path: &Path) -> Result<(), ImportError> {
    let required = document_with(bytes, "extensionsRequired").unwrap_or_default();
    let names = required["extensionsRequired"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let unknown: Vec<String> = names.filter(|name| !EXTENSIONS.contains(name)).map(str::to_owned).collect();
    if unknown.is_empty() { Ok(()) } else { Err(ImportError::Extensions { path: path.into(), names: unknown }) }
}

/// The error of a variant that is not there.
pub(super) fn no_variant(path: &Path, wanted: Option<&str>, known: Vec<String>) -> ImportError {
    ImportError::NoSuchVariant { path: path.into(), name: wanted.unwrap_or_default().into(), known }
}

/// The JSON text of a file.
fn json_of(bytes: &[u8]) -> Cow<'_, [u8]> {
    gltf::Glb::from_slice(bytes).map_or(Cow::Borrowed(bytes), |glb| glb.json)
}

/// The JSON of a file that mentions an extension; for what the `gltf` crate does not offer.
fn document_with(bytes: &[u8], extension: &str) -> Option<Value> {
    let json = &*json_of(bytes);
    let mentioned = json.windows(extension.len()).any(|w| w == extension.as_bytes());
    mentioned.then(|| serde_json::from_slice(json).ok()).flatten()
}

/// The `gltf` crate subtracts from the length in a GLB header before it checks it.
fn check_glb_header(bytes: &[u8]) -> Result<(), String> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    match bytes.get(8..12) {
        Some(length) if u32::from_le_bytes([length[0], length[1], length[2], length[3]]) >= 12 => Ok(()),
        _ => Err("the header of the binary file is damaged".into()),
    }
}

/// Every node of every scene once with its transform, parents first; a file's cycles end at the second visit.
fn all_nodes<'a>(gltf: &'a gltf::Document, notes: &mut Notes) -> Vec<(gltf::Node<'a>, Mat4)> {
    let mut visited = vec![false; gltf.nodes().count()];
    let mut found = Vec::new();
    let mut pending: Vec<_> = gltf.scenes().flat_map(|s| s.nodes()).map(|n| (n, Mat4::IDENTITY)).collect();
    if pending.is_empty() {
        let mut is_child = vec![false; gltf.nodes().count()];
        gltf.nodes().flat_map(|n| n.children()).for_each(|n| is_child[n.index()] = true);
        pending = gltf.nodes().filter(|n| !is_child[n.index()]).map(|n| (n, Mat4::IDENTITY)).collect();
    }
    pending.reverse();
    while let Some((node, world_from_parent)) = pending.pop() {
        if std::mem::replace(&mut visited[node.index()], true) {
            continue;
        }
        let world_from_node = world_from_parent * parent_from_node(&node, notes);
        let children: Vec<_> = node.children().map(|child| (child, world_from_node)).collect();
        pending.extend(children.into_iter().rev());
        found.push((node, world_from_node));
    }
    found
}

/// The transform of a node. The format wants unit quaternions; others are normalised, and those without a direction turn
/// nothing.
fn parent_from_node(node: &gltf::Node, notes: &mut Notes) -> Mat4 {
    if let Transform::Decomposed { translation, rotation, scale } = node.transform() {
        let quaternion = DVec4::from_array(rotation.map(f64::from));
        if !((quaternion.length_squared() - 1.0).abs() < 1e-2) {
            notes.turned.push(node_name(node));
            let unit = Quat::from_vec4(quaternion.try_normalize().unwrap_or(DVec4::W).as_vec4());
            return Mat4::from_scale_rotation_translation(scale.into(), unit, translation.into());
        }
    }
    Mat4::from_cols_array_2d(&node.transform().matrix())
}

fn is_surface(mode: Mode) -> bool {
    matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

/// Counts what all instances will take before anything is read.
fn check_size(nodes: &[(gltf::Node, Mat4)], files: &mut Files, path: &Path) -> Result<(), ImportError> {
    let (mut vertices, mut triangles) = (0u64, 0u64);
    for primitive in nodes.iter().filter_map(|(node, _)| node.mesh()).flat_map(|mesh| mesh.primitives()) {
        let positions = primitive.get(&Semantic::Positions).map_or(0, |a| a.count() as u64);
        let corners = primitive.indices().map_or(positions, |a| a.count() as u64);
        let per_triangle = if primitive.mode() == Mode::Triangles { 3 } else { 1 };
        // One without anything takes time, too.
        vertices = vertices.saturating_add(positions.max(1));
        triangles = triangles.saturating_add((corners / per_triangle).max(1));
    }
    check_count("vertices", vertices, path)?;
    check_count("triangles", triangles, path)?;
    files.budget.take_mesh(vertices, triangles).map_err(|over| over.at(path))
}

fn node_name(node: &gltf::Node) -> String {
    let mesh_name = node.mesh().and_then(|m| m.name().map(str::to_owned));
    node.name().map(str::to_owned).or(mesh_name).unwrap_or_else(|| format!("node {}", node.index()))
}

fn add_camera(source: &mut Source, node: &gltf::Node, camera: &gltf::Camera, world_from_node: Mat4) {
    let name = node.name().or(camera.name()).unwrap_or("camera").to_owned();
    let gltf::camera::Projection::Perspective(lens) = camera.projection() else {
        source
            .warnings
            .push(format!("the camera \"{name}\" is orthographic and was left out; use a perspective camera"));
        return;
    };
    let eye = world_from_node.w_axis.truncate();
    let forward = -world_from_node.z_axis.truncate().normalize_or(Vec3::Z);
    let up = world_from_node.y_axis.truncate().normalize_or(Vec3::Y);
    source.cameras.push(Camera { name, eye, target: eye + forward, up, fov_y: lens.yfov() });
}

/// The attributes of a primitive in its own space, and its triangles.
struct Primitive {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    tangents: Vec<Vec4>,
    triangles: Vec<[u32; 3]>,
}

impl Primitive {
    fn read(primitive: &gltf::Primitive, buffers: &Buffers) -> Result<Self, String> {
        let positions = buffers.positions(primitive)?;
        let count = positions.len();
        let indices = buffers.indices(primitive)?.unwrap_or_else(|| (0..count as u32).collect());
        Ok(Self {
            normals: buffers.normals(primitive, count)?,
            uvs: buffers.uvs(primitive, count)?,
            tangents: buffers.tangents(primitive, count)?,
            triangles: triangles(primitive.mode(), &indices),
            positions,
        })
    }

    fn check_indices(&self) -> Result<(), MeshError> {
        let count = self.positions.len();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&c| c as usize >= count) {
                return Err(MeshError::Index { triangle, array: "vertex", index, count });
            }
        }
        Ok(())
    }

    /// Adds the primitive as it stands in the world. A mirroring transform turns the triangles around.
    fn add_to(self, source: &mut Source, world_from_object: Mat4, Part { object, material }: Part) {
        let raw = &mut source.mesh;
        let base = raw.positions.len();
        let linear = Mat3::from_mat4(world_from_object);
        let handedness = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        let normal_transform = handedness * cofactors(linear);
        raw.positions.extend(self.positions.iter().map(|p| world_from_object.transform_point3(*p)));
        raw.normals.extend(self.normals.iter().map(|n| (normal_transform * *n).normalize_or_zero()));
        raw.uvs.extend(self.uvs);
        raw.tangents.extend(self.tangents.iter().map(|t| (linear * t.truncate()).extend(handedness * t.w)));
        for [a, b, c] in self.triangles {
            raw.push_triangle(base, if handedness < 0.0 { [a, c, b] } else { [a, b, c] }, material, object);
        }
    }
}

/// The inverse transpose times the determinant, which exists for every matrix.
fn cofactors(m: Mat3) -> Mat3 {
    Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
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

/// Objects of which something was left out.
#[derive(Default)]
struct Notes {
    not_surfaces: Vec<String>,
    skinned: Vec<String>,
    morphed: Vec<String>,
    colored: Vec<String>,
    turned: Vec<String>,
}

impl Notes {
    fn inspect(&mut self, name: &str, node: &gltf::Node, mesh: &gltf::Mesh) {
        let mut note = |list: fn(&mut Self) -> &mut Vec<String>, applies: bool| {
            if applies {
                list(self).push(name.to_owned());
            }
        };
        note(|n| &mut n.skinned, node.skin().is_some());
        note(|n| &mut n.not_surfaces, mesh.primitives().any(|p| !is_surface(p.mode())));
        note(|n| &mut n.morphed, mesh.primitives().any(|p| p.morph_targets().next().is_some()));
        note(|n| &mut n.colored, mesh.primitives().any(|p| p.get(&Semantic::Colors(0)).is_some()));
    }

    fn warn(&self, warnings: &mut Vec<String>) {
        for (names, text) in [
            (&self.not_surfaces, "hold points or lines, which were left out; convert them to surfaces"),
            (&self.skinned, "are skinned and show in their rest pose; apply the pose before exporting"),
            (&self.morphed, "have morph targets, which were left out; apply the shape before exporting"),
            (&self.turned, "have a rotation that is no unit quaternion, which was normalised; export them again"),
            (&self.colored, "have vertex colours, which were left out; bake them to a texture"),
        ] {
            if !names.is_empty() {
                warnings.push(format!("the objects {} {text}", listed(names)));
            }
        }
    }
}

fn warn_of_extensions(gltf: &gltf::Document, warnings: &mut Vec<String>) {
    let others: Vec<String> = gltf.extensions_used().filter(|e| !EXTENSIONS.contains(e)).map(str::to_owned).collect();
    if !others.is_empty() {
        warnings.push(format!(
            "the glTF extensions {} are not supported and were left out; what they describe may look different",
            listed(&others)
        ));
    }
}
