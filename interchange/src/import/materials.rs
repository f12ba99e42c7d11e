//! Materials in separate files, JSON or MaterialX documents.

use super::{
    fields,
    files::{Files, Trouble},
    ranges::{material_warning, repair_material},
    textures::sanitized,
};
use crate::{
    image::{file_and_layer, footprint},
    import::{
        files::read_file,
        report::{ImportError, ImportOptions, ImportReport},
    },
    material_file::{MaterialFile, SlotFile},
    materialx::{self, Expanded, Library, MaterialXError, ReadMaterial},
};
use lapidary_core::{
    brdf::{BrdfFile, Content},
    image::ImageError,
    input,
    material::{Material, map_color_space},
    scene::Scene,
    texture::{ColorSpace, Procedural, Texture, TextureSlot},
};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Splits a material's path into file and material name. A MaterialX document holds several materials, and
/// `FILE.mtlx#NAME` is one of them.
pub fn material_in_file(path: &Path) -> (&Path, Option<&str>) {
    let split = path.to_str().filter(|_| !path.is_file()).and_then(|text| text.rsplit_once('#'));
    match split {
        Some((file, name)) if is_materialx(Path::new(file)) => (Path::new(file), Some(name)),
        _ => (path, None),
    }
}

/// Names of the materials in a MaterialX document, if the path names none of them; empty for other files, and for unreadable ones.
pub fn materials_in_file(path: &Path) -> Vec<String> {
    let (file, wanted) = material_in_file(path);
    if wanted.is_some() || !is_materialx(file) {
        return Vec::new();
    }
    let names = || {
        let mut files = Files::beside(file, &ImportOptions::default());
        let Expanded { text, .. } = whole_document(input::read_text(file).ok()?, &mut files).ok()?;
        materialx::names(&text).ok()
    };
    names().unwrap_or_default()
}

/// A MaterialX document with all documents that it includes.
fn whole_document(text: String, files: &mut Files) -> Result<Expanded, MaterialXError> {
    materialx::expanded(text, files)
}

impl Library for Files {
    fn read(&mut self, path: &str) -> Result<String, String> {
        let reason = |trouble| match trouble {
            Trouble::Reason(reason) => reason,
            Trouble::Outside(_) => "it is outside the folder of the document".into(),
            Trouble::Memory(_) => NO_ROOM.into(),
        };
        let bytes = self.find_at(path).and_then(|found| Files::read(self, &found)).map_err(reason)?;
        let text = input::text(&bytes).map_err(|error| error.to_string())?;
        String::from_utf8(text.into_owned()).map_err(|_| "it is not text".into())
    }

    fn take(&mut self, bytes: usize) -> Result<(), String> {
        self.budget.take(bytes as u64).map_err(|_| NO_ROOM.into())
    }
}

/// Why a document is left out whose text exceeds the budget.
const NO_ROOM: &str = "it does not fit into the memory";

/// Whether a file is a MaterialX document, by its extension.
pub fn is_materialx(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mtlx"))
}

/// Reads a material file, JSON or MaterialX ([`material_in_file`]), and adds its pictures to the textures of `scene`
/// unless they are already present. Also returns remarks, in sentences.
///
/// # Errors
/// A file or picture that is unreadable or not allowed, or contents that are not a material. The scene is then unchanged.
pub fn load_material(
    path: &Path,
    scene: &mut Scene,
    options: &ImportOptions,
) -> Result<(Material, Vec<String>), ImportError> {
    let before = scene.textures.len();
    let (path, wanted) = material_in_file(path);
    let mut loader =
        MaterialLoader { path, scene, files: Files::beside(path, options), report: ImportReport::default() };
    let loaded = loader.load(wanted);
    let MaterialLoader { files, mut report, .. } = loader;
    files.tell(&mut report);
    match loaded {
        Ok(material) => Ok((material, report.warnings)),
        Err(error) => {
            scene.textures.truncate(before);
            Err(error)
        }
    }
}

/// The existing pictures that a material file names; empty for an unreadable file.
pub fn pictures_of_material(path: &Path) -> Vec<PathBuf> {
    let (path, wanted) = material_in_file(path);
    let text = input::read_text(path).ok();
    let mut files = Files::beside(path, &ImportOptions::default());
    let read = text.and_then(|text| contents(path, text.as_bytes(), wanted, &mut files).ok()).map(|read| read.material);
    // The file that a name refers to depends on whether files outside are allowed.
    let found = [false, true].into_iter().flat_map(|allow_outside| {
        let mut files = Files::beside(path, &ImportOptions { allow_outside, ..Default::default() });
        let slots = read.iter().flat_map(|file| file.maps.slots());
        let brdf = read.iter().flat_map(|material| &material.file).map(|file| file.path.to_string_lossy());
        let names: Vec<_> = slots.filter_map(SlotFile::picture).map(Into::into).chain(brdf).collect();
        names.into_iter().filter_map(move |name| Some(file_and_layer(&files.find(&name).ok()?).0.to_path_buf()))
    });
    found.collect::<BTreeSet<_>>().into_iter().collect()
}

