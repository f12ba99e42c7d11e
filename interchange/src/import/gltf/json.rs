//! The JSON of a glTF file.

use serde_json::Value;

/// The JSON of a file that mentions an extension, for features that the `gltf` crate lacks.
pub(super) fn document_with(json: &[u8], extension: &str) -> Option<Value> {
    let mentioned = json.windows(extension.len()).any(|w| w == extension.as_bytes());
    mentioned.then(|| serde_json::from_slice(json).ok()).flatten()
}
