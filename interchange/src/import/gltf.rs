//! glTF 2.0 and GLB, parsed by the `gltf` crate; buffers and pictures are loaded here.

use super::{
    files::{Files, Trouble},
    textures::TextureLibrary,
};
use crate::{
    features::gltf::ORTHOGRAPHIC,
    import::{
        report::{ImportError, ImportOptions},
        source::Source,
    },
    names::listed,
};
use clips::Clips;
use document::warn_of_extensions;
use glam::{Mat4, Vec3};
use gltf::material::AlphaMode;
use hierarchy::node_name;
use json::document_with;
use lapidary_core::{
    animation::{Animation, shape::Shape},
    camera::Camera,
    material::Material,
    names::told_apart,
};
use notes::Notes;
use primitive::Primitive;
use scene_file::SceneFile;
use std::path::Path;

mod buffers;
mod clips;
mod completed;
mod compressed;
pub(crate) mod container;
mod deformations;
mod document;
mod glossiness;
mod hierarchy;
mod json;
mod layers;
mod lights;
mod materials;
mod notes;
mod pointers;
mod primitive;
mod scene_file;
mod scenes;
mod variants;

pub(crate) use buffers::percent_decoded;

/// Reads a scene at rest.
pub(super) fn read(
    bytes: &[u8],
    path: &Path,
    mut files: Files,
    options: &ImportOptions,
) -> Result<Source, ImportError> {
    let failed = |trouble: Trouble| trouble.at(path, "glTF");
    let mut file = SceneFile::open(bytes, path, &mut files, options)?;
    // Clips are checked, and not kept.
    let clips = Clips::read(&file, &mut files.budget.clone());
    let remarks: Vec<String> = clips.remarks_of_broken().chain(clips.remarks_of_channels()).collect();
    let hidden = file.keep_hidden(&clips.playable);
    drop(clips);
    let (gltf, buffers) = (&file.gltf, &file.buffers);
    let mut library = TextureLibrary::new(files);
    let mut source = Source { origin: file.origin, ..Source::default() };
    source.variants.names.clone_from(&file.variants.names);
    source.warnings.extend(file.scenes.remark());
    if file.scenes.names.len() > 1 {
        source.scenes.clone_from(&file.scenes.names);
        source.default_scene = file.scenes.default.map(|scene| file.scenes.names[scene].clone());
    }
    source.warnings.extend(file.variants.remark());
    source.warnings.extend(remark_of_empty_textures(&file.without_picture));
    materials::add_materials(&mut source, gltf, &file.json, buffers, &file.other_pictures, &mut library)
        .map_err(failed)?;
    let at_rest = file.at_rest();
    let placed: Vec<_> =
        file.nodes_of_scene().map(|node| (node.clone(), at_rest.world_from_node(node.index()))).collect();
    if let Some(document) = document_with(&file.json, lights::EXTENSION) {
        lights::add_lights(&mut source, &document, &placed);
    }
    for (node, world_from_node) in &placed {
        if let Some(camera) = node.camera() {
            add_camera(&mut source, node, &camera, *world_from_node);
        }
    }
    let mut notes = Notes::of(&file);
    file.add_objects(&mut source, |source, node, primitive, part| {
        let read = file.primitive(primitive, path)?;
        if read.is_colored() {
            source.show_vertex_colors(part);
        }
        if read.has_alpha && primitive.material().alpha_mode() != AlphaMode::Opaque {
            notes.faded.push(node_name(node));
        }
        read.add_to(source, &file.deformation(node, primitive, &mut notes.deformations), node.index(), &at_rest, part);
        Ok(())
    })?;
    source.warnings.extend(remarks);
    source.warnings.extend(hidden);
    notes.warn(&mut source.warnings);
    warn_of_extensions(gltf, &mut source.warnings);
    library.finish(&mut source);
    Ok(source)
}

/// Reads the animation of a file, without materials and pictures.
pub(super) fn read_animation(
    bytes: &[u8],
    path: &Path,
    mut files: Files,
    options: &ImportOptions,
) -> Result<Animation, ImportError> {
    let options = ImportOptions { variant: None, ..options.clone() };
    let mut file = SceneFile::open(bytes, path, &mut files, &options)?;
    let clips = Clips::read(&file, &mut files.budget);
    let mut warnings: Vec<String> = clips.remarks_of_channels().collect();
    let Clips { playable: clips, broken, .. } = clips;
    file.keep_hidden(&clips);
    let moving = file.moving(&clips);
    let (mut shapes, mut notes) = (Vec::new(), Notes::default());
    let materials = file.gltf.materials().map(|_| Material::default()).collect();
    let mut source = Source { materials, ..Source::default() };
    file.add_objects(&mut source, |_, node, primitive, part| {
        if moving.reaches(node, primitive) {
            let Primitive { mut surface, triangles, .. } = file.primitive(primitive, path)?;
            surface.tangents.clear();
            let deformation = file.deformation(node, primitive, &mut notes.deformations);
            shapes.push(Shape { object: part.object, node: node.index(), surface, triangles, deformation });
        }
        Ok(())
    })?;
    shapes.sort_by_key(|shape| shape.object);
    let objects = told_apart(source.objects.into_iter().map(|object| object.name).collect());
    notes.warn(&mut warnings);
    let skins = file.skins.into_iter().map(Result::unwrap_or_default).collect();
    Ok(Animation { path: path.into(), nodes: file.nodes, skins, clips, broken, shapes, objects, warnings })
}

fn remark_of_empty_textures(materials: &[String]) -> Option<String> {
    let names = (!materials.is_empty()).then(|| listed(materials))?;
    Some(format!(
        "the materials {names} name textures without a picture, which were left out; export them with their pictures"
    ))
}

fn add_camera(source: &mut Source, node: &gltf::Node, camera: &gltf::Camera, world_from_node: Mat4) {
    let name = node.name().or(camera.name()).unwrap_or("camera").to_owned();
    let gltf::camera::Projection::Perspective(lens) = camera.projection() else {
        source.warnings.extend(ORTHOGRAPHIC.warning("cameras", &[name]));
        return;
    };
    let eye = world_from_node.w_axis.truncate();
    let forward = -world_from_node.z_axis.truncate().normalize_or(Vec3::Z);
    let up = world_from_node.y_axis.truncate().normalize_or(Vec3::Y);
    source.cameras.push(Camera { name, eye, target: eye + forward, up, fov_y: lens.yfov(), lens: Default::default() });
}
