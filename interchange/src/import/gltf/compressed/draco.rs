//! Meshes that Draco compressed, decoded by the crate `draco-core`.

use super::{
    super::{
        super::{budget::Budget, files::Trouble},
        completed::list,
    },
    Contents, Owner, Range, add, damaged, described, mesh_name,
};
use draco_core::{DecodeLimits, DecoderBuffer, FaceIndex, MeshDecoder};
use serde::Deserialize;
use serde_json::{Value, json};
use std::{
    collections::{BTreeMap, btree_map::Entry},
    rc::Rc,
};

pub const EXTENSION: &str = "KHR_draco_mesh_compression";

/// Memory of the decoder for a triangle, in bytes: meshes of four and five attributes took 155 to 258.
const TRIANGLE: u64 = 300;

/// Largest number of attributes of a mesh: each gets an accessor, which takes a hundred times the bytes of its name.
const MOST_ATTRIBUTES: usize = 32;

/// The mode of a primitive of triangles.
const TRIANGLES: u32 = 4;

/// A compressed mesh, and what accessors say of its contents.
pub struct Mesh {
    /// What it belongs to, for messages.
    owner: Owner,
    range: Range,
    /// The parts in the order of the buffer.
    parts: Vec<Part>,
    /// Bytes of all parts.
    length: usize,
}

/// A list of numbers.
struct Part {
    /// The attribute's number; `None` for corners of triangles.
    attribute: Option<u32>,
    count: usize,
    components: usize,
    component: Component,
}

/// The types of components that accessors have.
#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Extension {
    buffer_view: usize,
    #[serde(default)]
    attributes: BTreeMap<String, u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    count: usize,
    component_type: u32,
    #[serde(rename = "type")]
    dimensions: String,
    #[serde(default)]
    normalized: bool,
}

/// Gives each compressed mesh a buffer, and its primitives accessors of it.
pub fn expand(
    document: &mut Value,
    buffers: &mut BTreeMap<usize, Contents>,
    budget: &mut Budget,
) -> Result<(), Trouble> {
    let mut by_view: BTreeMap<usize, (usize, Mesh)> = BTreeMap::new();
    for (mesh, primitive, owner) in compressed(document) {
        let extension = &list(document, "meshes")[mesh]["primitives"][primitive]["extensions"][EXTENSION];
        let Extension { buffer_view, attributes } = described(extension, EXTENSION, &owner)?;
        let count = attributes.len();
        if count > MOST_ATTRIBUTES {
            let limit = MOST_ATTRIBUTES;
            return Err(format!("{owner} has {count} compressed attributes, more than the limit of {limit}").into());
        }
        let (buffer, mesh_of_view) = match by_view.entry(buffer_view) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(Mesh::in_view(document, buffer_view, &owner, budget)?),
        };
        let mut at = Place { document, buffer: *buffer, mesh: mesh_of_view, budget };
        let named = attributes.iter().map(|(name, &id)| (format!("attributes/{name}"), Some(id)));
        for (field, attribute) in named.chain([("indices".to_owned(), None)]) {
            at.add(&format!("/meshes/{mesh}/primitives/{primitive}/{field}"), attribute)?;
        }
        document["meshes"][mesh]["primitives"][primitive]["mode"] = TRIANGLES.into();
    }
    for (buffer, mesh) in by_view.into_values() {
        document["buffers"][buffer]["byteLength"] = mesh.length.into();
        buffers.insert(buffer, Contents::Mesh(mesh));
    }
    Ok(())
}

/// Meshes and primitives with compressed data, and the names of the meshes.
fn compressed(document: &mut Value) -> Vec<(usize, usize, Owner)> {
    let mut found = Vec::new();
    for (index, mesh) in list(document, "meshes").iter().enumerate() {
        let owner = mesh_name(index, mesh);
        let primitives = mesh["primitives"].as_array().into_iter().flatten().enumerate();
        let has_extension = |primitive: &Value| primitive["extensions"].get(EXTENSION).is_some();
        found.extend(
            primitives.filter(|(_, p)| has_extension(p)).map(|(primitive, _)| (index, primitive, Rc::clone(&owner))),
        );
    }
    found
}

/// Where the parts of a mesh are added.
struct Place<'a> {
    document: &'a mut Value,
    buffer: usize,
    mesh: &'a mut Mesh,
    budget: &'a mut Budget,
}

