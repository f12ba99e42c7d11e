//! Buffer views that meshoptimizer compressed, decoded by the crate `meshoptimizer-rs`.

use super::{
    super::{
        super::{budget::Budget, files::Trouble},
        completed::{list, push},
    },
    Contents, Range, damaged, described, mesh_name,
};
use meshoptimizer_rs::{
    Error, Limits, Workspace,
    codec::{
        decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer_into,
        decode_index_sequence_into, decode_vertex_buffer_into,
    },
};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};

/// Two names of one extension. The second one also has version 1 of the vertex codec, and a filter for colors.
pub const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// A compressed view.
pub struct View {
    /// What it belongs to, for messages.
    owner: String,
    range: Range,
    layout: Layout,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Layout {
    byte_stride: usize,
    count: usize,
    mode: String,
    #[serde(default)]
    filter: Option<String>,
}

fn extension(object: &Value) -> Option<&Value> {
    EXTENSIONS.iter().find_map(|name| object["extensions"].get(name))
}

/// Gives each compressed view a buffer, and marks the buffers of copies.
pub fn expand(document: &mut Value, buffers: &mut BTreeMap<usize, Contents>) -> Result<(), String> {
    let is_fallback = |buffer: &Value| extension(buffer).is_some_and(|extension| extension["fallback"] == true);
    for (index, buffer) in list(document, "buffers").iter().enumerate() {
        if is_fallback(buffer) {
            buffers.insert(index, Contents::Fallback);
        }
    }
    let views = list(document, "bufferViews").iter().enumerate();
    let compressed: Vec<_> = views.filter_map(|(index, view)| Some((index, extension(view)?.clone()))).collect();
    if compressed.is_empty() {
        return Ok(());
    }
    let mut owners = owners(document);
    for (index, extension) in compressed {
        let owner = owners.remove(&index).unwrap_or_else(|| format!("buffer view {index}"));
        let view = View { range: described(&extension, &owner)?, layout: described(&extension, &owner)?, owner };
        let length = view.length().ok_or_else(|| damaged(&view.owner))?;
        let Some(buffer) = push(document, "buffers", json!({ "byteLength": length })) else { continue };
        let fields = &mut list(document, "bufferViews")[index];
        (fields["buffer"], fields["byteOffset"], fields["byteLength"]) = (buffer.into(), 0.into(), length.into());
        buffers.insert(buffer, Contents::View(view));
    }
    Ok(())
}

/// The meshes that views belong to.
fn owners(document: &mut Value) -> HashMap<usize, String> {
    let views: Vec<Option<u64>> =
        list(document, "accessors").iter().map(|accessor| accessor["bufferView"].as_u64()).collect();
    let mut owners = HashMap::new();
    for (index, mesh) in list(document, "meshes").iter().enumerate() {
        for primitive in mesh["primitives"].as_array().into_iter().flatten() {
            let targets = primitive["targets"].as_array().into_iter().flatten();
            let attributes = targets.chain([&primitive["attributes"]]).filter_map(Value::as_object);
            let accessors = attributes.flat_map(|attributes| attributes.values()).chain([&primitive["indices"]]);
            let views = accessors.filter_map(|accessor| *views.get(accessor.as_u64()? as usize)?);
            views.for_each(|view| {
                owners.entry(view as usize).or_insert_with(|| mesh_name(index, mesh));
            });
        }
    }
    owners
}

impl View {
    /// Bytes of the decoded view.
    fn length(&self) -> Option<usize> {
        self.layout.count.checked_mul(self.layout.byte_stride)
    }

    pub fn decode(&self, loaded: &[Vec<u8>], budget: &mut Budget) -> Result<Vec<u8>, Trouble> {
        let Self { owner, range, layout: Layout { byte_stride: stride, count, mode, filter } } = self;
        let (stride, count) = (*stride, *count);
        let compressed = range.of(loaded, owner)?;
        let length = self.length().ok_or_else(|| damaged(owner))?;
        budget.take(length as u64)?;
        let mut bytes = vec![0; length];
        // The budget is the limit of memory, and the work is in proportion to it.
        let workspace = &mut Workspace::new(Limits { max_bytes: usize::MAX, max_work: u64::MAX });
        let decoded = match mode.as_str() {
            "ATTRIBUTES" => decode_vertex_buffer_into(&mut bytes, count, stride, compressed, workspace),
            "TRIANGLES" => decode_index_buffer_into(&mut bytes, count, stride, compressed, workspace),
            "INDICES" => decode_index_sequence_into(&mut bytes, count, stride, compressed, workspace),
            other => return Err(format!("{owner} is compressed in the mode \"{other}\", which is not known").into()),
        };
        let filtered = decoded.and_then(|()| match filter.as_deref().unwrap_or("NONE") {
            "NONE" => Ok(()),
            "OCTAHEDRAL" => decode_filter_oct(&mut bytes, count, stride, workspace),
            "QUATERNION" => decode_filter_quat(&mut bytes, count, stride, workspace),
            "EXPONENTIAL" => decode_filter_exp(&mut bytes, count, stride, workspace),
            "COLOR" => decode_filter_color(&mut bytes, count, stride, workspace),
            _ => Err(Error::InvalidParameter),
        });
        filtered.map_err(|_| damaged(owner))?;
        Ok(bytes)
    }
}
