//! A target for each kind of file.

mod checkpoint;
mod files;
mod scenes;

use crate::{
    choices::Choices,
    mutate::{self, containers, json, tensors, text, xml},
};
use files::{FileKind, FileTarget};
use std::{io, panic::RefUnwindSafe, path::Path};

/// A reader, and a generator of its inputs.
pub trait Target: Sync + RefUnwindSafe {
    /// Its name, as in `--target` and in the folder `corpus`.
    fn name(&self) -> &str;

    /// Inputs of a thousand for this target: fewer if an input takes longer.
    fn share(&self) -> u64;

    /// Writes the parts that are common to all inputs.
    ///
    /// # Errors
    /// Errors of the file system.
    fn prepare(&self, folder: &Path) -> io::Result<()>;

    /// Writes the input determined by `choices`.
    ///
    /// # Errors
    /// Errors of the file system.
    fn write(&self, choices: &mut Choices, folder: &Path) -> io::Result<()>;

    /// Reads the input in the folder, and uses its contents.
    ///
    /// # Errors
    /// A description of the fault if the input is neither read correctly nor refused clearly.
    fn read(&self, folder: &Path) -> Result<(), String>;
}

/// All targets, in the order in which they run.
pub fn all() -> Vec<Box<dyn Target>> {
    let file = |target: FileTarget| -> Box<dyn Target> { Box::new(target) };
    let mut all: Vec<_> = FILES.into_iter().map(FileTarget::new).map(file).collect();
    all.push(Box::<checkpoint::Checkpoint>::default());
    all
}

/// Targets of one file.
const FILES: [FileKind; 20] = [
    FileKind { name: "obj", share: 110, file: "input.obj", mutation: text::text, read: scenes::import_file },
    FileKind { name: "mtl", share: 50, file: "input.mtl", mutation: text::text, read: scenes::import_with_materials },
    FileKind { name: "gltf", share: 130, file: "input.gltf", mutation: json::json, read: scenes::import_file },
    FileKind { name: "glb", share: 80, file: "input.glb", mutation: containers::glb, read: scenes::import_file },
    FileKind { name: "ply", share: 90, file: "input.ply", mutation: containers::ply, read: scenes::import_file },
    FileKind { name: "png", share: 70, file: "input.png", mutation: containers::png, read: files::read_picture },
    FileKind { name: "jpg", share: 40, file: "input.jpg", mutation: mutate::bytes, read: files::read_picture },
    FileKind { name: "tga", share: 40, file: "input.tga", mutation: mutate::bytes, read: files::read_picture },
    FileKind { name: "webp", share: 20, file: "input.webp", mutation: mutate::bytes, read: files::read_picture },
    FileKind { name: "tif", share: 20, file: "input.tif", mutation: mutate::bytes, read: files::read_picture },
    FileKind { name: "ktx2", share: 20, file: "input.ktx2", mutation: mutate::bytes, read: files::read_picture },
    FileKind { name: "hdr", share: 60, file: "input.hdr", mutation: mutate::bytes, read: files::read_picture },
    FileKind { name: "exr", share: 60, file: "input.exr", mutation: mutate::bytes, read: files::read_picture },
    FileKind { name: "lights", share: 60, file: "input.json", mutation: json::json, read: scenes::read_lights },
    FileKind { name: "material", share: 40, file: "input.json", mutation: json::json, read: scenes::read_material },
    FileKind { name: "materialx", share: 30, file: "input.mtlx", mutation: xml::xml, read: scenes::read_material },
    FileKind { name: "wgsl", share: 20, file: "input.wgsl", mutation: text::text, read: files::read_brdf },
    FileKind { name: "session", share: 60, file: "input.lapidary", mutation: json::json, read: files::read_session },
    FileKind { name: "cuts", share: 8, file: "input.cuts", mutation: tensors::dataset, read: scenes::read_dataset },
    FileKind { name: "bake", share: 1, file: "input.gltf", mutation: json::quantities, read: scenes::bake_file },
];

/// Checks that an error names the file, as all must.
fn named(error: &dyn std::fmt::Display, file: &Path) -> Result<(), String> {
    let text = error.to_string();
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    if text.contains(&*name) { Ok(()) } else { Err(format!("the error does not name {name}: {text}")) }
}
