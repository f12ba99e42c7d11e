//! A glTF document: parsed, and checked for its version and the extensions it requires.

use super::{
    buffers,
    completed::{self, Completed, completed},
    compressed,
    container::{Container, Unreadable},
    glossiness, layers, lights, pointers, variants,
};
use crate::{
    import::{files::Trouble, report::ImportError},
    names::listed,
};
use serde_json::Value;
use std::{collections::BTreeSet, path::Path};

/// Supported extensions; others are named in a warning.
const EXTENSIONS: [&str; 18] = [
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
    glossiness::EXTENSION,
    buffers::QUANTIZATION,
    compressed::EXTENSIONS[0],
    compressed::EXTENSIONS[1],
    compressed::EXTENSIONS[2],
    completed::PICTURES[0],
    completed::PICTURES[1],
];

/// Whether an extension concerns looks alone: a file that requires it shows without it, with a warning. Instanced
/// meshes are refused.
fn is_of_looks(name: &str) -> bool {
    const OTHERS: [&str; 3] = ["MSFT_texture_dds", "EXT_lights_image_based", "KHR_xmp_json_ld"];
    name.contains("_materials_") || OTHERS.contains(&name)
}

/// A parsed file.
pub(super) struct Parsed {
    pub gltf: gltf::Gltf,
    pub completed: Completed,
}

/// The contents of a file, of version 2.
///
/// # Errors
/// [`ImportError::GltfVersion`], or a damaged container.
pub(super) fn container<'a>(bytes: &'a [u8], path: &Path) -> Result<Container<'a>, ImportError> {
    let other = |version: String| ImportError::GltfVersion { path: path.into(), version };
    Container::of(bytes).map_err(|error| match error {
        Unreadable::Version(version) => other(format!("{version}.0")),
        Unreadable::Damaged(reason) => Trouble::from(reason).at(path, "glTF"),
    })
}

/// Checks the version, and that all required extensions are supported, or concern looks alone.
///
/// # Errors
/// [`ImportError::GltfVersion`] and [`ImportError::Extensions`].
fn check(document: &Value, path: &Path) -> Result<(), ImportError> {
    let version = document["asset"]["version"].as_str().unwrap_or("2.0");
    if version.split('.').next() != Some("2") {
        return Err(ImportError::GltfVersion { path: path.into(), version: version.into() });
    }
    let names = document["extensionsRequired"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let unknown = names.filter(|name| !EXTENSIONS.contains(name) && !is_of_looks(name));
    let unknown: Vec<String> = unknown.map(str::to_owned).collect();
    if unknown.is_empty() { Ok(()) } else { Err(ImportError::Extensions { path: path.into(), names: unknown }) }
}

/// Names of the extensions that materials have: some programs do not list them.
fn extensions_of_materials(document: &Value) -> BTreeSet<String> {
    let materials = document["materials"].as_array().into_iter().flatten();
    materials
        .filter_map(|material| material["extensions"].as_object())
        .flatten()
        .map(|(name, _)| name.clone())
        .collect()
}

/// Parses and validates. The validation of the `gltf` crate looks up accessors of attributes before it checks their indices,
/// so these are checked first.
///
/// # Errors
/// A file of another version, with other required extensions, or with invalid contents.
pub(super) fn parse(container: &Container, path: &Path) -> Result<Parsed, ImportError> {
    let failed = |reason: String| Trouble::from(reason).at(path, "glTF");
    let document: Value = serde_json::from_slice(container.json).map_err(|error| failed(error.to_string()))?;
    check(&document, path)?;
    let of_materials = extensions_of_materials(&document);
    let completed = completed(document, container.json).map_err(failed)?;
    let mut json: gltf::json::Root =
        serde_json::from_slice(&completed.text).map_err(|error| failed(error.to_string()))?;
    // Checked above; the crate would refuse a file that requires them.
    let mut required = std::mem::take(&mut json.extensions_required);
    required.extend(of_materials);
    required.retain(|name| !json.extensions_used.contains(name));
    json.extensions_used.extend(required);
    let mut attributes = json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values());
    if let Some(bad) = attributes.find(|accessor| accessor.value() >= json.accessors.len()) {
        return Err(failed(format!("a mesh refers to accessor {bad}, but there are {}", json.accessors.len())));
    }
    let document = gltf::Document::from_json(json).map_err(|error| failed(error.to_string()))?;
    let blob = container.blob.map(<[u8]>::to_vec);
    Ok(Parsed { gltf: gltf::Gltf { document, blob }, completed })
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
