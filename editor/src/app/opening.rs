//! Opening a file, whole: scene, dataset, session and what they name, read on a thread until the document is complete.

use crate::{
    document::{
        Document, TextureEntry,
        autosave::Recovery,
        session::{self, LoadedSession, Unknown},
    },
    jobs::{
        Baked, Wake, guarded,
        load::{Kind, foreign, kind_of},
        spawn,
    },
};
use anyhow::Result;
use lapidary_core::{
    dataset::{Dataset, scene_hash},
    import::{ImportReport, import},
    scene::Scene,
};
use lapidary_precompute::Preset;
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        mpsc::{Receiver, TryRecvError, channel},
    },
    time::Instant,
};

/// What to open.
#[derive(Clone, Debug)]
pub enum Target {
    /// A scene, a dataset or a session.
    File(PathBuf),
    /// The scene that comes with the program; its bakes are kept in a folder.
    Bundled {
        /// The scene.
        scene: PathBuf,
        /// Where its bakes are.
        bakes: PathBuf,
    },
    /// What a process that ended too early left.
    Recovered(Recovery),
    /// A session whose missing files were looked for.
    Session {
        /// As it was read.
        loaded: Box<LoadedSession>,
        /// Its file; `None` for recovered work without one.
        path: Option<PathBuf>,
        /// Whether no file has its changes.
        unsaved: bool,
    },
}

/// What opening came to.
pub enum Opened {
    /// A document to edit.
    Ready(Box<Ready>),
    /// Files of a session are not there; the user decides.
    Missing {
        /// The session.
        loaded: Box<LoadedSession>,
        /// Its file.
        path: Option<PathBuf>,
        /// Whether no file has its changes.
        unsaved: bool,
    },
}

/// A document and what belongs to it.
pub struct Ready {
    /// What is edited.
    pub document: Document,
    /// What the session file has that this version does not know.
    pub unknown: Unknown,
    /// The session file.
    pub session: Option<PathBuf>,
    /// Whether no file has its changes.
    pub unsaved: bool,
    /// What can be rendered.
    pub baked: Option<Baked>,
    /// What can be baked.
    pub source: Option<Source>,
    /// Where a bake goes.
    pub bake_output: Option<PathBuf>,
    /// Whether to bake without being asked: the bundled scene for the first time.
    pub bake_now: bool,
    /// What was repaired or left out.
    pub warnings: Vec<String>,
    /// The file to list among the recent ones.
    pub recent: Option<PathBuf>,
}

/// An imported scene.
#[derive(Clone)]
pub struct Source {
    /// As imported.
    pub scene: Arc<Scene>,
    /// Tells whether a dataset was baked from it.
    pub hash: String,
    /// Seconds that the import took.
    pub import_secs: f64,
    /// What was found and repaired.
    pub report: ImportReport,
}

impl Source {
    fn read(path: &Path) -> Result<Self> {
        let start = Instant::now();
        let imported = import(path)?;
        let hash = scene_hash(&imported.scene);
        let import_secs = start.elapsed().as_secs_f64();
        Ok(Self { scene: imported.scene.into(), hash, import_secs, report: imported.report })
    }
}

/// A thread that opens something. Dropping it drops the result.
pub struct Opening {
    /// What is said meanwhile.
    pub what: String,
    result: Receiver<Result<Opened, String>>,
}

impl Opening {
    /// Begins.
    pub fn start(target: Target, wake: Wake) -> Self {
        let (sender, result) = channel();
        let what = name(&target);
        spawn("open", move || {
            // A window that opened something else meanwhile needs no result.
            let _ = sender.send(guarded("opening the file", || open(target)));
            wake();
        });
        Self { what, result }
    }

    /// The result, once it is there.
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
        Target::File(path) => of(path),
        Target::Bundled { scene, .. } => of(scene),
        Target::Recovered(_) => "recovered work".into(),
        Target::Session { path, .. } => path.as_deref().map_or("the session".into(), of),
    }
}

/// Reads all that the target names.
///
/// # Errors
/// A file that cannot be read, in words for the user.
pub fn open(target: Target) -> Result<Opened> {
    match target {
        Target::File(path) => match kind_of(&path) {
            Kind::Scene => open_scene(&path).map(ready),
            Kind::Dataset => open_dataset(&path).map(ready),
            Kind::Session => open_session(&path, Some(path.clone()), false),
            _ => Err(anyhow::Error::msg(foreign(&path))),
        },
        Target::Bundled { scene, bakes } => open_bundled(&scene, &bakes).map(ready),
        Target::Recovered(recovery) => open_session(&recovery.file, recovery.session_path, true),
        Target::Session { loaded, path, unsaved } => resolve(*loaded, path, unsaved).map(ready),
    }
}

fn ready(ready: Ready) -> Opened {
    Opened::Ready(ready.into())
}

