//! A glTF document: parsed, and checked for the extensions it requires.

use super::{json::document_with, layers, lights, pointers, variants};
use crate::{import::report::ImportError, names::listed};
use serde_json::Value;
use std::path::Path;

/// Supported extensions; others are named in a warning.
const EXTENSIONS: [&str; 11] = [
    lights::EXTENSION,
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_texture_transform",
    layers::EXTENSIONS[0],
    layers::EXTENSIONS[1],
    layers::EXTENSIONS[2],
    layers::EXTENSIONS[3],
    layers::EXTENSIONS[4],
    variants::EXTENSION,
    // The properties it animates stay at rest, with a warning.
    pointers::EXTENSION,
];

/// Parses and validates. Also returns the animations from which channels that move no node were removed. The validation
/// of the `gltf` crate looks up accessors of attributes before it checks their indices, so these are checked first.
pub(super) fn parse(bytes: &[u8]) -> Result<(gltf::Gltf, Vec<usize>), String> {
    let parsed = gltf::Gltf::from_slice_without_validation(bytes).map(|gltf| (gltf, Vec::new()));
    let parsed = parsed.or_else(|error| pointers::parse_without(bytes).ok_or(error));
    let (gltf::Gltf { document, blob }, pointing) = parsed.map_err(|e| e.to_string())?;
    let mut json = document.into_json();
    // Supported here; the crate would refuse a file that requires it.
    json.extensions_required.retain(|e| !EXTENSIONS.contains(&e.as_str()));
    let mut attributes = json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values());
    if let Some(bad) = attributes.find(|accessor| accessor.value() >= json.accessors.len()) {
        return Err(format!("a mesh refers to accessor {bad}, but there are {}", json.accessors.len()));
    }
    let document = gltf::Document::from_json(json).map_err(|e| e.to_string())?;
    Ok((gltf::Gltf { document, blob }, pointing))
}

/// Checks that all required extensions are supported.
///
/// # Errors
/// [`ImportError::Extensions`].
pub(super) fn check_extensions(bytes: &[u8], path: &Path) -> Result<(), ImportError> {
    let required = document_with(bytes, "extensionsRequired").unwrap_or_default();
    let names = required["extensionsRequired"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let unknown: Vec<String> = names.filter(|name| !EXTENSIONS.contains(name)).map(str::to_owned).collect();
    if unknown.is_empty() { Ok(()) } else { Err(ImportError::Extensions { path: path.into(), names: unknown }) }
}

/// The `gltf` crate subtracts from the length in a GLB header before it checks it.
pub(super) fn check_glb_header(bytes: &[u8]) -> Result<(), String> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    match bytes.get(8..12) {
        Some(length) if u32::from_le_bytes([length[0], length[1], length[2], length[3]]) >= 12 => Ok(()),
        _ => Err("the header of the binary file is damaged".into()),
    }
}

/// Warns of unsupported extensions.
pub(super) fn warn_of_extensions(gltf: &gltf::Document, warnings: &mut Vec<String>) {
    let others: Vec<String> = gltf.extensions_used().filter(|e| !EXTENSIONS.contains(e)).map(str::to_owned).collect();
    if !others.is_empty() {
        warnings.push(format!(
            "the glTF extensions {} are not supported and were left out; what they describe may look different",
            listed(&others)
        ));
    }
}
