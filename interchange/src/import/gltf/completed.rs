//! Completes what valid files may leave out and the `gltf` crate requires, before it parses them. Everything here changes the
//! JSON only.

use super::{
    super::{budget::Budget, files::Trouble},
    compressed::Compressed,
    glossiness, pointers,
};
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};

/// The JSON of a file, completed.
pub(super) struct Completed {
    /// The JSON text.
    pub text: Vec<u8>,
    /// Animations that had channels without a node.
    pub pointing: Vec<usize>,
    /// Names of the materials with textures without a picture, which are removed.
    pub without_picture: Vec<String>,
    /// By texture, its own picture, where one in an extension comes before it.
    pub other_pictures: HashMap<usize, usize>,
    pub compressed: Compressed,
}

/// Completes the `document` of a JSON text; one that lacks nothing stays as it is, to the byte.
///
/// # Errors
/// Compressed data that are not described completely, or [`Trouble::Memory`] for what is added.
pub(super) fn completed(mut document: Value, text: &[u8], budget: &mut Budget) -> Result<Completed, Trouble> {
    let pointing = pointers::remove(&mut document);
    // What this adds is taken below, with the rest of the text.
    let compressed = Compressed::of(&mut document, &mut budget.clone())?;
    let mut is_changed = !pointing.is_empty() || !compressed.is_empty();
    is_changed |= glossiness::convert(&mut document);
    is_changed |= complete_scenes(&mut document);
    is_changed |= complete_positions(&mut document);
    is_changed |= complete_accessors(&mut document);
    let other_pictures = other_pictures(&mut document);
    let without_picture = complete_textures(&mut document);
    is_changed |= without_picture.is_some();
    let completed = if is_changed { document.to_string().into_bytes() } else { text.to_vec() };
    budget.take_growth(text, &completed)?;
    let text = completed;
    let without_picture = without_picture.unwrap_or_default();
    Ok(Completed { text, pointing, without_picture, other_pictures, compressed })
}

/// The elements of a list member.
pub(super) fn list<'a>(json: &'a mut Value, name: &str) -> &'a mut [Value] {
    json.get_mut(name).and_then(Value::as_array_mut).map(Vec::as_mut_slice).unwrap_or_default()
}

/// Appends to a list member, which is made if it is missing. Returns the index; `None` if the member is no list.
pub(super) fn push(json: &mut Value, name: &str, value: Value) -> Option<usize> {
    let list = json.as_object_mut()?.entry(name).or_insert_with(|| json!([])).as_array_mut()?;
    list.push(value);
    Some(list.len() - 1)
}

/// Gives scenes without nodes an empty list of them.
fn complete_scenes(document: &mut Value) -> bool {
    let mut is_changed = false;
    let without_nodes = |scene: &&mut Value| scene.get("nodes").is_none();
    for scene in list(document, "scenes").iter_mut().filter(without_nodes).filter_map(Value::as_object_mut) {
        scene.insert("nodes".into(), json!([]));
        is_changed = true;
    }
    is_changed
}

/// Gives positions bounds where they have none. The import measures them itself.
fn complete_positions(document: &mut Value) -> bool {
    let primitives = list(document, "meshes").iter().flat_map(|mesh| mesh["primitives"].as_array()).flatten();
    let indices = primitives.filter_map(|primitive| primitive["attributes"]["POSITION"].as_u64());
    let positions: Vec<usize> = indices.filter_map(|index| usize::try_from(index).ok()).collect();
    let mut is_changed = false;
    let accessors = list(document, "accessors");
    for index in positions {
        let Some(accessor) = accessors.get_mut(index).and_then(Value::as_object_mut) else { continue };
        for bound in ["min", "max"] {
            let is_point =
                |value: &Value| value.as_array().is_some_and(|v| v.len() == 3 && v.iter().all(Value::is_number));
            if !accessor.get(bound).is_some_and(is_point) {
                accessor.insert(bound.into(), json!([0, 0, 0]));
                is_changed = true;
            }
        }
    }
    is_changed
}

