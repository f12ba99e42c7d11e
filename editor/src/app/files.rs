//! Files of the document: hands loaded files to their features, and reloads files that changed on disk.

use super::state::{
    EditorState,
    prompt::{Again, Prompt},
};
use crate::{
    actions::{Action, MaterialAction},
    document::{Document, folder_of},
    jobs::load::{LoadResult, Loaded, Source, Topic},
    materials,
    preferences::AllowedFolders,
    workspace::{brdf_files, files_in_use},
};
use anyhow::Result;
use lapidary_core::{brdf::BrdfFile, input, material::Material, texture::Texture};
use lapidary_interchange::{image::file_and_layer, import::ImportOptions};
use lapidary_studies::args::shader_source;
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::Arc,
};

impl EditorState {
    /// Takes loaded files.
    pub(super) fn collect_loaded(&mut self) {
        for LoadResult { path, topic, result, .. } in self.loader.results() {
            match (topic, result) {
                (Topic::Environment, result) => {
                    self.environments.take_loaded(&mut self.work, result.and_then(into_environment))
                }
                (Topic::Reload(path), result) => self.reloaded(&path, result),
                (_, Err(error)) => self.work.messages.error(error),
                (Topic::Map { material, map }, Ok(Loaded::Texture(texture))) => {
                    materials::use_texture(&mut self.work, material, map, texture, path);
                }
                (Topic::Brdf(index), Ok(Loaded::Brdf { content, remarks })) => {
                    remarks.into_iter().for_each(|remark| self.work.messages.warning(remark));
                    path.into_iter().for_each(|path| {
                        materials::use_brdf(&mut self.work, index, BrdfFile { path, content: Some(content.clone()) })
                    });
                }
                (Topic::Material(index), Ok(Loaded::Material { material, textures, given, warnings })) => {
                    warnings.into_iter().for_each(|warning| self.work.messages.warning(warning));
                    materials::use_material(&mut self.work, index, *material, &textures[given..], given, path);
                }
                (Topic::Material(material), Ok(Loaded::Several(names))) => {
                    let prompt = |file| Prompt::Several { file, names, material };
                    path.map(prompt).into_iter().for_each(|prompt| self.questions.ask(prompt));
                }
                (Topic::Material(index), Ok(Loaded::Outside(names))) => {
                    let material = |file| Prompt::Outside { file, names, then: Again::Load(index) };
                    path.map(material).into_iter().for_each(|prompt| self.questions.ask(prompt));
                }
                // Requests pair topics with sources, so no other pair arrives.
                _ => {}
            }
        }
    }

    /// Watches the files in use, and reloads changed ones.
    pub(super) fn collect_changed_files(&mut self) {
        let files: Vec<PathBuf> = files_in_use(&self.work.document)
            .into_iter()
            .chain(self.files_of_scene())
            .chain(shader_source().files())
            .collect();
        self.watcher.watch(files);
        for path in self.watcher.changed() {
            self.file_changed(path);
        }
    }

    /// The files that the scene file names.
    fn files_of_scene(&self) -> Vec<PathBuf> {
        self.work.scene.source.as_ref().map_or_else(Vec::new, |source| source.report.files.clone())
    }

    /// Reloads a file of the document, wherever it is used.
    pub(super) fn file_changed(&mut self, path: PathBuf) {
        let document = &self.work.document;
        let is_brdf = brdf_files(document).any(|file| file.path == path);
        if !is_brdf && path.extension().is_some_and(|e| e == "wgsl") {
            self.picture.render.reload();
            return;
        }
        self.picture.backplate.reload(&path, &self.work);
        let document = &self.work.document;
        if document.environment.file().is_some_and(|map| file_and_layer(map).0 == path) {
            self.environments.reload(&path);
        }
        let is_of_scene = document.scene.as_ref() == Some(&path) || self.files_of_scene().contains(&path);
        if is_brdf {
            self.loader.load(Topic::Reload(path.clone()), Source::Brdf(path));
        } else if !self.reload_pictures(&path)
            && let Some(path) = self.work.document.scene.clone().filter(|_| is_of_scene)
        {
            let allow_outside = self.work.preferences.outside.allow(&path);
            let options =
                ImportOptions { allow_outside, scene: self.work.document.scene_in_file.clone(), ..Default::default() };
            self.loader.load(Topic::Reload(path.clone()), Source::Scene { path, options });
        }
    }

