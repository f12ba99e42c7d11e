//! BRDFs read from files: the path and the contents.
//!
//! Contents are shared between a material and every shaded point. A lifetime on every BRDF would spread through all
//! shading code; leaked contents would grow with each file tried.

use super::{Measured, MeasuredError, SampledLobe, Values, Written, WrittenError};
use crate::input;
use serde::{Deserialize, Serialize};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};
use thiserror::Error;

/// Contents of a BRDF file.
#[derive(Clone, Debug)]
pub enum Content {
    /// A table of the MERL database.
    Measured(Arc<Measured>),
    /// A function in WGSL.
    Written(Arc<Written>),
}

/// A file's contribution to a material's values.
#[derive(Clone, Copy, Debug)]
pub struct FilePart<'a> {
    /// Contents of the file.
    pub content: &'a Content,
    /// The values of the material without its maps.
    pub plain: &'a Values,
}

/// Kind of a BRDF file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContentKind {
    /// A table of the MERL database.
    Measured,
    /// A function in WGSL.
    Written,
}

/// The file of a material's BRDF. Material files store only its path.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "PathBuf", into = "PathBuf")]
pub struct BrdfFile {
    /// Path of the file, present or not.
    pub path: PathBuf,
    /// Its contents; `None` if it is missing.
    pub content: Option<Content>,
}

/// A file without a usable BRDF.
#[derive(Debug, Error)]
pub enum BrdfFileError {
    /// The file cannot be read.
    #[error("cannot read the BRDF; check that it is there and may be read: {source} ({})", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The file's kind is unknown.
    #[error("a BRDF is a MERL table (.binary) or a function in WGSL (.wgsl); choose such a file ({})", path.display())]
    Kind {
        /// Path of the file.
        path: PathBuf,
    },
    /// A table that cannot be used.
    #[error("not a MERL BRDF: {source} ({})", path.display())]
    Measured {
        /// Path of the file.
        path: PathBuf,
        /// The reason.
        source: MeasuredError,
    },
    /// A function that cannot be used.
    #[error("not a BRDF in WGSL: {source} ({})", path.display())]
    Written {
        /// Path of the file.
        path: PathBuf,
        /// The reason and its line.
        source: WrittenError,
    },
}

impl Content {
    /// The table, if the contents are one.
    pub fn measured(&self) -> Option<&Arc<Measured>> {
        match self {
            Self::Measured(table) => Some(table),
            Self::Written(_) => None,
        }
    }

    /// The function, if the contents are one.
    pub fn written(&self) -> Option<&Arc<Written>> {
        match self {
            Self::Measured(_) => None,
            Self::Written(written) => Some(written),
        }
    }

    /// The lobe estimated for these parameter values.
    pub fn estimate(&self, values: &Values) -> SampledLobe {
        match self {
            Self::Measured(table) => table.lobe().clone(),
            Self::Written(written) => (*written.estimate(values)).clone(),
        }
    }

    /// Reads a file. Also returns remarks, in sentences.
    ///
    /// # Errors
    /// The file cannot be read or used.
    pub fn read(path: &Path) -> Result<(Self, Vec<String>), BrdfFileError> {
        let kind = ContentKind::of(path).ok_or_else(|| BrdfFileError::Kind { path: path.into() })?;
        let io_error = |source| BrdfFileError::Io { path: path.into(), source };
        let length = std::fs::metadata(path).map_err(io_error)?.len();
        kind.check_length(length, path)?;
        Self::from_bytes(kind, &input::read(path).map_err(io_error)?, path)
    }

    /// Reads the bytes of a file; the path is for messages.
    ///
    /// # Errors
    /// The file cannot be used.
    pub fn from_bytes(kind: ContentKind, bytes: &[u8], path: &Path) -> Result<(Self, Vec<String>), BrdfFileError> {
        match kind {
            ContentKind::Measured => {
                let failed = |source| BrdfFileError::Measured { path: path.into(), source };
                let table = Measured::from_merl(bytes).map_err(failed)?;
                let remarks = table.remarks(&file_name(path));
                Ok((Self::Measured(table.into()), remarks))
            }
            ContentKind::Written => {
                let failed = |source| BrdfFileError::Written { path: path.into(), source };
                let not_text = |_| failed(WrittenError { place: None, reason: "it is not text".into() });
                let bytes = input::text(bytes).map_err(|source| BrdfFileError::Io { path: path.into(), source })?;
                let written = Written::new(std::str::from_utf8(&bytes).map_err(not_text)?).map_err(failed)?;
                let name = file_name(path);
                let remarks = written.remarks().iter().map(|remark| format!("{name}: {remark}")).collect();
                Ok((Self::Written(written.into()), remarks))
            }
        }
    }

