//! Files that a document uses: textures and materials that were loaded, written, or changed on disk.

use super::state::{
    EditorState,
    prompt::{Again, Prompt},
};
use crate::{
    actions::Action,
    document::{Document, Edit, TextureEntry, folder_of},
    jobs::load::{LoadResult, Loaded, Source, Topic},
    panels::material::new_slot,
    preferences::AllowedFolders,
    workspace::{Written, brdf_files, files_in_use},
};
use anyhow::{Context as _, Result};
use lapidary_core::{
    brdf::BrdfFile,
    import::{MaterialFile, SlotFile, is_materialx},
    input,
    material::{BUMP, BrdfModel, Material, NORMAL, map_label},
    materialx::{self, Surface},
    output::write_atomically,
    texture::{Texture, TextureSlot},
};
use lapidary_studies::args::shader_source;
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
    sync::Arc,
};

impl EditorState {
    /// Begins to read a file.
    pub(super) fn load(&mut self, topic: Topic, source: Source, path: PathBuf) {
        let id = self.loader.load(topic, source);
        self.loading.insert(id, path);
    }

    pub(super) fn collect_loaded(&mut self) {
        for LoadResult { id, topic, result, .. } in self.loader.results() {
            let path = self.loading.remove(&id);
            match (topic, result) {
                (Topic::Environment, result) => self.environment_loaded(result.and_then(into_environment)),
                (Topic::Reload(path), result) => self.reloaded(&path, result),
                (_, Err(error)) => self.work.messages.error(error),
                (Topic::Map { material, map }, Ok(Loaded::Texture(texture))) => {
                    self.use_texture(material, map, texture, path);
                }
                (Topic::Brdf(index), Ok(Loaded::Brdf { content, remarks })) => {
                    remarks.into_iter().for_each(|remark| self.work.messages.warning(remark));
                    path.into_iter()
                        .for_each(|path| self.use_brdf(index, BrdfFile { path, content: Some(content.clone()) }));
                }
                (Topic::Material(index), Ok(Loaded::Material { material, textures, given, warnings })) => {
                    warnings.into_iter().for_each(|warning| self.work.messages.warning(warning));
                    self.use_material(index, *material, &textures[given..], given, path);
                }
                (Topic::Material(material), Ok(Loaded::Several(names))) => {
                    let prompt = |file| Prompt::Several { file, names, material };
                    path.map(prompt).into_iter().for_each(|prompt| self.ask(prompt));
                }
                (Topic::Material(index), Ok(Loaded::Outside(names))) => {
                    let material = |file| Prompt::Outside { file, names, then: Again::Load(index) };
                    path.map(material).into_iter().for_each(|prompt| self.ask(prompt));
                }
                // Topics and sources go together where they are asked for.
                _ => {}
            }
        }
    }

    /// Gives a material a map, as a step of undo.
    fn use_texture(&mut self, index: usize, map: &'static str, texture: Arc<Texture>, file: Option<PathBuf>) {
        let Some(mut material) = self.work.document.materials.get(index).cloned() else { return };
        self.work.document.textures.push(TextureEntry { texture, file });
        let texture = (self.work.document.textures.len() - 1) as u32;
        let slot = match material.maps.get(map) {
            Some(old) => TextureSlot { texture, procedural: None, ..old.clone() },
            None => new_slot(map, texture),
        };
        material.maps.set(map, Some(slot));
        self.work.do_step(Edit::Material { index, material: material.into() }, map_label(map));
    }

    /// Gives a material the BRDF of a file, as a step of undo.
    fn use_brdf(&mut self, index: usize, file: BrdfFile) {
        let Some(mut material) = self.work.document.materials.get(index).cloned() else { return };
        if let Some(content) = &file.content {
            material.change_model(content.kind().model());
        }
        material.file = Some(file);
        self.work.do_step(Edit::Material { index, material: material.into() }, "Load BRDF");
    }

    /// `added` are the textures that the material refers to after the first `given` ones of the document, which may
    /// have got more textures since.
    fn use_material(
        &mut self,
        index: usize,
        mut material: Material,
        added: &[Arc<Texture>],
        given: usize,
        file: Option<PathBuf>,
    ) {
        let folder = file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let since = self.work.document.textures.len().saturating_sub(given);
        for slot in material.maps.slots_mut().filter(|slot| slot.texture as usize >= given) {
            slot.texture += since as u32;
        }
        for texture in added {
            let (texture, path) = (texture.clone(), folder.join(&texture.name));
            self.work.document.textures.push(TextureEntry { texture, file: path.is_file().then_some(path) });
        }
        let Some(old) = self.work.document.materials.get(index) else { return };
        // Which sides reflect was baked.
        let material = Material { double_sided: old.double_sided, ..material };
        self.work.do_step(Edit::Material { index, material: material.into() }, "Load material");
    }

