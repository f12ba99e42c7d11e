//! The files that a scene or a material file names: found as artists' files name them, and read only from the folder of the
//! file unless the user allows others. A file from a stranger could otherwise put any picture of the reader's machine into
//! a dataset that is then passed on.

use super::{
    ImportError, ImportOptions, ImportReport,
    budget::{Budget, OverBudget},
    listed,
};
use crate::input;
use std::path::{Path, PathBuf};

/// Why something that a file names or holds is not read.
pub(super) enum Trouble {
    /// What is wrong, in words.
    Reason(String),
    /// The file of this name is outside the folder.
    Outside(String),
    /// There is no room.
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

impl Trouble {
    /// The error of a file at `path` of a format that cannot do without what is not read.
    pub fn at(self, path: &Path, format: &'static str) -> ImportError {
        match self {
            Self::Reason(reason) => ImportError::Parse { path: path.into(), format, reason },
            Self::Outside(name) => ImportError::Outside { path: path.into(), names: vec![name] },
            Self::Memory(over) => over.at(path),
        }
    }
}

/// What may be read for a file, and the memory for it.
pub(super) struct Files {
    folder: PathBuf,
    allow_outside: bool,
    pub budget: Budget,
    /// Names of files outside the folder, each once.
    outside: Vec<String>,
    /// The files that were read.
    read: Vec<PathBuf>,
}

impl Files {
    /// For a file at `path`: names are relative to its folder.
    pub fn beside(path: &Path, options: &ImportOptions) -> Self {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let budget = Budget::new(options.budget);
        Self { folder, allow_outside: options.allow_outside, budget, outside: Vec::new(), read: Vec::new() }
    }

    /// The file of a name.
    pub fn find(&mut self, name: &str) -> Result<PathBuf, Trouble> {
        let path = find_file(&self.folder, name).ok_or("there is no such file beside it")?;
        if input::is_inside(&self.folder, &path) {
            return Ok(path);
        }
        if !self.outside.iter().any(|known| known == name) {
            self.outside.push(name.to_owned());
        }
        if self.allow_outside { Ok(path) } else { Err(Trouble::Outside(name.to_owned())) }
    }

    /// The contents of a file that was found.
    pub fn read(&mut self, path: &Path) -> Result<Vec<u8>, Trouble> {
        let length = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
        self.budget.take(length)?;
        self.read.push(path.into());
        input::read(path).map_err(|e| e.to_string().into())
    }

    /// Tells which files were read, and of those outside. Those that are not read are told where they are missed, too.
    pub fn tell(self, report: &mut ImportReport) {
        report.files.extend(self.read);
        if self.outside.is_empty() {
            return;
        }
        let names = listed(&self.outside);
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
        report.outside = self.outside;
    }
}

/// The file in `folder` that `name` refers to, with either kind of slash and in any case. For paths of another machine
/// the file's name alone counts.
fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
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