fn open_scene(path: &Path) -> Result<Ready> {
    let source = Source::read(path)?;
    let output = path.with_extension("cuts");
    let mut warnings = source.report.warnings.clone();
    let baked = read_if_there(&output, &mut warnings);
    let document = match &baked {
        Some(baked) => Document::of_dataset(&baked.dataset, output.clone(), Some(path.into())),
        None => Document::of_scene(&source.scene, Some(path.into())),
    };
    Ok(Ready {
        bake_output: Some(output),
        recent: Some(path.into()),
        ..Ready::new(document, baked, Some(source), warnings)
    })
}

/// A dataset that is not there, or damaged, only has to be baked again.
fn read_if_there(path: &Path, warnings: &mut Vec<String>) -> Option<Baked> {
    if !path.is_file() {
        return None;
    }
    match Dataset::read(path) {
        Ok(dataset) => Some(Baked::new(dataset.into())),
        Err(error) => {
            warnings.push(format!("The bake cannot be used, bake again: {error}"));
            None
        }
    }
}

fn open_dataset(path: &Path) -> Result<Ready> {
    let baked = Baked::new(Dataset::read(path)?.into());
    let document = Document::of_dataset(&baked.dataset, path.into(), None);
    Ok(Ready { recent: Some(path.into()), ..Ready::new(document, Some(baked), None, Vec::new()) })
}

fn open_bundled(scene: &Path, bakes: &Path) -> Result<Ready> {
    let source = Source::read(scene)?;
    let output = bakes.join(bundled_name(scene, &source.hash));
    let mut warnings = source.report.warnings.clone();
    let normal = Preset::Normal.settings();
    let mut read =
        |path: &Path| read_if_there(path, &mut warnings).filter(|baked| baked.dataset.scene_hash == source.hash);
    let whole = read(&output).filter(|baked| baked.dataset.settings == normal);
    let bake_now = whole.is_none();
    let baked = whole.or_else(|| read(&draft_of(&output)));
    let document = match &baked {
        Some(baked) => {
            Document { bake: normal, ..Document::of_dataset(&baked.dataset, output.clone(), Some(scene.into())) }
        }
        None => Document { bake: normal, ..Document::of_scene(&source.scene, Some(scene.into())) },
    };
    Ok(Ready { bake_output: Some(output), bake_now, ..Ready::new(document, baked, Some(source), warnings) })
}

/// Where the draft of a bundled scene's bake is kept, to be shown at once while the bake goes on.
pub fn draft_of(output: &Path) -> PathBuf {
    output.with_extension("draft.cuts")
}

/// Another version of the scene has another bake.
fn bundled_name(scene: &Path, hash: &str) -> String {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    format!("{stem}-{}.cuts", hash.get(..16).unwrap_or(hash))
}

fn open_session(file: &Path, path: Option<PathBuf>, unsaved: bool) -> Result<Opened> {
    let loaded = session::load(file)?;
    if loaded.missing.is_empty() {
        return resolve(loaded, path, unsaved).map(ready);
    }
    Ok(Opened::Missing { loaded: loaded.into(), path, unsaved })
}

fn resolve(loaded: LoadedSession, path: Option<PathBuf>, unsaved: bool) -> Result<Ready> {
    let mut warnings = Vec::new();
    let scene_path = loaded.session.scene.clone();
    let source = scene_path.as_deref().filter(|p| p.is_file()).map(Source::read).transpose()?;
    let output = loaded.session.dataset.clone().or_else(|| scene_path.map(|p| p.with_extension("cuts")));
    let baked = output.as_deref().and_then(|output| read_if_there(output, &mut warnings));
    let unknown = loaded.unknown.clone();
    let (mut document, remarks) = loaded.into_document(baked.as_ref().map(|b| &*b.dataset));
    if let (None, Some(source)) = (&baked, &source) {
        complete(&mut document, &source.scene);
    }
    warnings.extend(remarks);
    let recent = path.clone();
    let bake_output = source.is_some().then_some(output).flatten();
    let rest = Ready::new(document, baked, source, warnings);
    Ok(Ready { unknown, session: path, unsaved, bake_output, recent, ..rest })
}

/// A session of a scene that was not baked yet may have fewer materials and textures than the scene.
fn complete(document: &mut Document, scene: &Scene) {
    if document.textures.is_empty() {
        let entry = |texture: &Arc<_>| TextureEntry { texture: Arc::clone(texture), file: None };
        document.textures = scene.textures.iter().map(entry).collect();
    }
    let known = document.materials.len().min(scene.materials.len());
    document.materials.extend_from_slice(&scene.materials[known..]);
}

impl Ready {
    fn new(document: Document, baked: Option<Baked>, source: Option<Source>, warnings: Vec<String>) -> Self {
        Self {
            document,
            unknown: Unknown::default(),
            session: None,
            unsaved: false,
            baked,
            source,
            bake_output: None,
            bake_now: false,
            warnings,
            recent: None,
        }
    }
}
