//! Access to the files that a scene or material file names. They are found in spite of artists' naming habits, and read
//! only from the file's folder unless the user allows others. A foreign file could otherwise copy any picture of the
//! machine into a dataset that is then shared.

use super::budget::{Budget, OverBudget};
use crate::{
    image::{decode_with, file_and_layer, name_of, split, with_layer},
    import::report::{ImportError, ImportOptions, ImportReport},
    names::listed,
};
use lapidary_core::{image::ImageError, input, memory, texture::Texture};
use std::{
    borrow::Cow,
    collections::{BTreeSet, HashMap},
    ffi::OsString,
    io::ErrorKind,
    path::{Path, PathBuf},
};
use unicode_normalization::UnicodeNormalization;

/// Why a named or embedded file is not read.
pub(super) enum Trouble {
    /// A description of the problem.
    Reason(String),
    /// The file of this name is outside the folder.
    Outside(String),
    /// The memory does not suffice.
    Memory(OverBudget),
}

impl From<String> for Trouble {
    fn from(reason: String) -> Self {
        Self::Reason(reason)
    }
}

impl From<&str> for Trouble {
    fn from(reason: &str) -> Self {
        Self::Reason(reason.into())
    }
}

impl From<OverBudget> for Trouble {
    fn from(over: OverBudget) -> Self {
        Self::Memory(over)
    }
}

impl From<ImageError> for Trouble {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::Memory { needed, available, .. } => {
                Self::Memory(OverBudget::new(needed * 1_000_000, available * 1_000_000))
            }
            other => Self::Reason(other.to_string()),
        }
    }
}

impl Trouble {
    /// The error of a file at `path` in a format that cannot do without the unread part.
    pub fn at(self, path: &Path, format: &'static str) -> ImportError {
        match self {
            Self::Reason(reason) => ImportError::Parse { path: path.into(), format, reason },
            Self::Outside(name) => ImportError::Outside { path: path.into(), names: vec![name] },
            Self::Memory(over) => over.at(path),
        }
    }
}

/// Allowed files and memory for an import.
pub(super) struct Files {
    folder: PathBuf,
    allow_outside: bool,
    pub budget: Budget,
    /// Names of files outside the folder.
    outside: BTreeSet<String>,
    listings: Listings,
    /// The files read so far.
    read: Vec<PathBuf>,
    /// Sentences on what of pictures is left out.
    remarks: Vec<String>,
}

impl Files {
    /// Access for a file at `path`: names are relative to its folder.
    pub fn beside(path: &Path, options: &ImportOptions) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let budget = Budget::new(options.budget);
        Self {
            folder,
            allow_outside: options.allow_outside,
            budget,
            outside: BTreeSet::new(),
            listings: Listings::default(),
            read: Vec::new(),
            remarks: Vec::new(),
        }
    }

    /// The file that `name` refers to, or the layer of it that it names ([`file_and_layer`]), with either kind of slash and in
    /// any case. If its path leads nowhere, or outside, only the file's name counts. This finds files with another machine's
    /// paths, and files copied into the folder.
    pub fn find(&mut self, name: &str) -> Result<PathBuf, Trouble> {
        let name = name.trim().trim_matches('"');
        let found = self.candidates(name);
        match split(name) {
            Some((file, layer)) if found.is_empty() => {
                let found = self.candidates(file);
                self.allowed(file, found).map(|file| with_layer(&file, layer))
            }
            _ => self.allowed(name, found),
        }
    }

    /// The files that `name` may refer to, the best first.
    fn candidates(&mut self, name: &str) -> Vec<PathBuf> {
        let parts = name.replace('\\', "/");
        let last = parts.rsplit('/').next().unwrap_or(&parts);
        let named = self.listings.file(&self.folder, &parts);
        let beside = if last == parts { None } else { self.listings.file(&self.folder, last) };
        named.into_iter().chain(beside).collect()
    }

    /// The file at the path `name` from the folder, in any case.
    pub fn find_at(&mut self, name: &str) -> Result<PathBuf, Trouble> {
        let named = self.listings.file(&self.folder, name);
        self.allowed(name, named.into_iter().collect())
    }

    /// The first of some files that is allowed.
    fn allowed(&mut self, name: &str, found: Vec<PathBuf>) -> Result<PathBuf, Trouble> {
        if found.is_empty() {
            return Err("there is no such file beside it".into());
        }
        let is_inside = |path: &PathBuf| input::is_inside(&self.folder, path);
        let chosen = found.iter().find(|path| self.allow_outside || is_inside(path));
        if !chosen.is_some_and(is_inside) {
            self.outside.insert(name.to_owned());
        }
        chosen.cloned().ok_or_else(|| Trouble::Outside(name.to_owned()))
    }

    /// The contents of a found file.
    pub fn read(&mut self, path: &Path) -> Result<Vec<u8>, Trouble> {
        let (path, _) = file_and_layer(path);
        let length = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
        self.budget.take(length)?;
        self.read.push(path.into());
        input::read(path).map_err(|error| match error.kind() {
            ErrorKind::OutOfMemory => OverBudget::new(length, memory::available().unwrap_or(0)).into(),
            _ => error.to_string().into(),
        })
    }

    /// Decodes a picture that fits the budget. What its header says and cannot be used becomes a warning.
    pub fn decode(&mut self, bytes: &[u8], path: &Path, layer: Option<&str>) -> Result<Texture, ImageError> {
        let mut remarks = Vec::new();
        let texture = decode_with(bytes, path, layer, &mut remarks)?;
        let name = name_of(path, layer);
        self.remarks.extend(remarks.into_iter().map(|remark| format!("the picture \"{name}\": {remark}")));
        Ok(texture)
    }

    /// Reports the files read, what of pictures is left out, and the files outside. Unread ones are also reported where they are
    /// missed.
    pub fn tell(self, report: &mut ImportReport) {
        report.files.extend(self.read);
        report.warnings.extend(self.remarks);
        if self.outside.is_empty() {
            return;
        }
        report.outside = self.outside.into_iter().collect();
        let names = listed(&report.outside);
        report.warnings.push(if self.allow_outside {
            format!(
                "the files {names} are outside the folder of the file that names them, and were read, as was allowed"
            )
        } else {
            format!(
                "the files {names} are outside the folder of the file that names them, and were not read; put them \
                 beside it, or allow files outside the folder"
            )
        });
    }
}

