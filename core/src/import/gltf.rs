//! glTF 2.0 and GLB, parsed by the `gltf` crate; buffers and pictures are loaded here.

use super::{
    ImportError, Source, check_count,
    files::{Files, Trouble},
    listed,
    textures::TextureLibrary,
};
use crate::{
    animation::{
        Animation, Clip,
        clip::Property,
        nodes::Nodes,
        shape::{Deformation, Posture, Shape},
        skin::Skin,
        surface::Surface,
    },
    camera::Camera,
    material::Material,
    parts::Part,
    scene::MeshError,
};
use buffers::Buffers;
use clips::Clips;
use glam::{Mat4, Vec2, Vec3};
use gltf::mesh::{Mode, Semantic};
use hierarchy::Hierarchy;
use serde_json::Value;
use std::{borrow::Cow, path::Path};
use variants::FileVariants;

mod buffers;
mod clips;
mod deformations;
mod hierarchy;
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

/// Reads a scene as it is at rest.
pub(super) fn read(bytes: &[u8], path: &Path, mut files: Files, variant: Option<&str>) -> Result<Source, ImportError> {
    let failed = |trouble: Trouble| trouble.at(path, "glTF");
    let file = SceneFile::open(bytes, path, &mut files, variant)?;
    let (gltf, buffers) = (&file.gltf, &file.buffers);
    let mut library = TextureLibrary::new(files);
    let mut source = Source::default();
    source.variants.names.clone_from(&file.variants.names);
    source.warnings.extend(file.variants.remark());
    materials::add_materials(&mut source, gltf, bytes, buffers, &mut library).map_err(failed)?;
    let at_rest = file.at_rest();
    let placed: Vec<_> =
        file.nodes_of_scene().map(|node| (node.clone(), at_rest.world_from_node(node.index()))).collect();
    if let Some(document) = document_with(bytes, lights::EXTENSION) {
        lights::add_lights(&mut source, &document, &placed);
    }
    let mut notes = Notes { turned: file.turned.clone(), ..Notes::default() };
    for (node, world_from_node) in &placed {
        if let Some(camera) = node.camera() {
            add_camera(&mut source, node, &camera, *world_from_node);
        }
        if let Some(mesh) = node.mesh() {
            notes.inspect(&node_name(node), &mesh);
        }
    }
    file.add_objects(&mut source, |source, node, primitive, part| {
        let read = Primitive::read(primitive, buffers).map_err(|reason| failed(reason.into()))?;
        read.check_indices().map_err(|source| ImportError::Mesh { path: path.into(), source })?;
        read.add_to(source, &file.deformation(node, primitive, &mut notes), node.index(), &at_rest, part);
        Ok(())
    })?;
    source.warnings.extend(Clips::read(gltf, &file.nodes, buffers).remarks());
    notes.warn(&mut source.warnings);
    warn_of_extensions(gltf, &mut source.warnings);
    library.finish(&mut source);
    Ok(source)
}

/// Reads what moves in a file, without materials and pictures.
pub(super) fn read_animation(bytes: &[u8], path: &Path, mut files: Files) -> Result<Animation, ImportError> {
    let file = SceneFile::open(bytes, path, &mut files, None)?;
    let Clips { playable: clips, broken } = Clips::read(&file.gltf, &file.nodes, &file.buffers);
    let moving = file.moving(&clips);
    let (mut shapes, mut notes) = (Vec::new(), Notes::default());
    let materials = file.gltf.materials().map(|_| Material::default()).collect();
    let mut source = Source { materials, ..Source::default() };
    file.add_objects(&mut source, |_, node, primitive, part| {
        if moving.reaches(node, primitive) {
            let parsed = |reason: String| Trouble::from(reason).at(path, "glTF");
            let Primitive { mut surface, triangles, .. } = Primitive::read(primitive, &file.buffers).map_err(parsed)?;
            surface.tangents.clear();
            let deformation = file.deformation(node, primitive, &mut notes);
            shapes.push(Shape { object: part.object, node: node.index(), surface, triangles, deformation });
        }
        Ok(())
    })?;
    shapes.sort_by_key(|shape| shape.object);
    let objects = source.objects.into_iter().map(|object| object.name).collect();
    let mut warnings = Vec::new();
    notes.warn(&mut warnings);
    let skins = file.skins.into_iter().map(Result::unwrap_or_default).collect();
    Ok(Animation { path: path.into(), nodes: file.nodes, skins, clips, broken, shapes, objects, warnings })
}

