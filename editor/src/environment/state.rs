//! Environment maps: the one that lights the scene, and thumbnails of the library.

use super::panel::EnvironmentPanel;
use crate::{document::library::EnvironmentLibrary, environment::panel::thumbnail, jobs::thumbnails::Thumbnails};
use egui::{Context, TextureHandle, TextureOptions};
use lapidary_core::{environment::Environment, texture::ColorSpace};
use lapidary_interchange::environment;
use lapidary_studies::jobs::Wake;
use std::{collections::HashMap, sync::Arc};

/// Width and height of the library's pictures in pixels.
const THUMBNAIL: [usize; 2] = [160, 80];

/// The map in use, and thumbnails of others.
pub struct Environments {
    /// State of the panel between frames.
    pub panel: EnvironmentPanel,
    /// Maps to choose from.
    pub library: EnvironmentLibrary,
    pub loaded: Option<Arc<Environment>>,
    /// The specification requested last, and the color space of its file.
    pub asked: Option<(String, ColorSpace)>,
    /// Whether what was requested last is in use, and its file changed.
    pub reloads: bool,
    /// Why the document's map is not in use.
    pub problem: Option<String>,
    pub thumbnails: Thumbnails,
    pub pictures: HashMap<String, Option<TextureHandle>>,
}

impl Environments {
    /// With none loaded.
    pub fn new(library: EnvironmentLibrary, wake: Wake) -> Self {
        let make = |spec: &str| Ok(thumbnail(&environment::from_spec(spec)?.0, THUMBNAIL));
        let thumbnails = Thumbnails::start(make, wake);
        let panel = EnvironmentPanel::default();
        Self {
            panel,
            library,
            loaded: None,
            asked: None,
            reloads: false,
            problem: None,
            thumbnails,
            pictures: HashMap::new(),
        }
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

    /// Takes finished thumbnails.
    pub fn collect(&mut self, ctx: &Context) {
        for (spec, picture) in self.thumbnails.ready() {
            // Choosing an unreadable map reports the error.
            let texture = picture.ok().map(|image| ctx.load_texture(&spec, image, TextureOptions::LINEAR));
            self.pictures.insert(spec, texture);
        }
    }
}
