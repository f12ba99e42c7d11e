//! Material variants (`KHR_materials_variants`), read from the JSON itself: their names, and the material of each
//! primitive in them.

use crate::import::{gltf::json::document_with, source::Source};
use lapidary_core::{
    parts::{Part, PartVariants},
    scene::Object,
};
use serde_json::Value;

/// Name of the extension.
pub(super) const EXTENSION: &str = "KHR_materials_variants";

/// The variants of a file.
#[derive(Default)]
pub(super) struct FileVariants {
    document: Value,
    /// Their names.
    pub names: Vec<String>,
    chosen: Option<usize>,
}

impl FileVariants {
    /// The variants of a file; `wanted` is shown.
    ///
    /// # Errors
    /// The existing names, if `wanted` is not among them.
    pub fn of(json: &[u8], wanted: Option<&str>) -> Result<Self, Vec<String>> {
        let document = document_with(json, EXTENSION).unwrap_or_default();
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

    /// The material of a primitive of a mesh in the chosen variant, if it assigns one.
    pub fn chosen(&self, place: [usize; 2]) -> Option<usize> {
        self.material(self.mappings(place)?, self.chosen?)
    }

    /// The materials of a primitive of a mesh in all variants; `None` if they do not change it. `index_of` maps a named
    /// material, which may be missing, or none, to an index.
    pub fn looks(&self, place: [usize; 2], index_of: &mut impl FnMut(Option<usize>) -> u32) -> Option<Looks> {
        let mappings = self.mappings(place)?;
        let plain = index_of(None);
        let in_variants = (0..self.names.len()).map(|variant| index_of(self.material(mappings, variant))).collect();
        Some(Looks { plain, in_variants })
    }

    fn mappings(&self, [mesh, primitive]: [usize; 2]) -> Option<&Vec<Value>> {
        let primitive = &self.document["meshes"][mesh]["primitives"][primitive];
        primitive["extensions"][EXTENSION]["mappings"].as_array()
    }

    fn material(&self, mappings: &[Value], variant: usize) -> Option<usize> {
        let is_meant = |mapping: &&Value| {
            let variants = mapping["variants"].as_array();
            variants.is_some_and(|all| all.iter().any(|index| index.as_u64() == Some(variant as u64)))
        };
        mappings.iter().find(is_meant)?["material"].as_u64().map(|index| index as usize)
    }

    /// The remark on a file with variants.
    pub fn remark(&self) -> Option<String> {
        if self.names.is_empty() {
            return None;
        }
        let shown = match self.chosen {
            Some(chosen) => format!("\"{}\" is shown", self.names[chosen]),
            None => "none is chosen, and the materials are those of the file".into(),
        };
        Some(format!("the scene has the material variants {}; {shown}", crate::names::listed(&self.names)))
    }
}

/// Material indices of a primitive: without a variant, and in each variant.
#[derive(PartialEq)]
pub(super) struct Looks {
    plain: u32,
    in_variants: Vec<u32>,
}

/// The parts of a node.
pub(super) struct PartsOfNode {
    name: String,
    object: u32,
    known: Vec<(Part, Option<Looks>)>,
}

impl PartsOfNode {
    /// Adds an object for the node.
    pub fn new(source: &mut Source, name: String) -> Self {
        Self { object: add_object(source, name.clone()), name, known: Vec::new() }
    }

    /// The part of a primitive. Primitives of one material with different variants become separate objects.
    pub fn add(&mut self, source: &mut Source, material: u32, looks: Option<Looks>) -> Part {
        let of_material = || self.known.iter().filter(|(part, _)| part.material == material);
        if let Some((part, _)) = of_material().find(|(_, known)| *known == looks) {
            return *part;
        }
        let object = match of_material().count() {
            0 => self.object,
            others => add_object(source, format!("{} {}", self.name, others + 1)),
        };
        let part = Part { object, material };
        if let Some(Looks { plain, in_variants }) = &looks {
            source.variants.parts.push(PartVariants { part, plain: *plain, in_variants: in_variants.clone() });
        }
        self.known.push((part, looks));
        part
    }
}

fn add_object(source: &mut Source, name: String) -> u32 {
    source.objects.push(Object { name });
    source.objects.len() as u32 - 1
}
