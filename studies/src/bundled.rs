//! The bundled scenes and environments.

use crate::terminal::Console;
use anyhow::{Result, bail};
use lapidary_core::{environment::Environment, texture::ColorSpace};
use lapidary_interchange::environment;
use std::{
    iter,
    path::{Path, PathBuf},
};

/// Their place in the source tree.
const IN_SOURCE_TREE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../data");

/// Names of the environments' files, without extension.
const ENVIRONMENTS: [&str; 3] = ["studio", "sun-and-sky", "window-room"];

/// The folder of bundled data.
pub struct DataFolder(PathBuf);

impl DataFolder {
    /// The given folder, or the source tree's.
    ///
    /// # Errors
    /// A folder without the still life.
    pub fn find(given: Option<&Path>) -> Result<Self> {
        let folder = Self(given.unwrap_or(Path::new(IN_SOURCE_TREE)).to_owned());
        if !folder.still_life().is_file() {
            bail!(
                "the bundled data are missing; give their folder with --data or the variable LAPIDARY_DATA ({})",
                folder.0.display()
            );
        }
        Ok(folder)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Path of a scene, by its folder's name.
    pub fn scene(&self, name: &str) -> PathBuf {
        self.0.join(name).join(name).with_extension("gltf")
    }

    /// Path of the still life.
    pub fn still_life(&self) -> PathBuf {
        self.scene("still-life")
    }

    /// Scenes offered by the window, the still life first.
    pub fn scenes(&self) -> Vec<PathBuf> {
        let others = ["interior", "color-box", "material-study", "bending-tower"].map(|name| self.scene(name));
        iter::once(self.still_life()).chain(others).filter(|scene| scene.is_file()).collect()
    }

    /// Folder of the environments.
    pub fn environment_folder(&self) -> PathBuf {
        self.0.join("environments")
    }

    /// All environments.
    ///
    /// # Errors
    /// An unreadable environment.
    pub fn environments(&self, console: Console) -> Result<Environments> {
        Ok(Environments(ENVIRONMENTS.iter().map(|name| self.environment(name, console)).collect::<Result<_>>()?))
    }

    /// An environment by its file name.
    ///
    /// # Errors
    /// An unreadable file.
    pub fn environment(&self, name: &str, console: Console) -> Result<Environment> {
        let (environment, warnings) =
            environment::read(&self.environment_folder().join(name).with_extension("hdr"), ColorSpace::Srgb)?;
        warnings.iter().for_each(|w| console.warning(w));
        Ok(Environment::new(name.into(), environment.map))
    }
}

/// The environments by name.
pub struct Environments(Vec<Environment>);

impl Environments {
    /// Names of all environments.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|e| e.name.as_str())
    }

    /// An environment by name.
    pub fn get(&self, name: &str) -> &Environment {
        self.0.iter().find(|e| e.name == name).expect("pictures are planned with bundled environments")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_source_tree_has_the_data_and_another_folder_is_refused() {
        let scenes = DataFolder::find(None).unwrap().scenes();
        assert!(scenes.len() == 5 && scenes[0].ends_with("still-life.gltf"), "{scenes:?}");
        let error = DataFolder::find(Some(Path::new("nowhere"))).err().map(|e| e.to_string());
        assert!(error.is_some_and(|e| e.contains("--data") && e.ends_with("(nowhere)")));
    }
}
