//! Opens a file completely: scene, dataset, session and the files that they name. A thread reads them until the
//! document is complete. Files outside the folder of a scene are read only with the user's consent.

mod reader;

use crate::{
    document::{
        Document,
        autosave::Recovery,
        session::{LoadedSession, Unknown},
    },
    jobs::{
        Imported,
        load::{Kind, foreign},
    },
    preferences::AllowedFolders,
};
use anyhow::Result;
use lapidary_core::{
    animation::{Animation, BoundAnimation},
    scene::Scene,
};
use lapidary_interchange::{
    animation,
    import::{ImportError, ImportOptions},
};
use lapidary_render::Baked;
use lapidary_studies::jobs::{Wake, guarded, spawn};
use reader::Reader;
use std::{
    cell::RefCell,
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{Receiver, TryRecvError, channel},
    },
};

/// The source to open.
#[derive(Clone, Debug)]
pub enum Target {
    /// A scene, a dataset or a session.
    File(PathBuf),
    /// A scene of a file with several, by name or number.
    SceneIn {
        /// The file.
        path: PathBuf,
        /// The scene.
        scene: String,
    },
    /// A bundled scene; nothing is written beside it.
    Bundled(PathBuf),
    /// The autosave of a process that did not exit cleanly.
    Recovered(Recovery),
    /// A session with missing files.
    Session {
        /// As it was read.
        loaded: Box<LoadedSession>,
        /// Its file; `None` for recovered work without one.
        path: Option<PathBuf>,
        /// The autosave that it was read from, the only copy.
        recovery: Option<Recovery>,
        /// The folder to search; `None` to open it without the files.
        look_in: Option<PathBuf>,
    },
}

/// Result of opening.
pub enum Opened {
    /// A document to edit.
    Ready(Box<Ready>),
    /// Files of a session are missing; the user decides.
    Missing {
        /// The session.
        loaded: Box<LoadedSession>,
        /// Its file.
        path: Option<PathBuf>,
        /// The autosave it was read from, which nothing else keeps.
        recovery: Option<Recovery>,
        /// Number of files found, if searched.
        found: Option<usize>,
    },
    /// The scene names files outside its folder; the user decides.
    Outside {
        /// The requested target.
        target: Box<Target>,
        /// The scene.
        scene: PathBuf,
        /// The files, as it names them.
        names: Vec<String>,
    },
}

/// Whether scenes may read files outside their folders, and the scenes for which the user must be asked.
#[derive(Debug, Default)]
pub struct Consent {
    allowed: AllowedFolders,
    /// Refuse without asking the user.
    is_refused: bool,
    /// The scene and the files that it names.
    unknown: RefCell<Option<(PathBuf, Vec<String>)>>,
}

impl From<AllowedFolders> for Consent {
    fn from(allowed: AllowedFolders) -> Self {
        Self { allowed, ..Self::default() }
    }
}

impl Consent {
    /// Refuses outside files without asking the user.
    pub fn refused() -> Self {
        Self { is_refused: true, ..Self::default() }
    }

    /// Imports a scene of a file, or its default, with the files that it may read.
    fn import(&self, path: &Path, scene: Option<&str>) -> Result<Imported, ImportError> {
        let allowed = !self.is_refused && self.allowed.allow(path);
        let options = ImportOptions { allow_outside: allowed, scene: scene.map(Into::into), ..Default::default() };
        let imported = Imported::read(path, &options);
        let outside = match &imported {
            Ok(source) => source.report.outside.clone(),
            Err(ImportError::Outside { names, .. }) => names.clone(),
            Err(_) => Vec::new(),
        };
        if !allowed && !self.is_refused && !outside.is_empty() {
            self.unknown.replace(Some((path.into(), outside)));
        }
        imported
    }
}

/// A document with its scene and files.
pub struct Ready {
    /// The document.
    pub document: Document,
    /// Keys of the session file that this version does not know.
    pub unknown: Unknown,
    /// The session file.
    pub session: Option<PathBuf>,
    /// The autosave it was read from, which nothing else keeps.
    pub recovery: Option<Recovery>,
    /// The dataset, which can be rendered.
    pub baked: Option<Baked>,
    /// The scene without shadows, to be rendered until there is a dataset.
    pub preview: Option<Baked>,
    /// The scene, which can be baked.
    pub source: Option<Imported>,
    /// The animation of a scene that cannot be baked, from the file beside its dataset.
    pub animation: Option<Arc<Animation>>,
    /// Output of a bake that the user asks for.
    pub bake_output: Option<PathBuf>,
    /// Output of an automatic bake.
    pub kept_output: Option<PathBuf>,
    /// Whether there is no bake, or only a draft of one.
    pub lacks_bake: bool,
    /// Whether the dataset is a draft.
    pub is_draft: bool,
    /// Repairs and omissions.
    pub warnings: Vec<String>,
    /// The file to list among the recent ones.
    pub recent: Option<PathBuf>,
}

