//! Meshes that Draco compressed, decoded by the crate `draco-core`.

use super::{
    super::{
        super::{budget::Budget, files::Trouble},
        completed::{list, push},
    },
    Contents, Range, damaged, described, mesh_name,
};
use draco_core::{DecodeLimits, DecoderBuffer, FaceIndex, MeshDecoder};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::{BTreeMap, btree_map::Entry};

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
    owner: String,
    range: Range,
    /// The parts in the order of the buffer.
    parts: Vec<Part>,
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
}

/// Gives each compressed mesh a buffer, and its primitives accessors of it.
pub fn expand(document: &mut Value, buffers: &mut BTreeMap<usize, Contents>) -> Result<(), String> {
    let mut by_view: BTreeMap<usize, (usize, Mesh)> = BTreeMap::new();
    for (mesh, primitive) in compressed(document) {
        let fields = &list(document, "meshes")[mesh];
        let owner = mesh_name(mesh, fields);
        let extension = &fields["primitives"][primitive]["extensions"][EXTENSION];
        let Extension { buffer_view, attributes } = described(extension, &owner)?;
        let count = attributes.len();
        if count > MOST_ATTRIBUTES {
            return Err(format!("{owner} has {count} compressed attributes, more than the limit of {MOST_ATTRIBUTES}"));
        }
        let (buffer, mesh_of_view) = match by_view.entry(buffer_view) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(Mesh::in_view(document, buffer_view, owner)?),
        };
        let mut at = Place { document, buffer: *buffer, mesh: mesh_of_view };
        let named = attributes.iter().map(|(name, &id)| (format!("attributes/{name}"), Some(id)));
        for (field, attribute) in named.chain([("indices".to_owned(), None)]) {
            at.add(&format!("/meshes/{mesh}/primitives/{primitive}/{field}"), attribute)?;
        }
        document["meshes"][mesh]["primitives"][primitive]["mode"] = TRIANGLES.into();
    }
    for (buffer, mesh) in by_view.into_values() {
        document["buffers"][buffer]["byteLength"] = mesh.length().into();
        buffers.insert(buffer, Contents::Mesh(mesh));
    }
    Ok(())
}

/// Meshes and primitives with compressed data.
fn compressed(document: &mut Value) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    for (index, mesh) in list(document, "meshes").iter().enumerate() {
        let primitives = mesh["primitives"].as_array().into_iter().flatten().enumerate();
        let has_extension = |primitive: &Value| primitive["extensions"].get(EXTENSION).is_some();
        found.extend(primitives.filter(|(_, p)| has_extension(p)).map(|(primitive, _)| (index, primitive)));
    }
    found
}

/// Where the parts of a mesh are added.
struct Place<'a> {
    document: &'a mut Value,
    buffer: usize,
    mesh: &'a mut Mesh,
}

impl Place<'_> {
    /// Replaces the accessor that the document names at `pointer` by one of the decoded mesh. Attributes that the primitive does not
    /// name stay unread.
    fn add(&mut self, pointer: &str, attribute: Option<u32>) -> Result<(), String> {
        let owner = &self.mesh.owner;
        let index = self.document.pointer(pointer).and_then(Value::as_u64);
        let Some(index) = index else {
            return attribute.map_or_else(|| Err(format!("{owner} is compressed and has no indices")), |_| Ok(()));
        };
        let mut fields = list(self.document, "accessors").get(index as usize).cloned().unwrap_or_default();
        let part = Part::of(&described(&fields, owner)?, attribute).ok_or_else(|| damaged(owner))?;
        let view = json!({ "buffer": self.buffer, "byteOffset": self.mesh.length(), "byteLength": part.length() });
        self.mesh.parts.push(part);
        let Some(view) = push(self.document, "bufferViews", view) else { return Ok(()) };
        if let Some(fields) = fields.as_object_mut() {
            fields.remove("sparse");
            fields.insert("byteOffset".into(), 0.into());
            fields.insert("bufferView".into(), view.into());
        }
        if let (Some(accessor), Some(named)) =
            (push(self.document, "accessors", fields), self.document.pointer_mut(pointer))
        {
            *named = accessor.into();
        }
        Ok(())
    }
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
    fn in_view(document: &mut Value, view: usize, owner: String) -> Result<(usize, Self), String> {
        let view = list(document, "bufferViews").get(view).cloned().unwrap_or_default();
        let range = described(&view, &owner)?;
        let buffer = push(document, "buffers", json!({})).ok_or_else(|| damaged(&owner))?;
        Ok((buffer, Self { owner, range, parts: Vec::new() }))
    }

    /// Bytes of the decoded mesh.
    fn length(&self) -> usize {
        self.parts.iter().map(Part::length).sum()
    }

    pub fn decode(&self, loaded: &[Vec<u8>], budget: &mut Budget) -> Result<Vec<u8>, Trouble> {
        let owner = &self.owner;
        let compressed = self.range.of(loaded, owner)?;
        budget.take(self.length() as u64)?;
        let count = |is_meant: fn(&Part) -> bool| self.parts.iter().find(|part| is_meant(part)).map_or(0, |p| p.count);
        let faces = count(|part| part.attribute.is_none()) as u64 / 3;
        // Free again afterwards.
        let mut lent = budget.clone();
        lent.take(TRIANGLE.saturating_mul(faces))?;
        let limits = DecodeLimits::default().with_max_faces(faces).with_max_decoded_bytes(lent.rest());
        let mut mesh = draco_core::Mesh::new();
        let decoded = MeshDecoder::new().decode(&mut DecoderBuffer::new(compressed).with_limits(limits), &mut mesh);
        decoded.map_err(|_| damaged(owner))?;
        let mut buffer = Vec::with_capacity(self.length());
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
