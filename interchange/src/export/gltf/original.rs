//! Rewrites the materials of the glTF file that a scene came from. Buffers, meshes, nodes, unknown members and
//! unchanged materials stay byte for byte.

use super::container::{self, Members};
use crate::{
    export::{
        error::{ExportError, Exported},
        gltf::{compose::Textures, materials::MaterialWriter},
    },
    image::{PictureFormat, file_and_layer},
    import::{ImportError, ImportOptions, Imported, gltf::container::Container, import_with},
};
use base64::Engine;
use lapidary_core::{
    input,
    material::Material,
    output::{folder_of, is_same_output, write_atomically},
    scene::Scene,
    texture::{Texture, Wrap},
};
use serde_json::{Value, json, value::RawValue};
use std::{
    collections::{BTreeSet, HashMap},
    path::{Path, PathBuf},
    sync::Arc,
};

/// Writes the `original` to `path` with the materials of the scene.
pub fn write(
    scene: &Scene,
    path: &Path,
    original: &Path,
    scene_in_file: Option<&str>,
) -> Result<Exported, ExportError> {
    let io_error = |source| ImportError::Io { path: original.into(), source };
    let bytes = input::read(original).map_err(io_error)?;
    let bytes = input::text(&bytes).map_err(io_error)?;
    let scene_in_file = scene_in_file.map(Into::into);
    let imported =
        import_with(original, &ImportOptions { allow_outside: true, scene: scene_in_file, ..Default::default() })?;
    // It was imported just now.
    let Ok(Container { json, blob }) = Container::of(&bytes) else {
        return Err(ExportError::text(original, "it changed while it was read; export it again"));
    };
    let chunks = blob.map(|blob| container::binary_chunk(blob.to_vec()));
    let chunks = chunks.or(bytes.starts_with(container::MAGIC).then(Vec::new));
    let members: Members = serde_json::from_slice(json).map_err(|error| ExportError::text(original, error))?;
    let count = members.list("materials").len();
    if count > scene.materials.len() {
        let (found, expected) = (count, scene.materials.len());
        return Err(ExportError::Foreign { path: original.into(), found, expected });
    }
    let (text, mut exported) = rewritten(members, scene, &imported).map_err(|error| ExportError::text(path, error))?;
    let is_binary = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
    let contents = match (chunks, is_binary) {
        (Some(chunks), true) => container::binary(&text, &chunks),
        (None, true) => container::binary(&text, &[]),
        (None, false) => Ok(text.into_bytes()),
        (Some(_), false) => Err("the original is a binary file; end the name in .glb".into()),
    };
    let contents = contents.map_err(|reason| ExportError::text(path, reason))?;
    exported.files = copy_companions(json, path, original)?;
    write_atomically(path, &contents).map_err(ExportError::write(path))?;
    exported.files.insert(0, path.into());
    Ok(exported)
}

/// The JSON with the scene's materials.
fn rewritten(mut members: Members, scene: &Scene, imported: &Imported) -> serde_json::Result<(String, Exported)> {
    let (before, raw) = (members.list("materials"), members.raw_list("materials"));
    let theirs = &imported.scene;
    let same = same_textures(&scene.textures, &theirs.textures);
    let (textures, images) = (members.list("textures"), members.list("images"));
    let known = known_textures(&before, theirs, &same);
    let samplers = members.list("samplers");
    let known = Textures {
        known,
        textures: textures.len(),
        images: images.len(),
        samplers: samplers.len(),
        ..Default::default()
    };
    let mut writer = MaterialWriter::new(&scene.textures, known);
    let mut materials = Vec::new();
    let mut changed = 0;
    for ((material, before), raw) in scene.materials.iter().zip(before).zip(raw) {
        let old = &theirs.materials[materials.len()];
        if is_unchanged(material, old, &same) {
            materials.push(raw);
        } else {
            changed += 1;
            if old.vertex_colors && !material.vertex_colors {
                let text = "the colors of its vertices stay in the file, where they show";
                writer.remarks.push(format!("material \"{}\": {text}", material.name));
            }
            let value = writer.material(material, before);
            materials.push(RawValue::from_string(value.to_string())?);
        }
    }
    let mut remarks = std::mem::take(&mut writer.remarks);
    let is_of_none = |index: usize| index >= materials.len() && Some(index as u32) != scene.mesh.ground_material();
    let added = scene
        .materials
        .iter()
        .enumerate()
        .find(|(index, material)| is_of_none(*index) && theirs.materials.get(*index) != Some(material));
    if added.is_some() {
        remarks.push("surfaces without a material keep glTF's default".into());
    }
    let count = materials.len();
    if changed > 0 {
        members.set("materials", &materials)?;
        add_pictures(&mut members, &writer, textures, images, samplers)?;
        add_extensions(&mut members, &writer.used)?;
    }
    Ok((members.text()?, Exported { files: Vec::new(), materials: count, remarks }))
}

fn add_pictures(
    members: &mut Members,
    writer: &MaterialWriter,
    mut textures: Vec<Value>,
    mut images: Vec<Value>,
    mut samplers: Vec<Value>,
) -> serde_json::Result<()> {
    if writer.textures.pictures.is_empty() {
        return Ok(());
    }
    textures.extend(writer.textures.new_textures());
    images.extend(writer.textures.pictures.iter().map(|bytes| json!({"uri": data_uri(bytes)})));
    let new_samplers = writer.textures.new_samplers();
    if !new_samplers.is_empty() {
        samplers.extend(new_samplers);
        members.set("samplers", &samplers)?;
    }
    members.set("textures", &textures)?;
    members.set("images", &images)
}