    pub(super) fn save_material(&mut self, index: usize, path: &Path) {
        if !self.work.may_write(path, Written::Other) {
            return;
        }
        let Some(material) = self.work.document.materials.get(index) else { return };
        let (file, left_out) = material_file(material, &self.work.document, path);
        let written = write_material(&file, path);
        let remarks = written.as_ref().map_or(Vec::new(), Clone::clone);
        remarks.into_iter().for_each(|remark| self.work.messages.warning(remark));
        match written {
            Ok(_) if left_out == 0 => self.work.messages.note(format!("Material written ({})", path.display())),
            Ok(_) => self.work.messages.warning(format!(
                "Material written without {left_out} maps that came inside the scene's file; load pictures of their own for \
                 them first ({})",
                path.display()
            )),
            Err(error) => self.work.messages.error(format!("{error:#}")),
        }
    }

    /// Watches the files in use, and reads those again that have changed.
    pub(super) fn collect_changed_files(&mut self) {
        let files: Vec<PathBuf> =
            files_in_use(&self.work.document).into_iter().chain(shader_source().files()).collect();
        if files != self.watched {
            self.watcher.watch(files.clone());
            self.watched = files;
        }
        for path in self.watcher.changed() {
            let is_brdf = brdf_files(&self.work.document).any(|file| file.path == path);
            if !is_brdf && path.extension().is_some_and(|e| e == "wgsl") {
                self.render.reload();
                continue;
            }
            let spec = &self.work.document.environment.spec;
            let source = if self.work.document.environment.file() == Some(&path) {
                self.environments.forget_picture(spec);
                Source::Environment(spec.clone())
            } else if self.work.document.scene.as_ref() == Some(&path) {
                Source::Scene { path: path.clone(), allow_outside: self.work.preferences.outside.allow(&path) }
            } else if is_brdf {
                Source::Brdf(path.clone())
            } else if may_be_read(&path, &self.work.document, &self.work.preferences.outside) {
                Source::Texture(path.clone())
            } else {
                continue;
            };
            self.loader.load(Topic::Reload(path), source);
        }
    }

    /// A file was read again. If it could not be, what was read before stays.
    fn reloaded(&mut self, path: &Path, result: Result<Loaded, String>) {
        match result {
            Ok(Loaded::Texture(texture)) => {
                let files: Vec<_> = self.work.document.textures.iter().map(|e| self.work.document.file_of(e)).collect();
                let of_file =
                    self.work.document.textures.iter_mut().zip(files).filter(|(_, f)| f.as_deref() == Some(path));
                for (entry, _) in of_file {
                    // The scene knows it by this name.
                    let name = entry.texture.name.clone();
                    entry.texture = Texture { name, ..(*texture).clone() }.into();
                }
                self.work.messages.note(format!("Loaded again ({})", path.display()));
            }
            Ok(Loaded::Brdf { content, remarks }) => {
                remarks.into_iter().for_each(|remark| self.work.messages.warning(remark));
                let materials = self.work.document.materials.iter_mut().chain(self.work.history.materials_mut());
                let files = materials.filter_map(|material| material.file.as_mut());
                files.filter(|file| file.path == path).for_each(|file| file.content = Some(content.clone()));
                self.work.messages.note(format!("Loaded again ({})", path.display()));
            }
            Ok(Loaded::Scene(source)) => self.work.scene_changed(path, *source),
            // Another one may have been chosen meanwhile.
            Ok(_) if self.work.document.environment.file() != Some(path) => {}
            Ok(loaded) => {
                self.environment_loaded(into_environment(loaded));
                self.work.messages.note(format!("Loaded again ({})", path.display()));
            }
            Err(error) => self.work.messages.warning(format!("A file has changed and cannot be read now: {error}")),
        }
    }
}

type LoadedEnvironment = (Arc<lapidary_core::environment::Environment>, Vec<String>);

fn into_environment(loaded: Loaded) -> Result<LoadedEnvironment, String> {
    match loaded {
        Loaded::Environment { environment, warnings } => Ok((environment, warnings)),
        _ => Err("that is no environment".into()),
    }
}

