//! Loads environment maps, chooses them, adds them to the library and searches for missing ones.

use super::state::Environments;
use crate::{
    actions::EnvironmentAction,
    document::{Edit, EnvironmentSettings, library::maps_in},
    jobs::load::{Loader, Source, Topic},
    workspace::Workspace,
};
use lapidary_core::environment::Environment;
use lapidary_interchange::{environment, image::file_and_layer};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

impl Environments {
    /// Performs an action.
    pub fn perform(&mut self, work: &mut Workspace, action: EnvironmentAction) {
        match action {
            EnvironmentAction::Load(Some(path)) => use_environment(work, &path.to_string_lossy()),
            EnvironmentAction::AddToLibrary(Some(path)) => self.add_to_library(work, path),
            // The path is asked for first.
            EnvironmentAction::Load(None) | EnvironmentAction::AddToLibrary(None) => {}
        }
    }

    /// Loads the document's map, unless that was tried already.
    pub fn load(&mut self, work: &Workspace, loader: &mut Loader) {
        let EnvironmentSettings { spec, color_space, .. } = work.document.environment.clone();
        if self.asked.as_ref() != Some(&(spec.clone(), color_space)) {
            self.reloads = self.reloads && self.asked.is_none();
            self.asked = Some((spec.clone(), color_space));
            loader.load(Topic::Environment, Source::Environment { spec, color_space });
        }
    }

    /// Loads the document's map again, whose file changed.
    pub fn reload(&mut self, file: &Path) {
        self.thumbnails.forget(|spec| file_and_layer(Path::new(spec)).0 == file);
        (self.asked, self.reloads) = (None, true);
    }

    /// Takes a loaded map. After a failure the previous map stays in use.
    pub fn take_loaded(&mut self, work: &mut Workspace, result: Result<(Arc<Environment>, Vec<String>), String>) {
        let reloads = std::mem::take(&mut self.reloads);
        match result {
            Ok((environment, warnings)) => {
                work.messages.warnings("Environment", &warnings);
                self.problem = None;
                self.loaded = Some(environment);
                if reloads {
                    work.messages.note(format!("Reloaded ({})", work.document.environment.spec));
                }
            }
            Err(error) if reloads && self.problem.is_none() && self.loaded.is_some() => {
                work.messages.warning(format!("Cannot reload a changed file: {error}"));
            }
            Err(error) => {
                work.messages.error(&error);
                self.problem = Some(error);
                if self.loaded.is_none() {
                    self.fall_back_to_studio();
                }
            }
        }
    }

    /// Falls back to the studio, a formula that needs no file, so that something lights the scene.
    fn fall_back_to_studio(&mut self) {
        if let Ok((studio, _)) = environment::from_spec("studio") {
            self.loaded = Some(studio.into());
        }
    }

    fn add_to_library(&mut self, work: &mut Workspace, path: PathBuf) {
        match self.library.add(&[path]) {
            Ok(0) => work.messages.note("Already in the library"),
            Ok(count) => work.messages.note(format!("Added to the library: {count}")),
            Err(error) => work.messages.error(format!("{error:#}")),
        }
    }

    /// Searches for missing maps of the library.
    pub fn relink_library(&mut self, work: &mut Workspace, folder: &Path) {
        let maps = maps_in(folder);
        let mut found = 0;
        for entry in self.library.entries().into_iter().filter(|entry| entry.missing && !entry.bundled) {
            let Some(map) = maps.iter().find(|map| map.file_name() == entry.path.file_name()) else { continue };
            let moved = self.library.remove(&entry.path).and_then(|()| self.library.add(std::slice::from_ref(map)));
            match moved {
                Ok(_) => found += 1,
                Err(error) => work.messages.error(format!("{error:#}")),
            }
        }
        work.messages.note(format!("Found {found} of the missing maps ({})", folder.display()));
    }
}

/// Lights the scene with a map or formula, as a step of undo.
fn use_environment(work: &mut Workspace, spec: &str) {
    let environment = work.document.environment.with_map(spec);
    work.do_step(Edit::Environment(environment), "Environment");
}
