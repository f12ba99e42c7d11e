//! BRDF files that the materials of a session name.

use crate::document::Document;
use lapidary_core::{brdf::Content, material::Material};
use std::{collections::HashMap, path::PathBuf};

/// Reads the files of a document's materials and of those of its looks, each once. If one cannot be read, the contents of the scene material's file of the same name
/// serve. Remarks go to `warnings`.
pub fn read(document: &mut Document, of_scene: &[Material], warnings: &mut Vec<String>) {
    let mut known: HashMap<PathBuf, Option<Content>> = HashMap::new();
    for (index, material) in document.materials_and_those_of_looks() {
        let Some(file) = material.file.as_mut().filter(|file| file.content.is_none()) else { continue };
        let own = of_scene.get(index).and_then(|own| own.file.as_ref()).filter(|own| own.name() == file.name());
        let own = own.and_then(|own| own.content.clone());
        let content = known.entry(file.path.clone()).or_insert_with(|| match Content::read(&file.path) {
            Ok((content, remarks)) => {
                warnings.extend(remarks);
                Some(content)
            }
            Err(_) if own.is_some() => None,
            Err(error) => {
                warnings.push(format!("a material is shown in magenta: {error}"));
                None
            }
        });
        file.content = content.clone().or(own);
    }
}