/// Whether a picture was chosen by the user, is in the folder of the scene, or may be elsewhere.
fn may_be_read(picture: &Path, document: &Document, allowed: &AllowedFolders) -> bool {
    let is_chosen = document.textures.iter().any(|entry| entry.file.as_deref() == Some(picture));
    let of_scene = |scene: &Path| input::is_inside(&folder_of(scene), picture) || allowed.allow(scene);
    is_chosen || document.scene.as_deref().is_some_and(of_scene)
}

/// A material for a file of its own, and how many of its maps have no file to name.
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
    let Material { name, model, file, parameters, double_sided, .. } = material.clone();
    // Its contents are not written, but formats without such files estimate by them.
    let beside =
        |file: BrdfFile| BrdfFile { path: file.path.strip_prefix(folder).unwrap_or(&file.path).into(), ..file };
    let file = file.filter(|_| model.has_file()).map(beside);
    (MaterialFile { name, model, file, parameters, maps, double_sided }, left_out)
}

/// A material without what only the file of a BRDF that it had before declares: without that file, no reader knows it.
fn without_foreign(material: &Material) -> Cow<'_, Material> {
    let is_known = |name: &str| BrdfModel::declared_by_models(name).is_some() || [NORMAL, BUMP].contains(&name);
    let mut names = material.parameters.iter().map(|(name, _)| name).chain(material.maps.iter().map(|(name, _)| name));
    if material.model == BrdfModel::Wgsl || names.all(is_known) {
        return Cow::Borrowed(material);
    }
    Cow::Owned(material.own())
}

/// As MaterialX or JSON, by the extension. Returns what the file does not hold.
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

/// Uses a picture for the base colour of a material.
pub fn as_base_color(material: usize, path: PathBuf) -> Action {
    Action::LoadTexture { material, map: "base_color", path: Some(path) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{
        import::load_material,
        texture::{ColorSpace, Procedural},
    };

    fn document(file: Option<PathBuf>) -> Document {
        let texture = Arc::new(Texture::missing("wood.png"));
        let slot = Some(TextureSlot { rotation: 0.5, color_space: ColorSpace::Srgb, ..TextureSlot::default() });
        let mut material = Material { name: "wood".into(), ..Default::default() };
        material.maps.set("base_color", slot);
        Document { materials: vec![material], textures: vec![TextureEntry { texture, file }], ..Document::empty() }
    }

    #[test]
    fn a_written_material_is_read_again_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("wood.png");
        let image = lapidary_core::image::Image::filled([2, 2], glam::Vec3::ONE);
        image.write(&picture).unwrap();
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
        let read: lapidary_core::import::MapFiles = serde_json::from_str(&text).unwrap();
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
    fn a_picture_elsewhere_that_only_the_scene_names_is_not_read_unless_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let [scene, inside, outside] =
            ["inner/a.obj", "inner/wood.png", "wood.png"].map(|name| folder.path().join(name));
        std::fs::create_dir(folder.path().join("inner")).unwrap();
        [&scene, &inside, &outside].into_iter().for_each(|file| std::fs::write(file, "").unwrap());
        let of_scene = Document { scene: Some(scene.clone()), ..document(None) };
        let mut allowed = AllowedFolders::default();
        assert!(may_be_read(&inside, &of_scene, &allowed) && !may_be_read(&outside, &of_scene, &allowed));
        assert!(may_be_read(&outside, &document(Some(outside.clone())), &allowed), "the user chose it");
        allowed.remember(&scene);
        assert!(may_be_read(&outside, &of_scene, &allowed));
    }

    #[test]
    fn maps_without_a_file_are_counted_and_only_files_in_use_are_watched() {
        let embedded = document(None);
        assert_eq!(material_file(&embedded.materials[0], &embedded, Path::new("a.json")).1, 1);
        assert!(files_in_use(&embedded).is_empty(), "the default light is a formula");
        let beside = Document { scene: Some("/b/scene.gltf".into()), ..embedded };
        let mut expected = [Path::new("/b").join(&beside.textures[0].texture.name), "/b/scene.gltf".into()];
        expected.sort();
        assert_eq!(files_in_use(&beside), expected);
        let mut document = document(Some("/a/wood.png".into()));
        document.environment.spec = "/a/sky.hdr".into();
        assert_eq!(files_in_use(&document), [PathBuf::from("/a/sky.hdr"), "/a/wood.png".into()]);
        document.materials[0].maps.set("base_color", None);
        assert_eq!(files_in_use(&document), [PathBuf::from("/a/sky.hdr")]);
    }
}
