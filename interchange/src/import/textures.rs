//! Textures of an import: each loaded once, and replaced visibly if missing.

use super::files::{Files, Trouble};
use crate::{
    image::{file_and_layer, footprint},
    import::{report::ImportReport, source::Source},
};
use lapidary_core::texture::Texture;
use std::{
    collections::{HashMap, HashSet},
    path::Path,
};

/// The textures loaded so far by an import.
pub(super) struct TextureLibrary {
    pub files: Files,
    pub textures: Vec<Texture>,
    /// The indices of textures, and why others cannot be read.
    by_source: HashMap<String, Result<u32, String>>,
    /// The indices of what is shown for unread ones.
    missing: HashMap<String, u32>,
    /// Unread ones for which another texture is shown.
    replaced: HashSet<(String, u32)>,
    report: ImportReport,
}

/// A texture that cannot be read.
pub(super) struct Unread {
    source: String,
    name: String,
    reason: String,
}

impl TextureLibrary {
    /// An empty library; `files` finds the textures.
    pub fn new(files: Files) -> Self {
        let (by_source, missing, replaced) = (HashMap::new(), HashMap::new(), HashSet::new());
        Self { files, textures: Vec::new(), by_source, missing, replaced, report: ImportReport::default() }
    }

    /// Index of the texture in the file that a scene calls `name`; it may be missing.
    ///
    /// # Errors
    /// [`Trouble::Memory`].
    pub fn load(&mut self, name: &str) -> Result<u32, Trouble> {
        match self.try_load(name)? {
            Ok(index) => Ok(index),
            Err(unread) => self.missing(unread),
        }
    }

    /// Index of the texture in the file that a scene calls `name`.
    ///
    /// # Errors
    /// [`Trouble::Memory`].
    pub fn try_load(&mut self, name: &str) -> Result<Result<u32, Unread>, Trouble> {
        let found = self.files.find(name);
        let source = found.as_ref().map_or(name.to_owned(), |path| path.to_string_lossy().into_owned());
        self.try_load_with(&source, name, |files| {
            let path = found?;
            let bytes = files.read(&path)?;
            let (file, layer) = file_and_layer(&path);
            read_picture(&bytes, file, layer, files)
        })
    }

    /// Index of the texture that `read` yields, unless one of the same `source` is already present.
    ///
    /// # Errors
    /// [`Trouble::Memory`].
    pub fn try_load_with(
        &mut self,
        source: &str,
        name: &str,
        read: impl FnOnce(&mut Files) -> Result<Texture, Trouble>,
    ) -> Result<Result<u32, Unread>, Trouble> {
        let unread = |reason: &String| Unread { source: source.into(), name: name.into(), reason: reason.clone() };
        if let Some(known) = self.by_source.get(source) {
            return Ok(known.as_ref().map(|index| *index).map_err(unread));
        }
        let read = match read(&mut self.files) {
            Ok(texture) => Ok(self.push(Texture { name: name.to_owned(), ..texture })),
            Err(Trouble::Memory(over)) => return Err(Trouble::Memory(over)),
            Err(Trouble::Outside(_)) => Err("it is outside the folder of the scene".to_owned()),
            Err(Trouble::Reason(reason)) => Err(reason),
        };
        let result = read.as_ref().map(|index| *index).map_err(unread);
        self.by_source.insert(source.to_owned(), read);
        Ok(result)
    }

    /// Index of a texture that shows visibly that one is missing.
    ///
    /// # Errors
    /// [`Trouble::Memory`].
    pub fn missing(&mut self, Unread { source, name, reason }: Unread) -> Result<u32, Trouble> {
        if let Some(&index) = self.missing.get(&source) {
            return Ok(index);
        }
        self.files.budget.take_names(1)?;
        let warning = format!(
            "the texture \"{name}\" was replaced by a magenta chequerboard because it cannot be read: {reason}; \
             put the file in place and import again"
        );
        self.report.unread.push(warning.clone());
        self.report.warnings.push(warning);
        let index = self.push(Texture::missing(&name));
        self.missing.insert(source, index);
        Ok(index)
    }

    /// Reports once that the texture at `index` is shown for an unread one.
    pub fn replaced(&mut self, Unread { source, name, reason }: Unread, index: u32) {
        if self.replaced.insert((source, index)) {
            let shown = &self.textures[index as usize].name;
            self.report.warnings.push(format!(
                "the texture \"{name}\" cannot be read: {reason}; \"{shown}\" is shown, which the file has for other programs"
            ));
        }
    }

    fn push(&mut self, mut texture: Texture) -> u32 {
        self.report.warnings.extend(sanitized(&mut texture));
        let index = self.textures.len() as u32;
        self.textures.push(texture);
        index
    }

    /// Moves the textures and the remarks to `source`.
    pub fn finish(mut self, source: &mut Source) {
        self.files.tell(&mut self.report);
        source.textures = self.textures;
        source.warnings.append(&mut self.report.warnings);
        source.unread.append(&mut self.report.unread);
        source.outside = self.report.outside;
        source.files = self.report.files;
    }
}

/// Clamps the texels of a texture; returns a remark if any changed.
pub fn sanitized(texture: &mut Texture) -> Option<String> {
    let changed = texture.texels.sanitize();
    (changed > 0).then(|| {
        format!(
            "{changed} texels of the texture \"{}\" are not finite or beyond the range of 16-bit floats, and were replaced; \
             save the picture without clipped or empty pixels",
            texture.name
        )
    })
}

/// Decodes a picture, or a layer of it, within the memory budget.
pub(super) fn read_picture(
    bytes: &[u8],
    path: &Path,
    layer: Option<&str>,
    files: &mut Files,
) -> Result<Texture, Trouble> {
    let footprint = footprint(bytes, path).map_err(|e| e.to_string())?;
    files.budget.take_picture(bytes.len(), footprint)?;
    Ok(files.decode(bytes, path, layer)?)
}