impl Place<'_> {
    /// Replaces the accessor that the document names at `pointer` by one of the decoded mesh. Attributes that the primitive does not
    /// name stay unread.
    fn add(&mut self, pointer: &str, attribute: Option<u32>) -> Result<(), Trouble> {
        let owner = &self.mesh.owner;
        let index = self.document.pointer(pointer).and_then(Value::as_u64);
        let Some(index) = index else {
            let missing = || format!("{owner} is compressed and has no indices").into();
            return attribute.map_or_else(|| Err(missing()), |_| Ok(()));
        };
        let (fields, place) = named(self.document, "accessors", index as usize, owner)?;
        let accessor: Accessor = described(fields, &place, owner)?;
        let bounds = ["min", "max"].map(|bound| (bound, fields.get(bound).filter(|value| is_bound(value)).cloned()));
        let part = Part::of(&accessor, attribute).ok_or_else(|| damaged(owner))?;
        let view = json!({ "buffer": self.buffer, "byteOffset": self.mesh.length, "byteLength": part.length() });
        self.mesh.length += part.length();
        self.mesh.parts.push(part);
        let view = add(self.document, "bufferViews", view, self.budget)?;
        let Accessor { count, component_type, dimensions, normalized } = accessor;
        // Many primitives can name one accessor: what else it holds is not copied.
        let mut copy = json!({ "bufferView": view, "count": count, "componentType": component_type,
            "type": dimensions, "normalized": normalized });
        bounds.into_iter().for_each(|(bound, value)| copy[bound] = value.unwrap_or_default());
        let accessor = add(self.document, "accessors", copy, self.budget)?;
        if let Some(named) = self.document.pointer_mut(pointer) {
            *named = accessor.into();
        }
        Ok(())
    }
}

/// An element of a list member, and its place.
fn named<'a>(document: &'a mut Value, name: &str, index: usize, owner: &str) -> Result<(&'a Value, String), String> {
    let place = format!("{name}[{index}]");
    match list(document, name).get(index) {
        Some(element) => Ok((element, place)),
        None => Err(format!("the compressed data of {owner} cannot be found: {place} is not there")),
    }
}

/// Whether a value bounds the elements of an accessor.
fn is_bound(value: &Value) -> bool {
    value.as_array().is_some_and(|bound| bound.len() <= 4 && bound.iter().all(Value::is_number))
}

impl Part {
    fn of(accessor: &Accessor, attribute: Option<u32>) -> Option<Self> {
        let component = match accessor.component_type {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        };
        let components = match accessor.dimensions.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => return None,
        };
        // Larger ones do not fit any memory, and their lengths do not overflow below.
        let count = accessor.count.min(u32::MAX as usize);
        Some(Self { attribute, count, components, component })
    }

    /// Bytes in the buffer, a multiple of four.
    fn length(&self) -> usize {
        (self.count * self.components * self.component.size()).next_multiple_of(4)
    }

    /// Appends the numbers of a decoded mesh to a buffer.
    fn append(&self, mesh: &draco_core::Mesh, buffer: &mut Vec<u8>) -> Option<()> {
        let end = buffer.len() + self.length();
        if let Some(id) = self.attribute {
            let attribute = mesh.attribute_by_unique_id(id)?;
            let numbers = attribute.read_f32s(self.count, self.components);
            numbers.into_iter().for_each(|number| self.component.append(number, buffer));
        } else {
            let corners = (0..mesh.num_faces()).flat_map(|face| mesh.face(FaceIndex(face as u32)));
            corners.for_each(|corner| self.component.append_index(corner.0, buffer));
        }
        buffer.resize(end, 0);
        Some(())
    }
}

impl Component {
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn append(self, number: f32, buffer: &mut Vec<u8>) {
        match self {
            Self::I8 => buffer.extend((number as i8).to_le_bytes()),
            Self::U8 => buffer.push(number as u8),
            Self::I16 => buffer.extend((number as i16).to_le_bytes()),
            Self::U16 => buffer.extend((number as u16).to_le_bytes()),
            Self::U32 => buffer.extend((number as u32).to_le_bytes()),
            Self::F32 => buffer.extend(number.to_le_bytes()),
        }
    }

