//! Environment maps: the one that lights the scene, and small pictures of those in the library.

use super::state::EditorState;
use crate::{
    jobs::{
        Wake,
        load::{Source, Topic},
        thumbnails::Thumbnails,
    },
    panels::environment::thumbnail,
};
use egui::{Context, TextureHandle, TextureOptions};
use lapidary_core::environment::Environment;
use std::{collections::HashMap, sync::Arc};

/// Width and height of the library's pictures in pixels.
const THUMBNAIL: [usize; 2] = [160, 80];

/// The map in use, and pictures of others.
pub struct Environments {
    loaded: Option<Arc<Environment>>,
    /// The specification that was last asked for.
    asked: Option<String>,
    /// Why the map that the document names is not in use.
    pub problem: Option<String>,
    thumbnails: Thumbnails,
    pictures: HashMap<String, Option<TextureHandle>>,
}

impl Environments {
    /// With none loaded.
    pub fn new(wake: Wake) -> Self {
        let make = |spec: &str| Ok(thumbnail(&Environment::from_spec(spec)?.0, THUMBNAIL));
        let thumbnails = Thumbnails::start(make, wake);
        Self { loaded: None, asked: None, problem: None, thumbnails, pictures: HashMap::new() }
    }

    /// The map that lights the scene.
    pub fn loaded(&self) -> Option<&Arc<Environment>> {
        self.loaded.as_ref()
    }

    /// A small picture of a map, once it is made.
    pub fn picture(&mut self, spec: &str) -> Option<&TextureHandle> {
        self.thumbnails.request(spec);
        self.pictures.get(spec)?.as_ref()
    }

    /// Takes the pictures that were made.
    pub fn collect(&mut self, ctx: &Context) {
        for (spec, picture) in self.thumbnails.ready() {
            // A map that cannot be read is told about when it is chosen.
            let texture = picture.ok().map(|image| ctx.load_texture(&spec, image, TextureOptions::LINEAR));
            self.pictures.insert(spec, texture);
        }
    }

    /// The file of a map has changed.
    pub fn forget_picture(&mut self, spec: &str) {
        self.thumbnails.forget(spec);
    }
}

impl EditorState {
    /// Loads the map that the document names, unless that was tried already.
    pub(super) fn load_environment(&mut self) {
        let spec = &self.document.environment.spec;
        if self.environments.asked.as_ref() != Some(spec) {
            self.environments.asked = Some(spec.clone());
            self.loader.load(Topic::Environment, Source::Environment(spec.clone()));
        }
    }

    /// A map is there, or cannot be: then the one before stays in use.
    pub(super) fn environment_loaded(&mut self, result: Result<(Arc<Environment>, Vec<String>), String>) {
        match result {
            Ok((environment, warnings)) => {
                self.messages.warnings("Environment", &warnings);
                self.environments.problem = None;
                self.environments.loaded = Some(environment);
            }
            Err(error) => {
                self.messages.error(&error);
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
