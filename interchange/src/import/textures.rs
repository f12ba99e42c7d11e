//! Textures of an import: each loaded once, and replaced visibly if missing.

use super::files::{Files, Trouble};
use crate::{
    image::footprint,
    import::{report::ImportReport, source::Source},
};
use lapidary_core::texture::Texture;
use std::{collections::HashMap, path::Path};

/// The textures loaded so far by an import.
pub(super) struct TextureLibrary {
    pub files: Files,
    pub textures: Vec<Texture>,
    by_source: HashMap<String, u32>,
    report: ImportReport,
}

impl TextureLibrary {
    /// An empty library; `files` finds the textures.
    pub fn new(files: Files) -> Self {
        Self { files, textures: Vec::new(), by_source: HashMap::new(), report: ImportReport::default() }
    }

    /// Index of the texture in the file that a scene calls `name`.
    ///
    /// # Errors
    /// [`Trouble::Memory`].
    pub fn load(&mut self, name: &str) -> Result<u32, Trouble> {
        let found = self.files.find(name);
        let source = found.as_ref().map_or(name.to_owned(), |path| path.to_string_lossy().into_owned());
        self.load_with(&source, name, |files| {
            let path = found?;
            let bytes = files.read(&path)?;
            read_picture(&bytes, &path, files)
        })
    }

    /// Index of the texture that `read` yields, unless one of the same `source` is already present.
    ///
    /// # Errors
    /// [`Trouble::Memory`].
    pub fn load_with(
        &mut self,
        source: &str,
        name: &str,
        read: impl FnOnce(&mut Files) -> Result<Texture, Trouble>,
    ) -> Result<u32, Trouble> {
        if let Some(&index) = self.by_source.get(source) {
            return Ok(index);
        }
        let reason = match read(&mut self.files) {
            Ok(texture) => return Ok(self.push(source, Texture { name: name.to_owned(), ..texture })),
            Err(Trouble::Memory(over)) => return Err(Trouble::Memory(over)),
            Err(Trouble::Outside(_)) => "it is outside the folder of the scene".into(),
            Err(Trouble::Reason(reason)) => reason,
        };
        self.files.budget.take_names(1)?;
        let warning = format!(
            "the texture \"{name}\" was replaced by a magenta chequerboard because it cannot be read: {reason}; \
             put the file in place and import again"
        );
        self.report.unread.push(warning.clone());
        self.report.warnings.push(warning);
        Ok(self.push(source, Texture::missing(name)))
    }

    fn push(&mut self, source: &str, mut texture: Texture) -> u32 {
        self.report.warnings.extend(sanitized(&mut texture));
        let index = self.textures.len() as u32;
        self.textures.push(texture);
        self.by_source.insert(source.to_owned(), index);
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

/// Decodes a picture within the memory budget.
pub(super) fn read_picture(bytes: &[u8], path: &Path, files: &mut Files) -> Result<Texture, Trouble> {
    let footprint = footprint(bytes, path).map_err(|e| e.to_string())?;
    files.budget.take_picture(bytes.len(), footprint)?;
    Ok(files.decode(bytes, path)?)
}
