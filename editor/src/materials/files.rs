//! Files of materials: applies loaded files to a material as a step of undo, and writes materials.

use super::panel::new_slot;
use crate::{
    document::{Document, Edit, TextureEntry},
    workspace::{Workspace, Written},
};
use anyhow::{Context as _, Result};
use lapidary_core::{
    brdf::BrdfFile,
    material::{BUMP, BrdfModel, Material, NORMAL, map_label},
    output::write_atomically,
    texture::{Texture, TextureSlot},
};
use lapidary_interchange::{
    image::file_and_layer,
    import::{MaterialFile, SlotFile, is_materialx},
    materialx::{self, Surface},
};
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Gives a material a map, as a step of undo.
pub fn use_texture(
    work: &mut Workspace,
    index: usize,
    map: &'static str,
    texture: Arc<Texture>,
    file: Option<PathBuf>,
) {
    let Some(mut material) = work.document.materials.get(index).cloned() else { return };
    work.document.textures.push(TextureEntry { texture, file });
    let texture = (work.document.textures.len() - 1) as u32;
    let slot = match material.maps.get(map) {
        Some(old) => TextureSlot { texture, procedural: None, ..old.clone() },
        None => new_slot(map, texture),
    };
    material.maps.set(map, Some(slot));
    work.do_step(Edit::Material { index, material: material.into() }, map_label(map));
}

/// Gives a material the BRDF of a file, as a step of undo.
pub fn use_brdf(work: &mut Workspace, index: usize, file: BrdfFile) {
    let Some(mut material) = work.document.materials.get(index).cloned() else { return };
    if let Some(content) = &file.content {
        material.change_model(content.kind().model());
    }
    material.file = Some(file);
    work.do_step(Edit::Material { index, material: material.into() }, "Load BRDF");
}

/// Indices of `material` beyond the first `given` textures of the document refer to `added`; the document may have more textures
/// since.
pub fn use_material(
    work: &mut Workspace,
    index: usize,
    mut material: Material,
    added: &[Arc<Texture>],
    given: usize,
    file: Option<PathBuf>,
) {
    let folder = file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let since = work.document.textures.len().saturating_sub(given);
    for slot in material.maps.slots_mut().filter(|slot| slot.texture as usize >= given) {
        slot.texture += since as u32;
    }
    for texture in added {
        let (texture, path) = (texture.clone(), folder.join(&texture.name));
        let is_there = file_and_layer(&path).0.is_file();
        work.document.textures.push(TextureEntry { texture, file: is_there.then_some(path) });
    }
    let Some(old) = work.document.materials.get(index) else { return };
    // The bake decides which sides reflect.
    let material = Material { double_sided: old.double_sided, ..material };
    work.do_step(Edit::Material { index, material: material.into() }, "Load material");
}

pub fn save_material(work: &mut Workspace, index: usize, path: &Path) {
    if !work.may_write(path, Written::Other) {
        return;
    }
    let Some(material) = work.document.materials.get(index) else { return };
    let (file, left_out) = material_file(material, &work.document, path);
    let written = write_material(&file, path);
    let remarks = written.as_ref().map_or(Vec::new(), Clone::clone);
    remarks.into_iter().for_each(|remark| work.messages.warning(remark));
    match written {
        Ok(_) if left_out == 0 => work.messages.note(format!("Material written ({})", path.display())),
        Ok(_) => work.messages.warning(format!(
            "Material written without {left_out} maps embedded in the scene file; load them from picture files \
             first ({})",
            path.display()
        )),
        Err(error) => work.messages.error(format!("{error:#}")),
    }
}

/// A material for its own file, and the number of its maps that have no file.
fn material_file(material: &Material, document: &Document, path: &Path) -> (MaterialFile, usize) {
    let folder = path.parent().unwrap_or(Path::new(""));
    let material = &*without_foreign(material);
    let mut left_out = 0;
    let maps = material.maps.filter_map(|slot| {
        if slot.procedural.is_some() {
            return Some(SlotFile::of(slot, String::new()));
        }
        let file = document.textures.get(slot.texture as usize).and_then(|entry| entry.file.as_deref());
        left_out += usize::from(file.is_none());
        let file = file?;
        let file = file.strip_prefix(folder).unwrap_or(file).to_string_lossy().into_owned();
        Some(SlotFile::of(slot, file))
    });
    let Material { name, model, file, parameters, double_sided, vertex_colors, .. } = material.clone();
    // Its contents are not written, but formats without such files approximate them.
    let beside =
        |file: BrdfFile| BrdfFile { path: file.path.strip_prefix(folder).unwrap_or(&file.path).into(), ..file };
    let file = file.filter(|_| model.has_file()).map(beside);
    (MaterialFile { name, model, file, parameters, maps, double_sided, vertex_colors }, left_out)
}

