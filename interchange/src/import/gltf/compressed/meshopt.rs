//! Buffer views that meshoptimizer compressed, decoded by the crate `meshoptimizer-rs`.

use super::{
    super::{
        super::{budget::Budget, files::Trouble},
        completed::list,
    },
    Contents, Owner, Range, add, damaged, described, mesh_name,
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
use std::{
    collections::{BTreeMap, HashMap},
    rc::Rc,
};

/// Two names of one extension. The second one also has version 1 of the vertex codec, and a filter for colors.
pub const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// A compressed view.
pub struct View {
    /// What it belongs to, for messages.
    owner: Owner,
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

/// The extension of an object, and its name.
fn extension(object: &Value) -> Option<(&'static str, &Value)> {
    EXTENSIONS.into_iter().find_map(|name| Some((name, object["extensions"].get(name)?)))
}

/// Gives each compressed view a buffer, and marks the buffers of copies.
pub fn expand(
    document: &mut Value,
    buffers: &mut BTreeMap<usize, Contents>,
    budget: &mut Budget,
) -> Result<(), Trouble> {
    let is_fallback = |buffer: &Value| extension(buffer).is_some_and(|(_, extension)| extension["fallback"] == true);
    for (index, buffer) in list(document, "buffers").iter().enumerate() {
        if is_fallback(buffer) {
            buffers.insert(index, Contents::Fallback);
        }
    }
    let views = list(document, "bufferViews").iter().enumerate();
    let of_view = |(index, view)| extension(view).map(|(name, extension)| (index, name, extension.clone()));
    let compressed: Vec<_> = views.filter_map(of_view).collect();
    if compressed.is_empty() {
        return Ok(());
    }
    let mut owners = owners(document);
    for (index, name, extension) in compressed {
        let owner = owners.remove(&index).unwrap_or_else(|| format!("buffer view {index}").into());
        let (range, layout) = (described(&extension, name, &owner)?, described(&extension, name, &owner)?);
        let view = View { owner, range, layout };
        let length = view.length().ok_or_else(|| damaged(&view.owner))?;
        let buffer = add(document, "buffers", json!({ "byteLength": length }), budget)?;
        let fields = &mut list(document, "bufferViews")[index];
        (fields["buffer"], fields["byteOffset"], fields["byteLength"]) = (buffer.into(), 0.into(), length.into());
        buffers.insert(buffer, Contents::View(view));
    }
    Ok(())
}

/// The meshes that views belong to.
fn owners(document: &mut Value) -> HashMap<usize, Owner> {
    let views: Vec<Option<u64>> =
        list(document, "accessors").iter().map(|accessor| accessor["bufferView"].as_u64()).collect();
    let mut owners = HashMap::new();
    for (index, mesh) in list(document, "meshes").iter().enumerate() {
        let name = mesh_name(index, mesh);
        for primitive in mesh["primitives"].as_array().into_iter().flatten() {
            let targets = primitive["targets"].as_array().into_iter().flatten();
            let attributes = targets.chain([&primitive["attributes"]]).filter_map(Value::as_object);
            let accessors = attributes.flat_map(|attributes| attributes.values()).chain([&primitive["indices"]]);
            let views = accessors.filter_map(|accessor| *views.get(accessor.as_u64()? as usize)?);
            views.for_each(|view| {
                owners.entry(view as usize).or_insert_with(|| Rc::clone(&name));
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

#[cfg(test)]
mod tests {
    use super::*;
    use meshoptimizer_rs::codec::{VertexEncoding, encode_vertex_buffer};

    fn view(stride: usize, filter: &str, bytes: &[u8]) -> Vec<u8> {
        let (encoding, count) = (VertexEncoding::new(0, 2).unwrap(), bytes.len() / stride);
        let compressed = encode_vertex_buffer(bytes, count, stride, encoding, &mut Workspace::default()).unwrap();
        let range = Range { buffer: 0, byte_offset: 0, byte_length: compressed.len() };
        let layout = Layout { byte_stride: stride, count, mode: "ATTRIBUTES".into(), filter: Some(filter.to_owned()) };
        let view = View { owner: "a".into(), range, layout };
        let decoded = view.decode(&[compressed], &mut Budget::new(None));
        decoded.unwrap_or_else(|_| panic!("{filter} of {stride} bytes is not read"))
    }

    fn bytes(numbers: &[[i8; 4]]) -> Vec<u8> {
        numbers.iter().flatten().flat_map(|number| number.to_le_bytes()).collect()
    }

    fn words(numbers: &[[i16; 4]]) -> Vec<u8> {
        numbers.iter().flatten().flat_map(|number| number.to_le_bytes()).collect()
    }

    /// Worked out by hand from `KHR_meshopt_compression`, appendix B.
    #[test]
    fn filters_give_the_numbers_of_the_specification() {
        // With 7 for 1: (3, 0, 4) / 5, then (2, -3, -2) / sqrt(17) from the lower half, then the axis.
        let stored = [[3, 0, 7, 5], [4, -5, 7, 0], [0, 0, 7, -1]];
        let normals = [[76, 0, 102, 5], [62, -92, -62, 0], [0, 0, 127, -1]];
        assert_eq!(view(4, "OCTAHEDRAL", &bytes(&stored)), bytes(&normals));
        let wide = stored.map(|numbers| numbers.map(i16::from));
        let normals = [[19660, 0, 26214, 5], [15894, -23841, -15894, 0], [0, 0, 32767, -1]];
        assert_eq!(view(8, "OCTAHEDRAL", &words(&wide)), words(&normals));
        // With 127 for 1, and the index of the largest component in its lowest bits: sqrt(0.5) is 23170 / 32767.
        let stored = [[127, 0, 0, 127], [0, 127, 0, 125], [-127, 0, 0, 124], [0, 0, 0, 126]];
        let turns = [[23170, 0, 0, 23170], [0, 23170, 0, 23170], [23170, -23170, 0, 0], [0, 0, 32767, 0]];
        assert_eq!(view(8, "QUATERNION", &words(&stored)), words(&turns));
        // Luma 100, chrominance 20 and -30 of 8 bits; then of 7 bits, scaled by 255 / 127.
        let colors = [150, 70, 110, 255, 129, 64, 0, 129];
        assert_eq!(view(4, "COLOR", &bytes(&[[100, 20, -30, -1], [32, 32, 0, 0x60]])), colors);
        let wide = view(8, "COLOR", &words(&[[1000, 200, -300, -1]]));
        assert_eq!(wide, words(&[[1500, 700, 1100, -1]]));
        assert_eq!(view(8, "NONE", &words(&stored)), words(&stored), "negative control");
    }

    #[test]
    fn views_of_a_mesh_share_its_name() {
        let extension = json!({ "buffer": 0, "byteLength": 4, "byteStride": 4, "count": 1, "mode": "ATTRIBUTES" });
        let views = vec![json!({ "buffer": 0, "byteLength": 4, "extensions": { EXTENSIONS[0]: extension } }); 3];
        let document = json!({
            "meshes": [{ "name": "Sign", "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 } }] }],
            "accessors": [{ "bufferView": 0 }, { "bufferView": 1 }, { "bufferView": 2 }],
            "bufferViews": views,
        });
        let mut buffers = BTreeMap::new();
        assert!(expand(&mut document.clone(), &mut buffers, &mut Budget::new(Some(100_000))).is_ok());
        let owner = |index: usize| match &buffers[&index] {
            Contents::View(view) => Rc::clone(&view.owner),
            _ => panic!("buffer {index} is no view"),
        };
        assert!(&*owner(0) == "the mesh \"Sign\"" && Rc::ptr_eq(&owner(0), &owner(1)));
        assert!(&*owner(2) == "buffer view 2", "negative control");
        let refused = expand(&mut document.clone(), &mut buffers, &mut Budget::new(Some(1000)));
        assert!(matches!(refused, Err(Trouble::Memory(_))), "three buffers take more");
    }
}