    /// Kind of the contents.
    pub fn kind(&self) -> ContentKind {
        match self {
            Self::Measured(_) => ContentKind::Measured,
            Self::Written(_) => ContentKind::Written,
        }
    }

    /// Bytes as a dataset stores them.
    pub fn packed(&self) -> Vec<u8> {
        match self {
            Self::Measured(table) => table.packed(),
            Self::Written(written) => written.text().as_bytes().to_vec(),
        }
    }

    /// Reads the bytes of [`Self::packed`].
    ///
    /// # Errors
    /// Any other bytes.
    pub fn from_packed(kind: ContentKind, bytes: &[u8], path: &Path) -> Result<Self, BrdfFileError> {
        match kind {
            ContentKind::Measured => {
                let failed = |source| BrdfFileError::Measured { path: path.into(), source };
                Ok(Self::Measured(Measured::from_packed(bytes).map_err(failed)?.into()))
            }
            ContentKind::Written => Self::from_bytes(kind, bytes, path).map(|(content, _)| content),
        }
    }

    /// Hash of the contents.
    pub fn hash(&self) -> [u8; 32] {
        match self {
            Self::Measured(table) => table.hash(),
            Self::Written(written) => written.hash(),
        }
    }
}

impl ContentKind {
    /// File extensions.
    pub const EXTENSIONS: &[&str] = &["binary", "wgsl"];

    /// The kind by file extension.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "binary" => Some(Self::Measured),
            "wgsl" => Some(Self::Written),
            _ => None,
        }
    }

    /// Rejects a file of gigabytes before it is read.
    fn check_length(self, found: u64, path: &Path) -> Result<(), BrdfFileError> {
        let too_long = |expected| match self {
            Self::Measured => {
                BrdfFileError::Measured { path: path.into(), source: MeasuredError::Length { found, expected } }
            }
            Self::Written => {
                let reason = format!("it has {found} bytes, more than {expected}; make it shorter");
                BrdfFileError::Written { path: path.into(), source: WrittenError { place: None, reason } }
            }
        };
        let most = match self {
            Self::Measured => Measured::FILE_BYTES,
            Self::Written => Written::MOST_BYTES,
        };
        if found <= most { Ok(()) } else { Err(too_long(most)) }
    }
}

impl BrdfFile {
    /// A file whose contents have not been read.
    pub fn unread(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), content: None }
    }

    /// The same file without its contents.
    #[must_use]
    pub fn without_content(&self) -> Self {
        Self::unread(self.path.clone())
    }

    /// File name without folders.
    pub fn name(&self) -> String {
        file_name(&self.path)
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Compares paths and contents.
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

/// An example file for tests of a model that needs one.
#[cfg(any(test, feature = "test-scenes"))]
pub fn example_file(model: super::BrdfModel) -> Option<BrdfFile> {
    use super::{Brdf, BrdfModel, Ggx, GgxParameters};
    use std::sync::LazyLock;
    static MERL: LazyLock<BrdfFile> = LazyLock::new(|| {
        let base_color = glam::Vec3::new(0.6, 0.3, 0.1);
        let ggx = Ggx::new(&GgxParameters { base_color, roughness: 0.5, ior: 1.8, ..Default::default() });
        let table = Measured::tabulated(|wi, wo| ggx.brdf_cos(wi, wo) / wi.z);
        BrdfFile { path: "example.binary".into(), content: Some(Content::Measured(table.into())) }
    });
    static WGSL: LazyLock<BrdfFile> = LazyLock::new(|| {
        let text = include_str!("../../../data/brdfs/velvet.wgsl");
        let written = Written::new(text).expect("an example is a BRDF");
        BrdfFile { path: "velvet.wgsl".into(), content: Some(Content::Written(written.into())) }
    });
    match model {
        BrdfModel::Merl => Some(MERL.clone()),
        BrdfModel::Wgsl => Some(WGSL.clone()),
        _ => None,
    }
}
