//! Compressed data: `EXT_meshopt_compression`, `KHR_meshopt_compression` and `KHR_draco_mesh_compression`.
//!
//! The JSON is rewritten as if the file were not compressed: each compressed buffer view or mesh gets a buffer of its own, after
//! those of the file. Their contents are decoded when buffers are loaded, so accessors are read as those of any file.

use super::{
    super::{
        budget::Budget,
        fields::contents,
        files::{Files, Trouble},
    },
    completed::push,
};
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;
use std::{collections::BTreeMap, rc::Rc};

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
    /// Compressed data that are not described completely, or [`Trouble::Memory`].
    pub fn of(document: &mut Value, budget: &mut Budget) -> Result<Self, Trouble> {
        let mut buffers = BTreeMap::new();
        meshopt::expand(document, &mut buffers, budget)?;
        draco::expand(document, &mut buffers, budget)?;
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

/// Reads what an object of the file, which is at `place`, says of compressed data.
fn described<T: DeserializeOwned>(object: &Value, place: &str, owner: &str) -> Result<T, String> {
    contents(object).map_err(|reason| format!("the compressed data of {owner} cannot be found: in {place}, {reason}"))
}

/// The name of what has compressed data, for messages. Many views of a mesh share one.
type Owner = Rc<str>;

/// The name of a mesh in messages.
fn mesh_name(index: usize, mesh: &Value) -> Owner {
    mesh["name"].as_str().map_or_else(|| format!("mesh {index}"), |name| format!("the mesh \"{name}\"")).into()
}

/// Appends an object to a list member of the document, within the budget.
fn add(document: &mut Value, list: &str, object: Value, budget: &mut Budget) -> Result<usize, Trouble> {
    budget.take_json(object.to_string().as_bytes())?;
    push(document, list, object).ok_or_else(|| format!("its \"{list}\" are no list").into())
}
