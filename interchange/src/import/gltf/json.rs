//! The JSON of a glTF file.

use serde_json::Value;
use std::borrow::Cow;

/// The JSON text of a file.
pub(super) fn json_of(bytes: &[u8]) -> Cow<'_, [u8]> {
    gltf::Glb::from_slice(bytes).map_or(Cow::Borrowed(bytes), |glb| glb.json)
}

/// The JSON of a file that mentions an extension, for features that the `gltf` crate lacks.
pub(super) fn document_with(bytes: &[u8], extension: &str) -> Option<Value> {
    let json = &*json_of(bytes);
    let mentioned = json.windows(extension.len()).any(|w| w == extension.as_bytes());
    mentioned.then(|| serde_json::from_slice(json).ok()).flatten()
}
