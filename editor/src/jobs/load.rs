//! Opens files on threads of their own. The latest request on a [`Topic`] wins: results of earlier ones are dropped.

mod kind;

pub use kind::{Kind, foreign, kind_of};

use super::Imported;
use lapidary_core::{
    brdf::Content,
    environment::Environment,
    material::Material,
    scene::Scene,
    texture::{ColorSpace, Texture},
};
use lapidary_interchange::{
    environment, image,
    import::{ImportError, ImportOptions, load_material, materials_in_file},
};
use lapidary_studies::jobs::{Wake, guarded, spawn};
use std::{
    collections::HashMap,
    path::PathBuf,
    sync::{
        Arc,
        mpsc::{Receiver, Sender, channel},
    },
};

/// The purpose of a load. Of two with the same purpose only the later counts.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Topic {
    /// The environment.
    Environment,
    /// A map of a material.
    Map {
        /// Which material.
        material: usize,
        /// Which map.
        map: &'static str,
    },
    /// The BRDF of a material.
    Brdf(usize),
    /// A whole material.
    Material(usize),
    /// A file that has changed on disk.
    Reload(PathBuf),
}

/// The source to open.
#[derive(Clone, Debug)]
pub enum Source {
    /// A map or formula, as [`environment::from_spec_in`] reads it.
    Environment {
        /// A path or formula.
        spec: String,
        /// Color space of a file.
        color_space: ColorSpace,
    },
    /// A scene file that has changed.
    Scene {
        /// Which.
        path: PathBuf,
        /// Which of its scenes, and whether it may name files outside its folder.
        options: ImportOptions,
    },
    /// A picture for a map.
    Texture(PathBuf),
    /// The file of a BRDF.
    Brdf(PathBuf),
    /// A material file.
    Material {
        /// Which.
        path: PathBuf,
        /// The document's textures; pictures among them are not loaded again.
        textures: Vec<Arc<Texture>>,
        /// Whether it may name files outside its folder.
        allow_outside: bool,
    },
}

impl Source {
    fn path(&self) -> Option<PathBuf> {
        match self {
            Self::Environment { .. } => None,
            Self::Scene { path, .. } | Self::Texture(path) | Self::Brdf(path) | Self::Material { path, .. } => {
                Some(path.clone())
            }
        }
    }
}

/// The opened file.
#[derive(Clone, Debug)]
pub enum Loaded {
    /// An environment.
    Environment {
        /// The map.
        environment: Arc<Environment>,
        /// Repairs, in sentences.
        warnings: Vec<String>,
    },
    /// A scene.
    Scene(Box<Imported>),
    /// A picture.
    Texture(Arc<Texture>),
    /// The contents of a BRDF's file.
    Brdf {
        /// The contents.
        content: Content,
        /// Remarks for the user, in sentences.
        remarks: Vec<String>,
    },
    /// A material that refers to `textures`.
    Material {
        /// The material.
        material: Box<Material>,
        /// The given textures, followed by those that the material added.
        textures: Vec<Arc<Texture>>,
        /// Number of given textures.
        given: usize,
        /// Repairs, in sentences.
        warnings: Vec<String>,
    },
    /// The names of several materials of a file: the user chooses.
    Several(Vec<String>),
    /// A material that needs pictures outside its folder: the user decides.
    Outside(Vec<String>),
}

/// A load that has ended.
#[derive(Clone, Debug)]
pub struct LoadResult {
    id: u64,
    /// The file; `None` for formulas.
    pub path: Option<PathBuf>,
    /// Its purpose.
    pub topic: Topic,
    /// The opened file, or the error.
    pub result: Result<Loaded, String>,
}

/// Opens files.
pub struct Loader {
    wake: Wake,
    sender: Sender<LoadResult>,
    results: Receiver<LoadResult>,
    /// The load that counts, for each topic that waits for one.
    latest: HashMap<Topic, u64>,
    loads: u64,
}

impl Loader {
    /// A loader with nothing to do.
    pub fn new(wake: Wake) -> Self {
        let (sender, results) = channel();
        Self { wake, sender, results, latest: HashMap::new(), loads: 0 }
    }

    /// Begins to open a source. An earlier load on the same topic no longer counts.
    pub fn load(&mut self, topic: Topic, source: Source) {
        self.loads += 1;
        let id = self.loads;
        self.latest.insert(topic.clone(), id);
        let (sender, wake) = (self.sender.clone(), self.wake.clone());
        spawn("load", move || {
            let path = source.path();
            let result = guarded("opening the file", || open(source));
            // Fails only if the window is gone.
            let _ = sender.send(LoadResult { id, path, topic, result });
            wake();
        });
    }

    /// Whether all requests have been opened.
    #[cfg(test)]
    pub fn is_idle(&self) -> bool {
        self.latest.is_empty()
    }

    /// Drops running loads, except the environment's, since another document was opened.
    pub fn forget_document(&mut self) {
        self.latest.retain(|topic, _| *topic == Topic::Environment);
    }

    /// Loads that have ended since the last call and still count.
    pub fn results(&mut self) -> Vec<LoadResult> {
        let latest = &mut self.latest;
        let counts = |ended: &LoadResult| {
            let is_latest = latest.get(&ended.topic) == Some(&ended.id);
            if is_latest {
                latest.remove(&ended.topic);
            }
            is_latest
        };
        self.results.try_iter().filter(counts).collect()
    }
}

fn open(source: Source) -> anyhow::Result<Loaded> {
    Ok(match source {
        Source::Environment { spec, color_space } => {
            let (environment, warnings) = environment::from_spec_in(&spec, color_space)?;
            Loaded::Environment { environment: environment.into(), warnings }
        }
        Source::Scene { path, options } => Loaded::Scene(Imported::read(&path, &options)?.into()),
        Source::Texture(path) => Loaded::Texture(image::read_texture(&path)?.into()),
        Source::Brdf(path) => {
            let (content, remarks) = Content::read(&path)?;
            Loaded::Brdf { content, remarks }
        }
        Source::Material { path, textures, allow_outside } => {
            let names = materials_in_file(&path);
            if names.len() > 1 {
                return Ok(Loaded::Several(names));
            }
            let given = textures.len();
            let mut scene = Scene { textures, ..Default::default() };
            match load_material(&path, &mut scene, &ImportOptions { allow_outside, ..Default::default() }) {
                Err(ImportError::Outside { names, .. }) => Loaded::Outside(names),
                loaded => {
                    let (material, warnings) = loaded?;
                    Loaded::Material { material: material.into(), textures: scene.textures, given, warnings }
                }
            }
        }
    })
}

#[cfg(test)]
mod tests;
