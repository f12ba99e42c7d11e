//! Import of scene files into a [`Scene`], with a report of repairs.
//!
//! Each format has a reader that returns a `RawMesh` with the contents of the file. `repair` then makes a clean mesh of it, the
//! same way for all formats. `ranges` clamps everything else. Contents of a file never cause a panic: they are repaired with a
//! warning, or refused with an error. `budget` bounds the memory of an import, and `files` restricts the files it reads.

use crate::file_format::FileFormat;
use files::{Files, read_file};
use glam::Vec3;
pub(crate) use gltf::percent_decoded;
use lapidary_core::{animation::Animation, names::told_apart, scene::Scene};
use source::Source;
use std::{collections::BTreeMap, path::Path};

mod budget;
mod fields;
mod files;
pub(crate) mod gltf;
mod materials;
pub(crate) mod mtl;
mod obj;
mod ply;
mod polygon;
mod ranges;
mod recenter;
mod repair;
mod report;
mod scene_format;
mod source;
mod tangents;
mod textures;

pub use crate::material_file::{MapFiles, MaterialFile, SlotFile};
pub use materials::{is_materialx, load_material, material_in_file, materials_in_file, pictures_of_material};
pub use report::{ImportError, ImportOptions, ImportReport};
pub use scene_format::{Content, SceneFormat};
pub use textures::sanitized;

/// A scene and the report of its import.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The scene; its mesh is valid.
    pub scene: Scene,
    /// Report of the import and its repairs.
    pub report: ImportReport,
}

/// Imports a scene from a file of one of the [`SceneFormat`]s. It may use all free memory, and read files of its folder.
///
/// # Errors
/// See [`import_with`].
pub fn import(path: &Path) -> Result<Imported, ImportError> {
    import_with(path, &ImportOptions::default())
}

/// Imports a scene from a file of one of the [`SceneFormat`]s.
///
/// # Errors
/// A file that is unreadable, damaged, or too large, has no triangles, or needs files that it may not read.
pub fn import_with(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let Some(format) = SceneFormat::of(path) else {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        return Err(ImportError::Unsupported { path: path.into(), extension, known: SceneFormat::names() });
    };
    let variant = options.variant.as_deref();
    if !format.holds(Content::Variants) && variant.is_some() {
        return Err(ImportError::no_variant(path, variant, Vec::new()));
    }
    let scene = options.scene.as_deref();
    if !format.holds(Content::Scenes) && scene.is_some() {
        return Err(ImportError::no_scene(path, scene, Vec::new()));
    }
    let mut files = Files::beside(path, options);
    let bytes = read_file(path, &mut files)?;
    finish((format.read)(&bytes, path, files, options)?, path)
}

/// The animation of a file; `None` for a format without animations.
pub(crate) fn animation(path: &Path, options: &ImportOptions) -> Option<Result<Animation, ImportError>> {
    let read = SceneFormat::of(path)?.animation?;
    let mut files = Files::beside(path, options);
    Some(read_file(path, &mut files).and_then(|bytes| read(&bytes, path, files, options)))
}

/// Repairs and validates the mesh.
fn finish(source: Source, path: &Path) -> Result<Imported, ImportError> {
    let mesh_error = |source| ImportError::Mesh { path: path.into(), source };
    let Source { variants, scenes, default_scene, warnings, unread, outside, files, .. } = source;
    let names = variants.names.clone();
    let warnings = source.origin.map(recenter::warning).into_iter().chain(warnings).collect();
    let mut report =
        ImportReport { scenes, default_scene, variants: names, warnings, unread, outside, files, ..Default::default() };
    let mesh = repair::repair(source.mesh, &source.materials, &mut report).map_err(mesh_error)?;
    mesh.validate(source.materials.len(), source.objects.len()).map_err(mesh_error)?;
    let mut scene = Scene {
        mesh,
        materials: source.materials,
        textures: source.textures.into_iter().map(Into::into).collect(),
        objects: source.objects,
        cameras: source.cameras,
        lights: source.lights,
        variants,
        part_opacities: Vec::new(),
        placed: Vec::new(),
        hidden: BTreeMap::new(),
        clip_time: None,
        origin: source.origin.unwrap_or_default(),
    };
    tell_apart(&mut scene);
    aim_at_the_center(&mut scene);
    ranges::keep_in_range(&mut scene, &mut report.warnings);
    Ok(Imported { scene, report })
}

/// Gives objects, materials and cameras of equal names different ones: names select them.
fn tell_apart(scene: &mut Scene) {
    fn each<T>(items: &mut [T], name: fn(&mut T) -> &mut String) {
        let names = told_apart(items.iter_mut().map(|item| name(item).clone()).collect());
        items.iter_mut().zip(names).for_each(|(item, apart)| *name(item) = apart);
    }
    each(&mut scene.objects, |object| &mut object.name);
    each(&mut scene.materials, |material| &mut material.name);
    each(&mut scene.cameras, |camera| &mut camera.name);
}

/// Moves the targets of cameras and lights along their axes to the depth of the scene's center. Orbiting then turns
/// about it, and handles lie in the scene.
fn aim_at_the_center(scene: &mut Scene) {
    let bounds = scene.mesh.bounds();
    let aimed = |from: Vec3, target: Vec3| {
        let forward = (target - from).normalize_or(Vec3::NEG_Z);
        let depth = (bounds.center() - from).dot(forward);
        from + forward * if depth > 0.0 { depth } else { bounds.diagonal() }
    };
    for camera in &mut scene.cameras {
        camera.target = aimed(camera.eye, camera.target);
    }
    for light in scene.lights.iter_mut().filter(|light| light.emission.is_aimed()) {
        light.target = aimed(light.position, light.target);
    }
}
