//! Pictures of documents, made away from the window.

use crate::{
    document::{BackgroundKind, Document, EnvironmentSettings, looks::LookState},
    look::look_of,
};
use anyhow::Result;
use lapidary_core::{environment::Environment, names::told_apart, scene::pose::Poses, texture::ColorSpace};
use lapidary_interchange::environment;
use lapidary_render::{Baked, Look};
use lapidary_studies::export::backplate;
use std::sync::Arc;

/// All that a picture of a document needs.
#[derive(Clone)]
pub struct PictureOfDocument {
    /// The document.
    pub document: Document,
    /// Its bake.
    pub baked: Baked,
    /// Its poses, relative to the bake.
    pub poses: Poses,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel; `None` for the document's.
    pub aa: Option<u32>,
}

/// The environment map read last, with where it came from: looks often share one.
#[derive(Default)]
pub struct Maps(Option<((String, ColorSpace), Arc<Environment>)>);

impl Maps {
    /// The map of a document.
    ///
    /// # Errors
    /// A file that cannot be read.
    fn of(&mut self, settings: &EnvironmentSettings) -> Result<Arc<Environment>> {
        let key = (settings.spec.clone(), settings.color_space);
        if let Some((_, known)) = self.0.as_ref().filter(|(known, _)| *known == key) {
            return Ok(known.clone());
        }
        let (map, _) = environment::from_spec_in(&key.0, key.1)?;
        let map = Arc::new(map);
        self.0 = Some((key, map.clone()));
        Ok(map)
    }
}

/// Names of files for looks, which differ in more than upper and lower case: some systems take no notice of that.
pub fn file_names<'a>(looks: impl Iterator<Item = &'a String>) -> Vec<String> {
    let plain: Vec<String> = looks.map(|look| file_name(look)).collect();
    let apart = told_apart(plain.iter().map(|name| name.to_lowercase()).collect());
    let numbered = |(name, apart): (&String, &String)| format!("{name}{}", &apart[name.to_lowercase().len()..]);
    plain.iter().zip(&apart).map(numbered).collect()
}

/// The name of a look in names of files.
fn file_name(look: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_. ".contains(c) { c } else { '-' };
    look.chars().map(plain).collect()
}

impl PictureOfDocument {
    /// With a look in place.
    #[must_use]
    pub fn with_look(mut self, look: &LookState) -> Self {
        look.clone().swap(&mut self.document);
        self
    }

    /// What renderers show. Reads the environment map.
    ///
    /// # Errors
    /// A map that cannot be read.
    pub fn look(&self, maps: &mut Maps) -> Result<Look> {
        let Self { document, baked, poses, size, aa } = self;
        let environment = maps.of(&document.environment)?;
        let assigned = document.assigned_to(&baked.dataset.scene.mesh);
        let mut look = look_of(document, Some(baked), environment, (assigned, poses.clone()), *size);
        look.view.aa = aa.unwrap_or(look.view.aa);
        let is_shown = document.view.background == BackgroundKind::Picture;
        if let Some(path) = document.view.backplate.as_ref().filter(|_| is_shown) {
            look.backplate = Some(Arc::new(backplate::read(path)?));
        }
        Ok(look)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_looks_are_told_apart_on_every_system() {
        let names = ["Day", "day", "Red/1", "Red-1"].map(String::from);
        assert_eq!(file_names(names.iter()), ["Day", "day 2", "Red-1", "Red-1 2"]);
    }
}