/// A file name in one case and one Unicode form: macOS writes accents apart from their letters, other systems with them.
fn comparable(name: &str) -> String {
    name.nfc().collect::<String>().to_lowercase()
}

/// Reads the imported file, within its memory budget and without a byte order mark.
pub(super) fn read_file(path: &Path, files: &mut Files) -> Result<Vec<u8>, ImportError> {
    let io_error = |source| ImportError::Io { path: path.into(), source };
    let bytes = input::read(path).map_err(io_error)?;
    files.budget.take(bytes.len() as u64).map_err(|over| over.at(path))?;
    let without_mark = match input::text(&bytes).map_err(io_error)? {
        Cow::Borrowed(text) if text.len() == bytes.len() => None,
        text => {
            files.budget.take(text.len() as u64).map_err(|over| over.at(path))?;
            Some(text.into_owned())
        }
    };
    Ok(without_mark.unwrap_or(bytes))
}

/// The entries of folders by their comparable names, cached: listing a folder for each missing name would take long.
#[derive(Default)]
struct Listings(HashMap<PathBuf, HashMap<String, OsString>>);

impl Listings {
    /// The file at the path `name` from `folder`.
    fn file(&mut self, folder: &Path, name: &str) -> Option<PathBuf> {
        let exact = folder.join(name);
        if exact.is_file() {
            return Some(exact);
        }
        self.ignoring_case(folder, name).filter(|path| path.is_file())
    }

    /// Follows the parts of `name` from `folder`, each by exact name or else by the same name in another case.
    fn ignoring_case(&mut self, folder: &Path, name: &str) -> Option<PathBuf> {
        let mut at = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_path_buf() };
        for part in name.split('/').filter(|p| !p.is_empty() && *p != ".") {
            let exact = at.join(part);
            at = if exact.exists() { exact } else { at.join(self.entries(&at).get(&comparable(part))?) };
        }
        Some(at)
    }

    fn entries(&mut self, folder: &Path) -> &HashMap<String, OsString> {
        self.0.entry(folder.into()).or_insert_with(|| {
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            let mut names: Vec<OsString> = entries.map(|entry| entry.file_name()).collect();
            // Of names that differ only in case, the first in order is kept.
            names.sort_by(|a, b| b.cmp(a));
            names.into_iter().map(|name| (comparable(&name.to_string_lossy()), name)).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_split_once_however_often_it_could_be() {
        let folder = tempfile::tempdir().unwrap();
        let mut files = Files::beside(&folder.path().join("a.obj"), &Default::default());
        assert!(matches!(files.find(&"a.exr#".repeat(10_000)), Err(Trouble::Reason(_))));
        std::fs::write(folder.path().join("a.exr#b.exr"), b"").unwrap();
        let mut files = Files::beside(&folder.path().join("a.obj"), &Default::default());
        let found = files.find("\"maps/a.exr#B.exr#c\"").ok();
        assert_eq!(found, Some(folder.path().join("a.exr#b.exr#c")));
    }

    #[test]
    fn a_picture_without_room_is_a_matter_of_memory_and_a_damaged_one_is_not() {
        let path = PathBuf::from("a.png");
        let over = Trouble::from(ImageError::Memory { path: path.clone(), needed: 5, available: 4 });
        assert!(matches!(over, Trouble::Memory(over) if over == OverBudget::new(5_000_000, 4_000_000)));
        assert!(matches!(Trouble::from(ImageError::Decode { path, reason: "x".into() }), Trouble::Reason(_)));
    }
}