    /// Reloads the textures of a file, each with its layer. Returns whether there are any.
    fn reload_pictures(&mut self, file: &Path) -> bool {
        let document = &self.work.document;
        let named = document.textures.iter().filter_map(|entry| document.file_of(entry));
        let named: BTreeSet<PathBuf> = named.filter(|path| file_and_layer(path).0 == file).collect();
        let may_be_read = |path: &PathBuf| may_be_read(path, document, &self.work.preferences.outside);
        let has_any = !named.is_empty();
        for path in named.into_iter().filter(may_be_read) {
            self.loader.load(Topic::Reload(path.clone()), Source::Texture(path));
        }
        has_any
    }

    /// Takes a reloaded file. If reading failed, the earlier contents stay.
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
                self.work.messages.note(format!("Reloaded ({})", path.display()));
            }
            Ok(Loaded::Brdf { content, remarks }) => {
                remarks.into_iter().for_each(|remark| self.work.messages.warning(remark));
                let mut reload = |material: &mut Material| {
                    let file = material.file.as_mut().filter(|file| file.path == path);
                    file.into_iter().for_each(|file| file.content = Some(content.clone()));
                };
                self.work.document.materials_and_those_of_looks().for_each(|(_, material)| reload(material));
                self.work.history.visit_materials(&mut reload);
                self.work.messages.note(format!("Reloaded ({})", path.display()));
            }
            Ok(Loaded::Scene(source)) => self.work.scene_changed(path, *source),
            // Other files are not loaded on this topic.
            Ok(_) => {}
            Err(error) => self.work.messages.warning(format!("Cannot reload a changed file: {error}")),
        }
    }
}

type LoadedEnvironment = (Arc<lapidary_core::environment::Environment>, Vec<String>);

fn into_environment(loaded: Loaded) -> Result<LoadedEnvironment, String> {
    match loaded {
        Loaded::Environment { environment, warnings } => Ok((environment, warnings)),
        _ => Err("not an environment".into()),
    }
}

/// Whether a picture was chosen by the user, lies in the scene's folder, or is allowed outside it.
fn may_be_read(picture: &Path, document: &Document, allowed: &AllowedFolders) -> bool {
    let is_chosen = document.textures.iter().any(|entry| entry.file.as_deref() == Some(picture));
    let of_scene =
        |scene: &Path| input::is_inside(&folder_of(scene), file_and_layer(picture).0) || allowed.allow(scene);
    is_chosen || document.scene.as_deref().is_some_and(of_scene)
}

/// Uses a picture for the base color of a material.
pub fn as_base_color(material: usize, path: PathBuf) -> Action {
    Action::Material(MaterialAction::LoadTexture { material, map: "base_color", path: Some(path) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        document::looks::{LookState, NamedLook},
        test_support::document_with_a_map as document,
    };

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
    fn only_files_in_use_are_watched() {
        let embedded = document(None);
        assert!(files_in_use(&embedded).is_empty(), "the default light is a formula");
        let beside = Document { scene: Some("/b/scene.gltf".into()), ..embedded };
        let mut expected = [Path::new("/b").join(&beside.textures[0].texture.name), "/b/scene.gltf".into()];
        expected.sort();
        assert_eq!(files_in_use(&beside), expected);
        let mut document = document(Some("/a/wood.png".into()));
        document.environment.spec = "/a/sky.hdr".into();
        assert_eq!(files_in_use(&document), [PathBuf::from("/a/sky.hdr"), "/a/wood.png".into()]);
        let look = NamedLook { name: "Day".into(), state: LookState::of(&document) };
        document.materials[0].maps.set("base_color", None);
        assert_eq!(files_in_use(&document), [PathBuf::from("/a/sky.hdr")]);
        document.environment.spec = "studio".into();
        document.looks = vec![look];
        assert_eq!(files_in_use(&document), [PathBuf::from("/a/sky.hdr"), "/a/wood.png".into()], "of a look alone");
    }
}
