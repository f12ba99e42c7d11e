//! Loading the environment map that the document names.

use super::state::EditorState;
use crate::jobs::load::{Source, Topic};
use lapidary_core::environment::Environment;
use std::sync::Arc;

impl EditorState {
    /// Loads the map that the document names, unless that was tried already.
    pub(super) fn load_environment(&mut self) {
        let spec = &self.work.document.environment.spec;
        if self.environments.asked.as_ref() != Some(spec) {
            self.environments.asked = Some(spec.clone());
            self.loader.load(Topic::Environment, Source::Environment(spec.clone()));
        }
    }

    /// A map is there, or cannot be: then the one before stays in use.
    pub(super) fn environment_loaded(&mut self, result: Result<(Arc<Environment>, Vec<String>), String>) {
        match result {
            Ok((environment, warnings)) => {
                self.work.messages.warnings("Environment", &warnings);
                self.environments.problem = None;
                self.environments.loaded = Some(environment);
            }
            Err(error) => {
                self.work.messages.error(&error);
                self.environments.problem = Some(error);
                if self.environments.loaded.is_none() {
                    self.fall_back_to_studio();
                }
            }
        }
    }

    /// Something must light the scene; the studio is made by a formula and needs no file.
    fn fall_back_to_studio(&mut self) {
        if let Ok((studio, _)) = Environment::from_spec("studio") {
            self.environments.loaded = Some(studio.into());
        }
    }
}
