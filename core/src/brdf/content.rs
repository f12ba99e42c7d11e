//! BRDFs that come from a file: its path, and what was read from it.
//!
//! The contents are shared: a material holds them, and so does each point that is shaded with it. A lifetime on every BRDF would
//! spread through all of shading, and what is kept for ever would grow with each file that is tried.

use super::{Measured, MeasuredError, SampledLobe, Values, Written, WrittenError};
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
    /// A function in WGSL.
    Written(Arc<Written>),
}

/// What a file adds to a material's values.
#[derive(Clone, Copy, Debug)]
pub struct FilePart<'a> {
    /// What the file holds.
    pub content: &'a Content,
    /// The values of the material without its maps.
    pub plain: &'a Values,
}

/// Which kind of content a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContentKind {
    /// A table of the MERL database.
    Measured,
    /// A function in WGSL.
    Written,
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
    #[error("a BRDF is a MERL table (.binary) or a function in WGSL (.wgsl); choose such a file ({})", path.display())]
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
    /// A function that cannot be used.
    #[error("no BRDF in WGSL: {source} ({})", path.display())]
    Written {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong, and where.
        source: WrittenError,
    },
}

impl Content {
    /// Its table, if it is one.
    pub fn measured(&self) -> Option<&Arc<Measured>> {
        match self {
            Self::Measured(table) => Some(table),
            Self::Written(_) => None,
        }
    }

    /// Its function, if it is one.
    pub fn written(&self) -> Option<&Arc<Written>> {
        match self {
            Self::Measured(_) => None,
            Self::Written(written) => Some(written),
        }
    }

    /// The lobe that was estimated of it with these values of its parameters.
    pub fn estimate(&self, values: &Values) -> SampledLobe {
        match self {
            Self::Measured(table) => table.lobe().clone(),
            Self::Written(written) => (*written.estimate(values)).clone(),
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
            ContentKind::Written => {
                let failed = |source| BrdfFileError::Written { path: path.into(), source };
                let not_text = |_| failed(WrittenError { place: None, reason: "it is no text".into() });
                let written = Written::new(std::str::from_utf8(bytes).map_err(not_text)?).map_err(failed)?;
                let name = file_name(path);
                let remarks = written.remarks().iter().map(|remark| format!("{name}: {remark}")).collect();
                Ok((Self::Written(written.into()), remarks))
            }
        }
    }

    /// Which kind it is.
    pub fn kind(&self) -> ContentKind {
        match self {
            Self::Measured(_) => ContentKind::Measured,
            Self::Written(_) => ContentKind::Written,
        }
    }

    /// As a dataset has it.
    pub fn packed(&self) -> Vec<u8> {
        match self {
            Self::Measured(table) => table.packed(),
            Self::Written(written) => written.text().as_bytes().to_vec(),
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
            ContentKind::Written => Self::from_bytes(kind, bytes, path).map(|(content, _)| content),
        }
    }

    /// Tells contents apart.
    pub fn hash(&self) -> [u8; 32] {
        match self {
            Self::Measured(table) => table.hash(),
            Self::Written(written) => written.hash(),
        }
    }
}

impl ContentKind {
    /// Ends of the names of files.
    pub const EXTENSIONS: &[&str] = &["binary", "wgsl"];

    /// By the end of a file's name.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "binary" => Some(Self::Measured),
            "wgsl" => Some(Self::Written),
            _ => None,
        }
    }

    /// So that a file of gigabytes is not read first.
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
