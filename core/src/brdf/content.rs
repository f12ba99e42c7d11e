//! BRDFs that come from a file: its path, and what was read from it.
//!
//! The contents are shared: a material holds them, and so does each point that is shaded with it. A lifetime on every BRDF would
//! spread through all of shading, and what is kept for ever would grow with each file that is tried.

use super::{BrdfModel, Measured, MeasuredError};
use serde::{Deserialize, Serialize};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};
use thiserror::Error;

/// What a file of a BRDF holds.
#[derive(Clone, Debug)]
pub enum Content {
    /// A table of the MERL database.
    Measured(Arc<Measured>),
}

/// Which kind of content a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContentKind {
    /// A table of the MERL database.
    Measured,
}

/// The file of a material's BRDF. Files of materials have its path alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "PathBuf", into = "PathBuf")]
pub struct BrdfFile {
    /// Where it is, or was.
    pub path: PathBuf,
    /// What was read; none if it is not there.
    pub content: Option<Content>,
}

/// A file that holds no BRDF, or none that can be used.
#[derive(Debug, Error)]
pub enum BrdfFileError {
    /// It cannot be read.
    #[error("cannot read the BRDF; check that it is there and may be read: {source} ({})", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// No kind that is known.
    #[error("a BRDF is a MERL table (.binary); choose such a file ({})", path.display())]
    Kind {
        /// Path of the file.
        path: PathBuf,
    },
    /// A table that cannot be used.
    #[error("no MERL BRDF: {source} ({})", path.display())]
    Measured {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong.
        source: MeasuredError,
    },
}

impl Content {
    /// Its table, if it is one.
    pub fn measured(&self) -> Option<&Arc<Measured>> {
        match self {
            Self::Measured(table) => Some(table),
        }
    }

    /// Reads a file. Also returns what is to be told of it, in sentences.
    ///
    /// # Errors
    /// A file that cannot be read or used.
    pub fn read(path: &Path) -> Result<(Self, Vec<String>), BrdfFileError> {
        let kind = ContentKind::of(path).ok_or_else(|| BrdfFileError::Kind { path: path.into() })?;
        let io_error = |source| BrdfFileError::Io { path: path.into(), source };
        let length = std::fs::metadata(path).map_err(io_error)?.len();
        kind.check_length(length, path)?;
        Self::from_bytes(kind, &crate::input::read(path).map_err(io_error)?, path)
    }

    /// From the bytes of a file, whose path is for messages.
    ///
    /// # Errors
    /// A file that cannot be used.
    pub fn from_bytes(kind: ContentKind, bytes: &[u8], path: &Path) -> Result<(Self, Vec<String>), BrdfFileError> {
        match kind {
            ContentKind::Measured => {
                let failed = |source| BrdfFileError::Measured { path: path.into(), source };
                let table = Measured::from_merl(bytes).map_err(failed)?;
                let remarks = table.remarks(&file_name(path));
                Ok((Self::Measured(table.into()), remarks))
            }
        }
    }

    /// Which kind it is.
    pub fn kind(&self) -> ContentKind {
        match self {
            Self::Measured(_) => ContentKind::Measured,
        }
    }

    /// As a dataset has it.
    pub fn packed(&self) -> Vec<u8> {
        match self {
            Self::Measured(table) => table.packed(),
        }
    }

    /// From what [`Self::packed`] gave.
    ///
    /// # Errors
    /// Bytes that it did not give.
    pub fn from_packed(kind: ContentKind, bytes: &[u8], path: &Path) -> Result<Self, BrdfFileError> {
        match kind {
            ContentKind::Measured => {
                let failed = |source| BrdfFileError::Measured { path: path.into(), source };
                Ok(Self::Measured(Measured::from_packed(bytes).map_err(failed)?.into()))
            }
        }
    }

    /// Tells contents apart.
    pub fn hash(&self) -> [u8; 32] {
        match self {
            Self::Measured(table) => table.hash(),
        }
    }
}

impl ContentKind {
    /// Ends of the names of files.
    pub const EXTENSIONS: &[&str] = &["binary"];

    /// By the end of a file's name.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        (extension == "binary").then_some(Self::Measured)
    }

    /// The model that has such a file.
    pub fn model(self) -> BrdfModel {
        match self {
            Self::Measured => BrdfModel::Merl,
        }
    }

    /// So that a file of gigabytes is not read first.
    fn check_length(self, found: u64, path: &Path) -> Result<(), BrdfFileError> {
        let Self::Measured = self;
        let expected = Measured::FILE_BYTES;
        let source = MeasuredError::Length { found, expected };
        if found <= expected { Ok(()) } else { Err(BrdfFileError::Measured { path: path.into(), source }) }
    }
}

impl BrdfFile {
    /// Without contents.
    pub fn unread(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), content: None }
    }

    /// Its path alone.
    #[must_use]
    pub fn without_content(&self) -> Self {
        Self::unread(self.path.clone())
    }

    /// Its name without folders.
    pub fn name(&self) -> String {
        file_name(&self.path)
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Equal paths and contents.
impl PartialEq for BrdfFile {
    fn eq(&self, other: &Self) -> bool {
        let hash = |file: &Self| file.content.as_ref().map(Content::hash);
        self.path == other.path && hash(self) == hash(other)
    }
}

impl From<PathBuf> for BrdfFile {
    fn from(path: PathBuf) -> Self {
        Self::unread(path)
    }
}

impl From<BrdfFile> for PathBuf {
    fn from(file: BrdfFile) -> Self {
        file.path
    }
}

/// A file for tests of a model that needs one.
#[cfg(any(test, feature = "test-scenes"))]
pub fn example_file(model: super::BrdfModel) -> Option<BrdfFile> {
    use super::{Brdf, Ggx, GgxParameters};
    use std::sync::LazyLock;
    static MERL: LazyLock<BrdfFile> = LazyLock::new(|| {
        let base_color = glam::Vec3::new(0.6, 0.3, 0.1);
        let ggx = Ggx::new(&GgxParameters { base_color, roughness: 0.5, ior: 1.8, ..Default::default() });
        let table = Measured::tabulated(|wi, wo| ggx.brdf_cos(wi, wo) / wi.z);
        BrdfFile { path: "example.binary".into(), content: Some(Content::Measured(table.into())) }
    });
    (model == BrdfModel::Merl).then(|| MERL.clone())
}
