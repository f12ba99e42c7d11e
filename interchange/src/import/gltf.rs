//! glTF 2.0 and GLB, parsed by the `gltf` crate; buffers and pictures are loaded here.

use super::{
    ImportError, Source,
    files::{Files, Trouble},
    listed,
    textures::TextureLibrary,
};
use clips::Clips;
use glam::{Mat4, Vec3};
use gltf::mesh::{Mode, Semantic};
use lapidary_core::{
    animation::{Animation, shape::Shape},
    camera::Camera,
    material::Material,
};
use primitive::Primitive;
use scene_file::SceneFile;
use serde_json::Value;
use std::{borrow::Cow, path::Path};

mod buffers;
mod clips;
mod deformations;
mod hierarchy;
mod layers;
mod lights;
mod materials;
mod pointers;
mod primitive;
mod scene_file;
mod variants;

pub(crate) use buffers::percent_decoded;

/// Extensions that are honoured; others are named in a warning.
const EXTENSIONS: [&str; 11] = [
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
    // What it moves stays at rest, which is told.
    pointers::EXTENSION,
];

/// Reads a scene as it is at rest.
pub(super) fn read(bytes: &[u8], path: &Path, mut files: Files, variant: Option<&str>) -> Result<Source, ImportError> {
    let failed = |trouble: Trouble| trouble.at(path, "glTF");
    let file = SceneFile::open(bytes, path, &mut files, variant)?;
    let (gltf, buffers) = (&file.gltf, &file.buffers);
    // They are checked, and not kept.
    let clips = Clips::read(&file, &mut files.budget.clone());
    let remarks: Vec<String> = clips.remarks_of_broken().chain(clips.remarks_of_channels()).collect();
    drop(clips);
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
        let read = file.primitive(primitive, path)?;
        read.add_to(source, &file.deformation(node, primitive, &mut notes), node.index(), &at_rest, part);
        Ok(())
    })?;
    source.warnings.extend(remarks);
    notes.warn(&mut source.warnings);
    warn_of_extensions(gltf, &mut source.warnings);
    library.finish(&mut source);
    Ok(source)
}

/// Reads what moves in a file, without materials and pictures.
pub(super) fn read_animation(bytes: &[u8], path: &Path, mut files: Files) -> Result<Animation, ImportError> {
    let file = SceneFile::open(bytes, path, &mut files, None)?;
    let clips = Clips::read(&file, &mut files.budget);
    let mut warnings: Vec<String> = clips.remarks_of_channels().collect();
    let Clips { playable: clips, broken, .. } = clips;
    let moving = file.moving(&clips);
    let (mut shapes, mut notes) = (Vec::new(), Notes::default());
    let materials = file.gltf.materials().map(|_| Material::default()).collect();
    let mut source = Source { materials, ..Source::default() };
    file.add_objects(&mut source, |_, node, primitive, part| {
        if moving.reaches(node, primitive) {
            let Primitive { mut surface, triangles, .. } = file.primitive(primitive, path)?;
            surface.tangents.clear();
            let deformation = file.deformation(node, primitive, &mut notes);
            shapes.push(Shape { object: part.object, node: node.index(), surface, triangles, deformation });
        }
        Ok(())
    })?;
    shapes.sort_by_key(|shape| shape.object);
    let objects = source.objects.into_iter().map(|object| object.name).collect();
    notes.warn(&mut warnings);
    let skins = file.skins.into_iter().map(Result::unwrap_or_default).collect();
    Ok(Animation { path: path.into(), nodes: file.nodes, skins, clips, broken, shapes, objects, warnings })
}

/// Parses and validates. Returns the animations whose channels that move no node were removed, too. The validation of the `gltf` crate looks up accessors of attributes before it checks their
/// indices, so these are checked first.
fn parse(bytes: &[u8]) -> Result<(gltf::Gltf, Vec<usize>), String> {
    let parsed = gltf::Gltf::from_slice_without_validation(bytes).map(|gltf| (gltf, Vec::new()));
    let parsed = parsed.or_else(|error| pointers::parse_without(bytes).ok_or(error));
    let (gltf::Gltf { document, blob }, pointing) = parsed.map_err(|e| e.to_string())?;
    let mut json = document.into_json();
    // Read here; the crate would refuse a file that requires it.
    json.extensions_required.retain(|e| !EXTENSIONS.contains(&e.as_str()));
    let mut attributes = json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values());
    if let Some(bad) = attributes.find(|accessor| accessor.value() >= json.accessors.len()) {
        return Err(format!("a mesh refers to accessor {bad}, but there are {}", json.accessors.len()));
    }
    let document = gltf::Document::from_json(json).map_err(|e| e.to_string())?;
    Ok((gltf::Gltf { document, blob }, pointing))
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
