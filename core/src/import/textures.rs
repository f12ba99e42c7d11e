//! Textures of an import: found as artists' files name them, loaded once each, replaced visibly where missing.

use crate::{image::decode, input, texture::Texture};
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

/// The textures that an import has loaded so far.
pub(super) struct TextureLibrary {
    folder: PathBuf,
    pub textures: Vec<Texture>,
    by_source: HashMap<String, u32>,
    pub warnings: Vec<String>,
}

impl TextureLibrary {
    /// For a scene file at `path`: names are relative to its folder.
    pub fn beside(path: &Path) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Self { folder, textures: Vec::new(), by_source: HashMap::new(), warnings: Vec::new() }
    }

    /// Index of the texture in the file that a scene calls `name`.
    pub fn load(&mut self, name: &str) -> u32 {
        let found = find_file(&self.folder, name);
        let source = found.as_ref().map_or(name.to_owned(), |path| path.to_string_lossy().into_owned());
        self.load_with(&source, name, || {
            let path = found.ok_or("there is no such file beside the scene")?;
            let bytes = input::read(&path).map_err(|e| e.to_string())?;
            decode(&bytes, &path).map_err(|e| e.to_string())
        })
    }

    /// Index of the texture that `read` yields, unless one of the same `source` is there already.
    pub fn load_with(&mut self, source: &str, name: &str, read: impl FnOnce() -> Result<Texture, String>) -> u32 {
        if let Some(&index) = self.by_source.get(source) {
            return index;
        }
        let texture = read().unwrap_or_else(|reason| {
            self.warnings.push(format!(
                "the texture \"{name}\" was replaced by a magenta chequerboard because it cannot be read: {reason}; \
                 put the file in place and import again"
            ));
            Texture::missing(name)
        });
        let index = self.textures.len() as u32;
        self.textures.push(Texture { name: name.to_owned(), ..texture });
        self.by_source.insert(source.to_owned(), index);
        index
    }
}

/// The file in `folder` that `name` refers to, with either kind of slash and in any case. For paths of another machine
/// the file's name alone counts.
pub(super) fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.trim().trim_matches('"').replace('\\', "/");
    let exact = folder.join(&name);
    if exact.is_file() {
        return Some(exact);
    }
    let last = name.rsplit('/').next().unwrap_or(&name);
    ignoring_case(folder, &name).or_else(|| ignoring_case(folder, last)).filter(|path| path.is_file())
}

/// Follows the parts of `name` from `folder`, each by exact name or else by the same name in another case.
fn ignoring_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut at = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_path_buf() };
    for part in name.split('/').filter(|p| !p.is_empty() && *p != ".") {
        let exact = at.join(part);
        at = if exact.exists() {
            exact
        } else {
            let mut entries: Vec<_> = std::fs::read_dir(&at).ok()?.flatten().map(|e| e.file_name()).collect();
            entries.sort();
            let same = |entry: &std::ffi::OsString| entry.to_string_lossy().to_lowercase() == part.to_lowercase();
            at.join(entries.into_iter().find(same)?)
        };
    }
    Some(at)
}