/// A file that was parsed, with its buffers and its nodes.
struct SceneFile {
    gltf: gltf::Gltf,
    buffers: Buffers,
    variants: FileVariants,
    nodes: Nodes,
    /// Nodes of scenes, parents first.
    order: Vec<usize>,
    /// Nodes whose rotation was normalised.
    turned: Vec<String>,
    skins: Vec<Result<Skin, String>>,
}

impl SceneFile {
    fn open(bytes: &[u8], path: &Path, files: &mut Files, variant: Option<&str>) -> Result<Self, ImportError> {
        let failed = |trouble: Trouble| trouble.at(path, "glTF");
        let parse_error = |reason: String| failed(reason.into());
        check_glb_header(bytes).map_err(parse_error)?;
        files.budget.take_json(&json_of(bytes)).map_err(|over| over.at(path))?;
        check_extensions(bytes, path)?;
        let gltf = parse(bytes).map_err(parse_error)?;
        let variants = FileVariants::of(bytes, variant).map_err(|known| no_variant(path, variant, known))?;
        let buffers = Buffers::load(&gltf, files).map_err(failed)?;
        let hierarchy = hierarchy::read(&gltf);
        let skins = deformations::skins(&gltf, &buffers);
        let Hierarchy { nodes, order, turned } = hierarchy;
        let file = Self { gltf, buffers, variants, nodes, order, turned, skins };
        file.check_size(files, path)?;
        Ok(file)
    }

    fn nodes_of_scene(&self) -> impl Iterator<Item = gltf::Node<'_>> {
        let all: Vec<gltf::Node> = self.gltf.nodes().collect();
        self.order.iter().map(move |&index| all[index].clone())
    }

    fn at_rest(&self) -> Posture {
        let skins: Vec<Skin> = self.skins.iter().map(|skin| skin.clone().unwrap_or_default()).collect();
        Posture::new(&self.nodes, &skins, self.nodes.at_rest())
    }

    /// Counts what all instances will take before anything is read.
    fn check_size(&self, files: &mut Files, path: &Path) -> Result<(), ImportError> {
        let (mut vertices, mut triangles, mut deformations) = (0u64, 0u64, 0u64);
        for primitive in self.nodes_of_scene().filter_map(|node| node.mesh()).flat_map(|mesh| mesh.primitives()) {
            let positions = primitive.get(&Semantic::Positions).map_or(0, |a| a.count() as u64);
            let corners = primitive.indices().map_or(positions, |a| a.count() as u64);
            let per_triangle = if primitive.mode() == Mode::Triangles { 3 } else { 1 };
            // One without anything takes time, too.
            vertices = vertices.saturating_add(positions.max(1));
            triangles = triangles.saturating_add((corners / per_triangle).max(1));
            deformations = deformations.saturating_add(deformations::bytes(&primitive, positions));
        }
        check_count("vertices", vertices, path)?;
        check_count("triangles", triangles, path)?;
        let taken = files.budget.take_mesh(vertices, triangles).and_then(|()| files.budget.take(deformations));
        taken.map_err(|over| over.at(path))
    }

    /// Adds the objects of the scene, and calls `each` with their primitives and the parts that these are.
    fn add_objects(
        &self,
        source: &mut Source,
        mut each: impl FnMut(&mut Source, &gltf::Node, &gltf::Primitive, Part) -> Result<(), ImportError>,
    ) -> Result<(), ImportError> {
        for node in self.nodes_of_scene() {
            let Some(mesh) = node.mesh() else { continue };
            let mut parts = variants::PartsOfNode::new(source, node_name(&node));
            for primitive in mesh.primitives().filter(|p| is_surface(p.mode())) {
                let mut material = |chosen| materials::index_of(source, &self.gltf, &primitive, chosen);
                let place = [mesh.index(), primitive.index()];
                let (own, looks) = (material(self.variants.chosen(place)), self.variants.looks(place, &mut material));
                let part = parts.add(source, own, looks);
                each(source, &node, &primitive, part)?;
            }
        }
        Ok(())
    }

    /// What deforms a primitive, as far as it can be used.
    fn deformation(&self, node: &gltf::Node, primitive: &gltf::Primitive, notes: &mut Notes) -> Deformation {
        let vertices = primitive.get(&Semantic::Positions).map_or(0, |positions| positions.count());
        let (deformation, troubles) = deformations::read(node, primitive, vertices, &self.skins, &self.buffers);
        let told = |trouble| {
            format!("\"{}\" shows without a part of its deformation, {trouble}; export it again", node_name(node))
        };
        notes.deformations.extend(troubles.into_iter().map(told));
        deformation
    }

    /// What some clip moves.
    fn moving(&self, clips: &[Clip]) -> Moving {
        let channels = || clips.iter().flat_map(Clip::channels);
        let marked = |is_meant: fn(Property) -> bool| {
            let mut marked = vec![false; self.gltf.nodes().count()];
            channels().filter(|c| is_meant(c.property)).for_each(|channel| marked[channel.node] = true);
            marked
        };
        let nodes = self.nodes.carried(&marked(|property| property != Property::Weights));
        let is_carried = |skin: &Skin| skin.joints.iter().any(|&joint| nodes[joint]);
        let skins = self.skins.iter().map(|skin| skin.as_ref().is_ok_and(is_carried)).collect();
        Moving { weights: marked(|property| property == Property::Weights), nodes, skins }
    }
}