/// A picture embedded in the text.
pub fn data_uri(bytes: &[u8]) -> String {
    format!("data:{};base64,{}", mime_type(bytes), base64::engine::general_purpose::STANDARD.encode(bytes))
}

/// The MIME type of a picture that glTF supports.
pub fn mime_type(bytes: &[u8]) -> &'static str {
    if PictureFormat::ending_of(bytes) == "jpg" { "image/jpeg" } else { "image/png" }
}

fn add_extensions(members: &mut Members, used: &BTreeSet<&'static str>) -> serde_json::Result<()> {
    let mut all = members.list("extensionsUsed");
    let known: BTreeSet<String> = all.iter().filter_map(|name| name.as_str().map(str::to_owned)).collect();
    let new: Vec<Value> = used.iter().filter(|name| !known.contains(**name)).map(|name| (*name).into()).collect();
    if new.is_empty() {
        return Ok(());
    }
    all.extend(new);
    members.set("extensionsUsed", &all)
}

/// For each texture of the scene, the original's texture with the same bytes.
fn same_textures(ours: &[Arc<Texture>], theirs: &[Arc<Texture>]) -> HashMap<u32, u32> {
    let find = |texture: &Arc<Texture>| {
        theirs.iter().position(|other| {
            other.encoded == texture.encoded && (!texture.encoded.is_empty() || other.name == texture.name)
        })
    };
    (0..).zip(ours).filter_map(|(index, texture)| Some((index, find(texture)? as u32))).collect()
}

fn is_unchanged(ours: &Material, theirs: &Material, same: &HashMap<u32, u32>) -> bool {
    let mut ours = ours.clone();
    for slot in ours.maps.slots_mut() {
        slot.texture = same.get(&slot.texture).copied().unwrap_or(u32::MAX);
    }
    ours == *theirs
}

/// Places of textures in the JSON of a material, by the possible names of their maps.
const PLACES: [(&str, &[&str]); 11] = [
    ("/pbrMetallicRoughness/baseColorTexture", &["base_color"]),
    ("/pbrMetallicRoughness/metallicRoughnessTexture", &["roughness", "specular_roughness"]),
    ("/normalTexture", &["normal"]),
    ("/emissiveTexture", &["emission_color"]),
    ("/extensions/KHR_materials_specular/specularTexture", &["specular", "specular_weight"]),
    ("/extensions/KHR_materials_specular/specularColorTexture", &["specular_color"]),
    ("/extensions/KHR_materials_clearcoat/clearcoatTexture", &["coat_weight"]),
    ("/extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture", &["coat_roughness"]),
    ("/extensions/KHR_materials_sheen/sheenColorTexture", &["fuzz_color"]),
    ("/extensions/KHR_materials_sheen/sheenRoughnessTexture", &["fuzz_roughness"]),
    ("/extensions/KHR_materials_transmission/transmissionTexture", &["geometry_opacity"]),
];

/// The original's textures for the scene's textures and what they show beyond their edges.
fn known_textures(before: &[Value], theirs: &Scene, same: &HashMap<u32, u32>) -> HashMap<(u32, [Wrap; 2]), usize> {
    let mut of_theirs = HashMap::new();
    for (json, material) in before.iter().zip(&theirs.materials) {
        for (place, names) in PLACES {
            let index = json.pointer(place).and_then(|info| info["index"].as_u64());
            let slot = names.iter().find_map(|name| material.maps.get(name));
            if let (Some(index), Some(slot)) = (index, slot) {
                of_theirs.entry((slot.texture, slot.wrap)).or_insert(index as usize);
            }
        }
    }
    let ours = |texture: u32| same.iter().filter(move |(_, theirs)| **theirs == texture).map(|(ours, _)| *ours);
    of_theirs
        .into_iter()
        .flat_map(|((texture, wrap), index)| ours(texture).map(move |ours| ((ours, wrap), index)))
        .collect()
}

/// Copies the buffers and pictures that the file names into the output's folder.
fn copy_companions(json: &[u8], path: &Path, original: &Path) -> Result<Vec<PathBuf>, ExportError> {
    let (from, to) = (folder_of(original), folder_of(path));
    let members: Members = serde_json::from_slice(json).map_err(|error| ExportError::text(original, error))?;
    let all = [members.list("buffers"), members.list("images")].concat();
    let uris = all.iter().filter_map(|item| item["uri"].as_str()).filter(|uri| !uri.starts_with("data:"));
    let names: BTreeSet<String> = uris.map(crate::import::percent_decoded).collect();
    let mut copied = Vec::new();
    for name in names {
        // It may be a layer of a file.
        let layer = file_and_layer(&from.join(&name)).1.map_or(0, |layer| layer.len() + 1);
        let name = &name[..name.len() - layer];
        let (source, target) = (from.join(name), to.join(name));
        // Files outside are found from a sibling folder as before, or not at all.
        let is_inside = Path::new(name)
            .components()
            .all(|part| matches!(part, std::path::Component::Normal(_) | std::path::Component::CurDir));
        if !source.is_file() || !is_inside || is_same_output(&source, &target) {
            continue;
        }
        let bytes = input::read(&source).map_err(|error| ImportError::Io { path: source.clone(), source: error })?;
        if target.exists() {
            if input::read(&target).ok().as_ref() != Some(&bytes) {
                return Err(ExportError::Occupied { path: target });
            }
            continue;
        }
        std::fs::create_dir_all(folder_of(&target)).map_err(ExportError::write(&target))?;
        write_atomically(&target, &bytes).map_err(ExportError::write(&target))?;
        copied.push(target);
    }
    Ok(copied)
}
