//! A glTF document: parsed, and checked for its version and the extensions it requires.

use super::{
    completed::{Completed, completed},
    container::{Container, Unreadable},
};
use crate::{
    features::{self, Feature, Format, Support, gltf::INSTANCES},
    import::{budget::Budget, fields, files::Trouble, report::ImportError},
    names::listed,
};
use gltf::json::validation::Error as Invalid;
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// Whether an extension is supported; others are named in a warning.
fn is_read(name: &str) -> bool {
    features::is_read(Format::Gltf, name)
}

/// Whether a file that requires an extension shows without it, with a warning: known ones leave the shapes as they are, except for
/// instances, and those of materials concern looks alone.
fn is_dispensable(name: &str) -> bool {
    name.contains("_materials_") || features::of(Format::Gltf, name).is_some_and(|feature| feature != INSTANCES)
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

/// Checks the version, and that all required extensions are supported, or that the file shows without them.
///
/// # Errors
/// [`ImportError::GltfVersion`] and [`ImportError::Extensions`].
fn check(document: &Value, path: &Path) -> Result<(), ImportError> {
    let version = document["asset"]["version"].as_str().unwrap_or("2.0");
    if version.split('.').next() != Some("2") {
        return Err(ImportError::GltfVersion { path: path.into(), version: version.into() });
    }
    let names = document["extensionsRequired"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let unknown = names.filter(|name| !is_dispensable(name));
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
/// A file of another version, with other required extensions, with invalid contents, or beyond the `budget`.
pub(super) fn parse(container: &Container, path: &Path, budget: &mut Budget) -> Result<Parsed, ImportError> {
    let failed = |reason: String| Trouble::from(reason).at(path, "glTF");
    let document: Value = fields::parse(container.json).map_err(failed)?;
    check(&document, path)?;
    let of_materials = extensions_of_materials(&document);
    let completed = completed(document, container.json, budget).map_err(|trouble| trouble.at(path, "glTF"))?;
    let mut json: gltf::json::Root = fields::parse(&completed.text).map_err(failed)?;
    // Checked above; the crate would refuse a file that requires them.
    let mut required = std::mem::take(&mut json.extensions_required);
    required.extend(of_materials);
    required.retain(|name| !json.extensions_used.contains(name));
    json.extensions_used.extend(required);
    let mut attributes = json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values());
    if let Some(bad) = attributes.find(|accessor| accessor.value() >= json.accessors.len()) {
        return Err(failed(format!("a mesh refers to accessor {bad}, but there are {}", json.accessors.len())));
    }
    let document = gltf::Document::from_json(json).map_err(|error| failed(told(error)))?;
    let blob = container.blob.map(<[u8]>::to_vec);
    Ok(Parsed { gltf: gltf::Gltf { document, blob }, completed })
}

/// What the `gltf` crate finds wrong, by field.
fn told(error: gltf::Error) -> String {
    const MOST: usize = 3;
    let gltf::Error::Validation(errors) = error else { return error.to_string() };
    let what = |error: &Invalid| match error {
        Invalid::IndexOutOfBounds => "refers to something that is not there",
        Invalid::Missing => "is missing",
        _ => "has a value that is not allowed",
    };
    let fields: Vec<String> =
        errors.iter().take(MOST).map(|(path, error)| format!("\"{path}\" {}", what(error))).collect();
    let more = errors.len().saturating_sub(MOST);
    fields.join(", ") + &if more > 0 { format!(", and {more} more such fields") } else { String::new() }
}

/// Warns of unsupported extensions.
pub(super) fn warn_of_extensions(gltf: &gltf::Document, warnings: &mut Vec<String>) {
    let mut by_loss: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for name in gltf.extensions_used().filter(|name| !is_read(name)) {
        match features::of(Format::Gltf, name) {
            Some(Feature { support: Support::LeftOut(what), .. }) => by_loss.entry(what).or_default().push(name.into()),
            Some(_) => {}
            None => by_loss.entry("what they describe may look different").or_default().push(name.into()),
        }
    }
    warnings.extend(by_loss.iter().map(|(what, names)| {
        format!("the glTF extensions {} are not supported and were left out; {what}", listed(names))
    }));
}

#[cfg(test)]
mod tests {
    use super::{
        super::{buffers, glossiness, lights, pointers, variants},
        *,
    };

    #[test]
    fn the_table_of_features_has_the_extensions_that_are_read() {
        for name in [
            lights::EXTENSION,
            variants::EXTENSION,
            pointers::EXTENSION,
            glossiness::EXTENSION,
            buffers::QUANTIZATION,
            "KHR_materials_clearcoat",
        ] {
            assert!(is_read(name), "{name}");
        }
        assert!(!is_read("KHR_materials_volume") && !is_read("EXT_unknown") && !is_read(""), "negative control");
    }
}