/// Accessors without data are zeros (glTF 2.0, section 5.1.1). One element of zeros replaces the first, sparsely: this needs no
/// memory for the others.
fn complete_accessors(document: &mut Value) -> bool {
    let is_without_data = |accessor: &Value| {
        accessor.is_object() && accessor.get("bufferView").is_none() && accessor.get("sparse").is_none()
    };
    if !list(document, "accessors").iter().any(is_without_data) {
        return false;
    }
    // Sixteen floats are the largest element.
    let zeros = format!("data:application/octet-stream;base64,{}", "A".repeat(86));
    let buffer = push(document, "buffers", json!({ "byteLength": 64, "uri": zeros }));
    let view = push(document, "bufferViews", json!({ "buffer": buffer, "byteLength": 64 }));
    let Some(view) = buffer.and(view) else { return false };
    for accessor in list(document, "accessors").iter_mut().filter(|accessor| is_without_data(accessor)) {
        accessor["sparse"] = json!({
            "count": 1,
            "indices": { "bufferView": view, "componentType": 5121 },
            "values": { "bufferView": view },
        });
    }
    true
}

/// The extensions whose pictures are read, and come before those for other programs.
pub(super) const PICTURES: [&str; 2] = ["EXT_texture_webp", "KHR_texture_basisu"];

/// The picture that an extension of a texture names, and whether it comes before the texture's own.
fn source_in_extension(texture: &Value) -> Option<(u64, bool)> {
    let extensions = &texture["extensions"];
    let read = PICTURES.iter().find_map(|name| extensions[name]["source"].as_u64());
    let other = || extensions.as_object()?.values().find_map(|extension| extension["source"].as_u64());
    read.map(|source| (source, true)).or_else(|| Some((other()?, false)))
}

/// The textures' own pictures, where one in an extension comes before them.
fn other_pictures(document: &mut Value) -> HashMap<usize, usize> {
    let textures = list(document, "textures").iter().enumerate();
    let other = |(index, texture): (usize, &Value)| {
        source_in_extension(texture).filter(|(_, comes_first)| *comes_first)?;
        Some((index, texture["source"].as_u64()?.try_into().ok()?))
    };
    textures.filter_map(other).collect()
}

/// Finds the pictures of textures whose `source` is in an extension, such as EXT_texture_webp, and removes textures without any
/// from the materials. Returns the names of these materials; `None` if nothing changed.
fn complete_textures(document: &mut Value) -> Option<Vec<String>> {
    let mut empty = HashSet::new();
    let mut is_changed = false;
    for (index, texture) in list(document, "textures").iter_mut().enumerate() {
        let in_extension = source_in_extension(texture);
        let Some(fields) = texture.as_object_mut() else { continue };
        let source = match in_extension {
            Some((source, comes_first)) if comes_first || !fields.contains_key("source") => Some(source),
            _ if fields.contains_key("source") => continue,
            _ => None,
        };
        fields.insert("source".into(), json!(source.unwrap_or(0)));
        is_changed = true;
        if source.is_none() {
            empty.insert(index as u64);
        }
    }
    if !is_changed {
        return None;
    }
    if !empty.is_empty() && list(document, "images").is_empty() {
        push(document, "images", json!({ "uri": "" }));
    }
    let mut names = Vec::new();
    for (index, material) in list(document, "materials").iter_mut().enumerate() {
        if remove_textures(material, &empty) {
            names.push(material["name"].as_str().map_or_else(|| format!("material {index}"), str::to_owned));
        }
    }
    Some(names)
}

/// Removes the uses of textures from a material. Returns whether it had some.
fn remove_textures(value: &mut Value, textures: &HashSet<u64>) -> bool {
    let Some(fields) = value.as_object_mut() else { return false };
    let is_removed = |name: &String, value: &Value| {
        name.ends_with("Texture") && value["index"].as_u64().is_some_and(|index| textures.contains(&index))
    };
    let count = fields.len();
    fields.retain(|name, value| !is_removed(name, value));
    let mut has_some = fields.len() < count;
    for inner in fields.values_mut() {
        has_some |= remove_textures(inner, textures);
    }
    has_some
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_text_grows_by_counts_against_the_memory() {
        let text = format!(r#"{{"scenes": [{{}}{}]}}"#, ",{}".repeat(999));
        let within = |bytes: u64| {
            let taken = completed(serde_json::from_str(&text).unwrap(), text.as_bytes(), &mut Budget::new(Some(bytes)));
            !matches!(taken, Err(Trouble::Memory(_)))
        };
        // Each scene gets the ten bytes of `"nodes":[]`, which are held twice.
        assert!(within(20_000) && !within(19_000));
    }
}