/// A thread that opens something. Dropping it drops the result.
pub struct Opening {
    /// Displayed name.
    pub what: String,
    result: Receiver<Result<Opened, String>>,
}

impl Opening {
    /// Begins to open a target. Automatic bakes are in the folder `bakes`.
    pub fn start(target: Target, bakes: PathBuf, consent: Consent, wake: Wake) -> Self {
        let (sender, result) = channel();
        let what = name(&target);
        spawn("open", move || {
            // Fails only if the window opened something else meanwhile.
            let _ = sender.send(guarded("opening the file", || open(target, &bakes, &consent)));
            wake();
        });
        Self { what, result }
    }

    /// The result, once it is ready.
    pub fn poll(&self) -> Option<Result<Opened, String>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err("opening stopped; try again".into())),
        }
    }
}

fn name(target: &Target) -> String {
    let of = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    match target {
        Target::File(path) | Target::SceneIn { path, .. } => of(path),
        Target::Bundled(scene) => of(scene),
        Target::Recovered(_) => "recovered work".into(),
        Target::Session { path, .. } => path.as_deref().map_or("the session".into(), of),
    }
}

/// Reads all files of the target, and its bakes kept in the folder `bakes`.
///
/// # Errors
/// A file that cannot be read, in words for the user.
pub fn open(target: Target, bakes: &Path, consent: &Consent) -> Result<Opened> {
    let opened = reader::read(target.clone(), &Reader { bakes, consent });
    match consent.unknown.take() {
        Some((scene, names)) => Ok(Opened::Outside { target: target.into(), scene, names }),
        None => opened,
    }
}

/// The bake of a scene of a file, as the window names it.
pub fn bake_beside(path: &Path, scene_in_file: Option<&str>) -> PathBuf {
    // Codes keep names apart that differ in other characters alone.
    let plain = |c: char| match c.is_alphanumeric() || "-_ ".contains(c) {
        true => c.to_string(),
        false => format!("%{:x}", u32::from(c)),
    };
    match scene_in_file {
        None => path.with_extension("cuts"),
        Some(scene) => path.with_extension(format!("{}.cuts", scene.chars().map(plain).collect::<String>())),
    }
}

/// Why a file that is no document cannot be opened, and where to use it.
fn no_document(path: &Path, kind: Kind) -> String {
    let what = match kind {
        Kind::Environment => "this is an environment, not a scene; use Library > Load..., or drop it on the window",
        Kind::Texture => "this is a picture, not a scene; load it as a map of a material, or drop it on an object",
        Kind::Material => "this is a material, not a scene; use Load... in the Material tab, or drop it on an object",
        Kind::Brdf => {
            "this is a BRDF, not a scene; use Load... under the model in the Material tab, or drop it on an object"
        }
        Kind::Lights => "these are lights, not a scene; use Load... in the Lights tab, or drop them on the window",
        Kind::Scene | Kind::Dataset | Kind::Session | Kind::Unknown => return foreign(path),
    };
    format!("{what} ({})", path.display())
}

/// The animation of the glTF file beside a dataset that has its name, as the window and most users name it. Files that are
/// unreadable or do not fit are skipped: the dataset does not claim them.
fn animation_beside(dataset: &Path, scene: &Scene) -> Option<Arc<Animation>> {
    let mut files = animation::endings().into_iter().map(|ending| dataset.with_extension(ending));
    let file = files.find(|file| file.is_file())?;
    let animation = Arc::new(animation::read(&file, &ImportOptions::default()).ok()?);
    BoundAnimation::new(animation.clone(), scene).is_ok().then_some(animation)
}

impl Ready {
    fn new(document: Document, baked: Option<Baked>, source: Option<Imported>, warnings: Vec<String>) -> Self {
        let alone = baked.as_ref().zip(document.dataset.as_deref()).filter(|_| source.is_none());
        let animation = alone.and_then(|(baked, dataset)| animation_beside(dataset, &baked.dataset.scene));
        Self {
            animation,
            document,
            unknown: Unknown::default(),
            session: None,
            recovery: None,
            baked,
            preview: None,
            source,
            bake_output: None,
            kept_output: None,
            lacks_bake: false,
            is_draft: false,
            warnings,
            recent: None,
        }
    }
}
