//! Compressed data: `EXT_meshopt_compression`, `KHR_meshopt_compression` and `KHR_draco_mesh_compression`.
//!
//! The JSON is rewritten as if the file were not compressed: each compressed buffer view or mesh gets a buffer of its own, after
//! those of the file. Their contents are decoded when buffers are loaded, so accessors are read as those of any file.

use super::super::files::{Files, Trouble};
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;
use std::collections::BTreeMap;

mod draco;
mod meshopt;

/// The contents of a buffer that no file holds.
enum Contents {
    /// Copies of compressed views for programs that do not decode them.
    Fallback,
    View(meshopt::View),
    Mesh(draco::Mesh),
}

/// The buffers of a document that are not read from files, by index.
#[derive(Default)]
pub(super) struct Compressed(BTreeMap<usize, Contents>);

impl Compressed {
    /// Rewrites a document. One without compressed data stays as it is.
    ///
    /// # Errors
    /// Compressed data that are not described completely.
    pub fn of(document: &mut Value) -> Result<Self, String> {
        let mut buffers = BTreeMap::new();
        meshopt::expand(document, &mut buffers)?;
        draco::expand(document, &mut buffers)?;
        Ok(Self(buffers))
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The contents of the buffer after those in `loaded`; `None` if a file holds them.
    ///
    /// # Errors
    /// Damaged contents, or [`Trouble::Memory`].
    pub fn decode(&self, loaded: &[Vec<u8>], files: &mut Files) -> Result<Option<Vec<u8>>, Trouble> {
        Ok(Some(match self.0.get(&loaded.len()) {
            None => return Ok(None),
            Some(Contents::Fallback) => Vec::new(),
            Some(Contents::View(view)) => view.decode(loaded, &mut files.budget)?,
            Some(Contents::Mesh(mesh)) => mesh.decode(loaded, &mut files.budget)?,
        }))
    }
}

/// Compressed bytes within a buffer of a file.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Range {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
}

impl Range {
    fn of<'a>(&self, buffers: &'a [Vec<u8>], owner: &str) -> Result<&'a [u8], String> {
        let end = self.byte_offset.checked_add(self.byte_length);
        let bytes = buffers.get(self.buffer).zip(end).and_then(|(buffer, end)| buffer.get(self.byte_offset..end));
        bytes.ok_or_else(|| format!("the compressed data of {owner} end past buffer {}", self.buffer))
    }
}

fn damaged(owner: &str) -> String {
    format!("the compressed data of {owner} are damaged")
}

/// Reads what an extension says of its compressed data.
fn described<T: DeserializeOwned>(extension: &Value, owner: &str) -> Result<T, String> {
    T::deserialize(extension).map_err(|error| format!("the compressed data of {owner} cannot be found: {error}"))
}

/// The name of a mesh in messages.
fn mesh_name(index: usize, mesh: &Value) -> String {
    mesh["name"].as_str().map_or_else(|| format!("mesh {index}"), |name| format!("the mesh \"{name}\""))
}