/// The contents of a material file.
fn contents(path: &Path, bytes: &[u8], wanted: Option<&str>, files: &mut Files) -> Result<ReadMaterial, ImportError> {
    let parse_error = |format, reason| ImportError::Parse { path: path.into(), format, reason };
    if is_materialx(path) {
        let text = std::str::from_utf8(bytes).map_err(|e| parse_error("MaterialX", e.to_string()))?;
        let read = whole_document(text.into(), files).and_then(|document| materialx::read_expanded(document, wanted));
        return read.map_err(|error| match error {
            MaterialXError::NoSuchMaterial { .. } => ImportError::NoSuchMaterial { path: path.into(), source: error },
            other => parse_error("MaterialX", other.to_string()),
        });
    }
    let mut material: MaterialFile = fields::parse(bytes).map_err(|reason| parse_error("a material", reason))?;
    if material.file.is_some() && !material.model.has_file() {
        // The file belongs to an earlier model, as do its declarations.
        material = MaterialFile { file: None, ..material.own() };
    }
    Ok(ReadMaterial { material, remarks: Vec::new() })
}

struct MaterialLoader<'a> {
    path: &'a Path,
    scene: &'a mut Scene,
    files: Files,
    report: ImportReport,
}

impl MaterialLoader<'_> {
    fn load(&mut self, wanted: Option<&str>) -> Result<Material, ImportError> {
        let path = self.path;
        let bytes = read_file(path, &mut self.files)?;
        let ReadMaterial { material: file, remarks } = contents(path, &bytes, wanted, &mut self.files)?;
        if let Some((map, _)) = file.maps.iter().find(|(_, slot)| slot.picture() == Some("")) {
            let reason = format!("the map `{map}` names neither a `file` nor a `procedural`");
            return Err(self.unread(Trouble::Reason(reason), ""));
        }
        self.report.warnings.extend(remarks);
        self.check_outside(&file)?;
        let maps = file.maps.try_map(|kind, slot: &SlotFile| self.slot(slot, map_color_space(kind)))?;
        let mut material = file.with_maps(maps);
        material.file = file.file.as_ref().map(|file| self.brdf(file)).transpose()?;
        if material.name.is_empty() {
            material.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        if repair_material(&mut material) {
            self.report.warnings.push(material_warning(std::slice::from_ref(&material.name)));
        }
        Ok(material)
    }

    /// Names all disallowed pictures at once.
    fn check_outside(&mut self, file: &MaterialFile) -> Result<(), ImportError> {
        let mut names: Vec<String> = file.maps.slots().filter_map(SlotFile::picture).map(str::to_owned).collect();
        names.extend(file.file.as_ref().map(|file| file.path.to_string_lossy().into_owned()));
        names.sort();
        names.dedup();
        names.retain(|name| matches!(self.files.find(name), Err(Trouble::Outside(_))));
        if names.is_empty() { Ok(()) } else { Err(ImportError::Outside { path: self.path.into(), names }) }
    }

    /// Reads the file of its BRDF.
    fn brdf(&mut self, file: &BrdfFile) -> Result<BrdfFile, ImportError> {
        let name = file.path.to_string_lossy();
        let failed = |reason: String| ImportError::Parse { path: self.path.into(), format: "a material", reason };
        let path = match self.files.find(&name) {
            Ok(path) => path,
            Err(Trouble::Reason(reason)) => return Err(failed(format!("its BRDF {name}: {reason}"))),
            Err(other) => return Err(other.at(self.path, "a material")),
        };
        let (content, remarks) = Content::read(&path).map_err(|error| failed(error.to_string()))?;
        self.report.warnings.extend(remarks);
        Ok(BrdfFile { path, content: Some(content) })
    }

    fn slot(&mut self, slot: &SlotFile, default_space: ColorSpace) -> Result<TextureSlot, ImportError> {
        Ok(TextureSlot {
            texture: slot.picture().map(|name| self.texture(name)).transpose()?.unwrap_or_default(),
            color_space: slot.color_space.unwrap_or(default_space),
            channel: slot.channel,
            scale: slot.scale,
            offset: slot.offset,
            rotation: slot.rotation_degrees.to_radians(),
            strength: slot.strength,
            flip_y: slot.flip_y,
            procedural: slot.procedural.map(Procedural::sanitized),
            wrap: slot.wrap,
            uv_set: slot.uv_set,
        })
    }

    fn texture(&mut self, name: &str) -> Result<u32, ImportError> {
        let found = self.files.find(name).map_err(|trouble| self.unread(trouble, name))?;
        let (file, layer) = file_and_layer(&found);
        let bytes = self.files.read(&found).map_err(|trouble| self.unread(trouble, name))?;
        if let Some(known) = self.known(&bytes).filter(|_| layer.is_none()) {
            return Ok(known);
        }
        let failed = |source| ImportError::Map { path: self.path.into(), source };
        let footprint = footprint(&bytes, file).map_err(failed)?;
        self.files.budget.take_picture(bytes.len(), footprint).map_err(|over| over.at(self.path))?;
        let mut texture = self.files.decode(&bytes, file, layer).map_err(failed)?;
        texture.name = name.to_owned();
        if let Some(known) = self.known(&texture.encoded) {
            return Ok(known);
        }
        self.report.warnings.extend(sanitized(&mut texture));
        self.scene.textures.push(texture.into());
        Ok(self.scene.textures.len() as u32 - 1)
    }

    /// The texture with these bytes, if there is one.
    fn known(&self, encoded: &[u8]) -> Option<u32> {
        let same = |texture: &Arc<Texture>| !encoded.is_empty() && *texture.encoded == *encoded;
        self.scene.textures.iter().position(same).map(|index| index as u32)
    }

    /// The error of an unread picture.
    fn unread(&self, trouble: Trouble, name: &str) -> ImportError {
        match trouble {
            Trouble::Reason(reason) => {
                let source =
                    ImageError::Io { action: "read", path: name.into(), source: std::io::Error::other(reason) };
                ImportError::Map { path: self.path.into(), source }
            }
            other => other.at(self.path, "a material"),
        }
    }
}

#[cfg(test)]
mod tests;