/// What clips move, by index.
struct Moving {
    nodes: Vec<bool>,
    weights: Vec<bool>,
    skins: Vec<bool>,
}

impl Moving {
    /// Whether they move a primitive of a node. A skin that cannot be used leaves it to its node.
    fn reaches(&self, node: &gltf::Node, primitive: &gltf::Primitive) -> bool {
        let index = node.index();
        let has_targets = primitive.morph_targets().next().is_some();
        self.nodes[index]
            || self.weights[index] && has_targets
            || node.skin().is_some_and(|skin| self.skins[skin.index()])
    }
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

fn is_surface(mode: Mode) -> bool {
    matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
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
    surface: Surface,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
}

impl Primitive {
    fn read(primitive: &gltf::Primitive, buffers: &Buffers) -> Result<Self, String> {
        let positions = buffers.positions(primitive)?;
        let count = positions.len();
        let indices = buffers.indices(primitive)?.unwrap_or_else(|| (0..count as u32).collect());
        let (normals, tangents) = (buffers.normals(primitive, count)?, buffers.tangents(primitive, count)?);
        Ok(Self {
            uvs: buffers.uvs(primitive, count)?,
            triangles: triangles(primitive.mode(), &indices),
            surface: Surface { positions, normals, tangents },
        })
    }

    fn check_indices(&self) -> Result<(), MeshError> {
        let count = self.surface.positions.len();
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&c| c as usize >= count) {
                return Err(MeshError::Index { triangle, array: "vertex", index, count });
            }
        }
        Ok(())
    }

    /// Adds the primitive of a node as it stands in the world. Where that mirrors it, the triangles turn around.
    fn add_to(
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

/// Most sentences of one kind that are told one by one.
const MOST_SENTENCES: usize = 5;

/// Objects of which something was left out.
#[derive(Default)]
struct Notes {
    not_surfaces: Vec<String>,
    /// Sentences of what deforms objects and cannot be used.
    deformations: Vec<String>,
    colored: Vec<String>,
    turned: Vec<String>,
}

impl Notes {
    fn inspect(&mut self, name: &str, mesh: &gltf::Mesh) {
        let mut note = |list: fn(&mut Self) -> &mut Vec<String>, applies: bool| {
            if applies {
                list(self).push(name.to_owned());
            }
        };
        note(|n| &mut n.not_surfaces, mesh.primitives().any(|p| !is_surface(p.mode())));
        note(|n| &mut n.colored, mesh.primitives().any(|p| p.get(&Semantic::Colors(0)).is_some()));
    }

    fn warn(&self, warnings: &mut Vec<String>) {
        warnings.extend(self.deformations.iter().take(MOST_SENTENCES).cloned());
        if let Some(more) = self.deformations.len().checked_sub(MOST_SENTENCES).filter(|more| *more > 0) {
            warnings.push(format!("{more} more objects show without a part of their deformation"));
        }
        for (names, text) in [
            (&self.not_surfaces, "hold points or lines, which were left out; convert them to surfaces"),
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