/// A material without the parameters of an earlier BRDF file, which no reader would know.
fn without_foreign(material: &Material) -> Cow<'_, Material> {
    let is_known = |name: &str| BrdfModel::declared_by_models(name).is_some() || [NORMAL, BUMP].contains(&name);
    let mut names = material.parameters.iter().map(|(name, _)| name).chain(material.maps.iter().map(|(name, _)| name));
    if material.model == BrdfModel::Wgsl || names.all(is_known) {
        return Cow::Borrowed(material);
    }
    Cow::Owned(material.own())
}

/// Writes MaterialX or JSON, by extension. Returns remarks on values that the file cannot hold.
fn write_material(file: &MaterialFile, path: &Path) -> Result<Vec<String>> {
    let (text, remarks) = if is_materialx(path) {
        let materialx::Written { text, remarks } = materialx::write(std::slice::from_ref(file), Surface::OpenPbr)?;
        (text, remarks)
    } else {
        (format!("{}\n", serde_json::to_string_pretty(file)?), Vec::new())
    };
    write_atomically(path, text.as_bytes()).with_context(|| {
        format!("cannot write the material; check the free space and permissions ({})", path.display())
    })?;
    Ok(remarks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::document_with_a_map as document;
    use lapidary_core::texture::Procedural;
    use lapidary_interchange::{image, import::load_material};

    #[test]
    fn a_written_material_is_read_again_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("wood.png");
        let image = lapidary_core::image::Image::filled([2, 2], glam::Vec3::ONE);
        image::write(&image, &picture).unwrap();
        let document = document(Some(picture));
        let path = folder.path().join("wood.json");
        let (file, left_out) = material_file(&document.materials[0], &document, &path);
        assert_eq!((left_out, file.maps.get("base_color").unwrap().file.as_str()), (0, "wood.png"));
        for path in [path, folder.path().join("wood.mtlx")] {
            assert_eq!(write_material(&file, &path).unwrap(), [""; 0]);
            let read = load_material(&path, &mut Default::default(), &Default::default()).unwrap().0;
            let (a, b) = (
                read.maps.get("base_color").cloned().unwrap(),
                document.materials[0].maps.get("base_color").cloned().unwrap(),
            );
            assert!((a.rotation - b.rotation).abs() < 1e-6 && a.color_space == b.color_space);
            assert_eq!(read.model == BrdfModel::OpenPbr, is_materialx(&path));
        }
    }

    #[test]
    fn every_map_is_written() {
        let document = document(Some("/a/wood.png".into()));
        let slot = document.materials[0].maps.get("base_color").cloned().unwrap();
        let mut maps = lapidary_core::material::MaterialMaps::default();
        let names: Vec<_> = lapidary_core::material::map_names(Default::default()).collect();
        names.iter().for_each(|name| maps.set(*name, Some(slot.clone())));
        let (file, left_out) =
            material_file(&Material { maps, ..Default::default() }, &document, Path::new("/a/b.json"));
        let written = serde_json::to_value(&file.maps).unwrap();
        assert_eq!((left_out, written.as_object().unwrap().len()), (0, names.len()));
        assert!(written.as_object().unwrap().values().all(|slot| slot["file"] == "wood.png"), "{written}");
    }

    #[test]
    fn a_pattern_is_written_and_needs_no_file() {
        let pattern = Some(Procedural { octaves: 7, ..Default::default() });
        let slot = TextureSlot { procedural: pattern, ..Default::default() };
        let material = Material { maps: [("roughness", slot)].into(), ..Default::default() };
        let (file, left_out) = material_file(&material, &document(None), Path::new("/a/b.json"));
        let text = serde_json::to_string(&file.maps).unwrap();
        assert!(left_out == 0 && !text.contains("file"), "{text}");
        let read: lapidary_interchange::import::MapFiles = serde_json::from_str(&text).unwrap();
        assert_eq!(read.get("roughness").unwrap().procedural, pattern);
    }

    #[test]
    fn a_file_of_a_model_that_it_had_is_not_written_nor_what_it_declares() {
        let example = lapidary_core::brdf::example_file(BrdfModel::Wgsl);
        let mut material = Material { model: BrdfModel::Wgsl, file: example, ..Default::default() };
        material.parameters.set("fibre_spread", 0.5);
        let path = Path::new("/a/b.json");
        let written = |material: &Material| {
            let file = material_file(material, &document(None), path).0;
            (file.file.is_some_and(|file| file.content.is_some()), file.parameters.get("fibre_spread").is_some())
        };
        assert_eq!(written(&material), (true, true), "negative control");
        material.change_model(BrdfModel::Ggx);
        assert_eq!(written(&material), (false, false));
    }

    #[test]
    fn maps_without_a_file_are_counted() {
        let embedded = document(None);
        assert_eq!(material_file(&embedded.materials[0], &embedded, Path::new("a.json")).1, 1);
    }
}
