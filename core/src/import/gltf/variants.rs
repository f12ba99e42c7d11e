//! Variants of materials (`KHR_materials_variants`), read from the JSON itself: which variants there are, and which material a
//! primitive has in one of them.

use super::document_with;
use serde_json::Value;

/// Name of the extension.
pub(super) const EXTENSION: &str = "KHR_materials_variants";

/// The variants of a file.
#[derive(Default)]
pub(super) struct Variants {
    document: Value,
    /// Their names.
    pub names: Vec<String>,
    chosen: Option<usize>,
}

impl Variants {
    /// Those of a file, of which the one called `wanted` is shown.
    ///
    /// # Errors
    /// The names that there are, if there is none of that name.
    pub fn of(bytes: &[u8], wanted: Option<&str>) -> Result<Self, Vec<String>> {
        let document = document_with(bytes, EXTENSION).unwrap_or_default();
        let list = document["extensions"][EXTENSION]["variants"].as_array().cloned().unwrap_or_default();
        let name = |(index, variant): (usize, &Value)| {
            variant["name"].as_str().map_or_else(|| format!("variant {index}"), str::to_owned)
        };
        let names: Vec<String> = list.iter().enumerate().map(name).collect();
        let Some(wanted) = wanted else { return Ok(Self { document, names, chosen: None }) };
        match names.iter().position(|name| name == wanted) {
            Some(chosen) => Ok(Self { document, names, chosen: Some(chosen) }),
            None => Err(names),
        }
    }

    /// The material that a primitive of a mesh has in the variant that was chosen, if that says one.
    pub fn material(&self, mesh: usize, primitive: usize) -> Option<usize> {
        let chosen = self.chosen?;
        let primitive = &self.document["meshes"][mesh]["primitives"][primitive];
        let mappings = primitive["extensions"][EXTENSION]["mappings"].as_array()?;
        let is_meant = |mapping: &&Value| {
            let variants = mapping["variants"].as_array();
            variants.is_some_and(|all| all.iter().any(|index| index.as_u64() == Some(chosen as u64)))
        };
        mappings.iter().find(is_meant)?["material"].as_u64().map(|index| index as usize)
    }

    /// What is told of a file with variants.
    pub fn remark(&self) -> Option<String> {
        if self.names.is_empty() {
            return None;
        }
        let shown = match self.chosen {
            Some(chosen) => format!("\"{}\" is shown", self.names[chosen]),
            None => "none is chosen, and the materials are those of the file".into(),
        };
        Some(format!("the scene has the material variants {}; {shown}", crate::import::listed(&self.names)))
    }
}