    /// Appends the index of a vertex, which floats would round.
    fn append_index(self, index: u32, buffer: &mut Vec<u8>) {
        match self {
            Self::U8 => buffer.push(index as u8),
            Self::U16 => buffer.extend((index as u16).to_le_bytes()),
            _ => buffer.extend(index.to_le_bytes()),
        }
    }
}

impl Mesh {
    /// The mesh in a view, yet without parts, and the index of its new buffer.
    fn in_view(
        document: &mut Value,
        view: usize,
        owner: &Owner,
        budget: &mut Budget,
    ) -> Result<(usize, Self), Trouble> {
        let (view, place) = named(document, "bufferViews", view, owner)?;
        let range = described(view, &place, owner)?;
        let buffer = add(document, "buffers", json!({}), budget)?;
        Ok((buffer, Self { owner: Rc::clone(owner), range, parts: Vec::new(), length: 0 }))
    }

    pub fn decode(&self, loaded: &[Vec<u8>], budget: &mut Budget) -> Result<Vec<u8>, Trouble> {
        let owner = &self.owner;
        let compressed = self.range.of(loaded, owner)?;
        budget.take(self.length as u64)?;
        let count = |is_meant: fn(&Part) -> bool| self.parts.iter().find(|part| is_meant(part)).map_or(0, |p| p.count);
        let faces = count(|part| part.attribute.is_none()) as u64 / 3;
        // Free again afterwards.
        let mut lent = budget.clone();
        lent.take(TRIANGLE.saturating_mul(faces))?;
        let limits = DecodeLimits::default().with_max_faces(faces).with_max_decoded_bytes(lent.rest());
        let mut mesh = draco_core::Mesh::new();
        let decoded = MeshDecoder::new().decode(&mut DecoderBuffer::new(compressed).with_limits(limits), &mut mesh);
        decoded.map_err(|_| damaged(owner))?;
        let mut buffer = Vec::with_capacity(self.length);
        for part in &self.parts {
            let (found, what) = match part.attribute {
                Some(_) => (mesh.num_points(), "vertices"),
                None => (3 * mesh.num_faces(), "corners of triangles"),
            };
            if found != part.count {
                let said = part.count;
                return Err(format!("{owner} has {found} {what} in its compressed data, and {said} in the file").into());
            }
            part.append(&mesh, &mut buffer).ok_or_else(|| damaged(owner))?;
        }
        Ok(buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A document with many primitives that name one accessor.
    fn document(primitives: usize) -> Value {
        let extension = json!({ EXTENSION: { "bufferView": 0, "attributes": { "POSITION": 0 } } });
        let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "extensions": extension });
        let big = "x".repeat(1000);
        json!({
            "meshes": [{ "name": "Sign", "primitives": vec![primitive; primitives] }],
            "bufferViews": [{ "buffer": 0, "byteLength": 4, "extras": big }],
            "accessors": [
                { "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": vec![1; 1000],
                  "name": big, "extras": big },
                { "componentType": 5121, "count": 3, "type": "SCALAR", "normalized": true },
            ],
        })
    }

    #[test]
    fn copies_of_accessors_hold_what_is_needed_alone() {
        let (mut document, mut buffers) = (document(5), BTreeMap::new());
        assert!(expand(&mut document, &mut buffers, &mut Budget::new(Some(100_000))).is_ok());
        let accessors = document["accessors"].as_array().unwrap();
        assert_eq!(accessors.len(), 2 + 10);
        let copy = json!({ "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3", "normalized": false,
            "min": [0, 0, 0], "max": null });
        assert_eq!(accessors[2], copy);
        assert_eq!(accessors[3]["normalized"], true);
        let Contents::Mesh(mesh) = &buffers[&0] else { panic!("the buffer is no mesh") };
        assert_eq!(mesh.length, 5 * (36 + 4));
        assert_eq!(document["bufferViews"][4]["byteOffset"], 36 + 4 + 36, "the indices of the second primitive");
        assert_eq!(document["buffers"][0]["byteLength"], mesh.length);
    }

    #[test]
    fn what_is_added_counts_against_the_memory() {
        let within = |count: usize| {
            let taken = expand(&mut document(count), &mut BTreeMap::new(), &mut Budget::new(Some(100_000)));
            !matches!(taken, Err(Trouble::Memory(_)))
        };
        assert!(within(5) && !within(500));
    }
}
