//! Opens a file completely: scene, dataset, session and the files that they name. A thread reads them until the
//! document is complete. Files outside the folder of a scene are read only with the user's consent.

use super::baking::fit_materials;
use crate::{
    document::{
        Document,
        autosave::Recovery,
        parts::{OwnMaterials, Renumbering},
        session::{self, LoadedSession, Unknown},
    },
    jobs::{
        Imported as Source, kept_bakes,
        load::{Kind, foreign, kind_of},
    },
    preferences::AllowedFolders,
};
use anyhow::Result;
use lapidary_core::{
    animation::{Animation, BoundAnimation},
    dataset::Dataset,
    ground::Ground,
    scene::Scene,
};
use lapidary_interchange::{
    animation, image,
    import::{ImportError, ImportOptions},
};
use lapidary_render::Baked;
use lapidary_studies::jobs::{Wake, guarded, spawn};
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
    /// A scene that comes with the program; nothing is written beside it.
    Bundled(PathBuf),
    /// The autosave of a process that did not exit cleanly.
    Recovered(Recovery),
    /// A session with missing files.
    Session {
        /// As it was read.
        loaded: Box<LoadedSession>,
        /// Its file; `None` for recovered work without one.
        path: Option<PathBuf>,
        /// The autosave it was read from, which nothing else keeps.
        recovery: Option<Recovery>,
        /// The folder to look for them in; `None` to open it without them.
        look_in: Option<PathBuf>,
    },
}

/// Result of opening.
pub enum Opened {
    /// A document to edit.
    Ready(Box<Ready>),
    /// Files of a session are not there; the user decides.
    Missing {
        /// The session.
        loaded: Box<LoadedSession>,
        /// Its file.
        path: Option<PathBuf>,
        /// The autosave it was read from, which nothing else keeps.
        recovery: Option<Recovery>,
        /// How many were found, if they were looked for.
        found: Option<usize>,
    },
    /// The scene names files outside its folder; the user decides.
    Outside {
        /// What was to be opened.
        target: Box<Target>,
        /// The scene.
        scene: PathBuf,
        /// The files, as it names them.
        names: Vec<String>,
    },
}

/// Whether scenes may name files outside their folders, and which did where nothing is known.
#[derive(Debug, Default)]
pub struct Consent {
    allowed: AllowedFolders,
    /// The user need not be asked.
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
    /// Nothing outside is read, and the user is not asked.
    pub fn refused() -> Self {
        Self { is_refused: true, ..Self::default() }
    }

    /// Imports a scene as far as it is allowed.
    fn import(&self, path: &Path) -> Result<Source, ImportError> {
        let allowed = !self.is_refused && self.allowed.allow(path);
        let imported = Source::read(path, allowed);
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

/// A document and what belongs to it.
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
    pub source: Option<Source>,
    /// What moves in a scene that cannot be baked: that of the file beside its dataset.
    pub animation: Option<Arc<Animation>>,
    /// Where a bake goes that the user asks for.
    pub bake_output: Option<PathBuf>,
    /// Where a bake goes that begins by itself.
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
    /// The message meanwhile.
    pub what: String,
    result: Receiver<Result<Opened, String>>,
}

impl Opening {
    /// Begins. Bakes that began by themselves are in the folder `bakes`.
    pub fn start(target: Target, bakes: PathBuf, consent: Consent, wake: Wake) -> Self {
        let (sender, result) = channel();
        let what = name(&target);
        spawn("open", move || {
            // A window that opened something else meanwhile needs no result.
            let _ = sender.send(guarded("opening the file", || open(target, &bakes, &consent)));
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
        Target::Bundled(scene) => of(scene),
        Target::Recovered(_) => "recovered work".into(),
        Target::Session { path, .. } => path.as_deref().map_or("the session".into(), of),
    }
}

/// Reads all that the target names, and bakes of it that are kept in the folder `bakes`.
///
/// # Errors
/// A file that cannot be read, in words for the user.
pub fn open(target: Target, bakes: &Path, consent: &Consent) -> Result<Opened> {
    let opened = read(target.clone(), &Reader { bakes, consent });
    match consent.unknown.take() {
        Some((scene, names)) => Ok(Opened::Outside { target: target.into(), scene, names }),
        None => opened,
    }
}

/// What reading needs besides the file.
struct Reader<'a> {
    bakes: &'a Path,
    consent: &'a Consent,
}

fn read(target: Target, reader: &Reader) -> Result<Opened> {
    match target {
        Target::File(path) => match kind_of(&path) {
            Kind::Scene => reader.scene(&path, path.with_extension("cuts")).map(ready),
            Kind::Dataset => open_dataset(&path).map(ready),
            Kind::Session => reader.session(&path, Some(path.clone()), None),
            kind => Err(anyhow::Error::msg(no_document(&path, kind))),
        },
        Target::Bundled(scene) => reader.bundled(&scene).map(ready),
        Target::Recovered(recovery) => {
            reader.session(&recovery.file.clone(), recovery.session_path.clone(), Some(recovery))
        }
        Target::Session { loaded, path, recovery, look_in: None } => Ok(ready(reader.resolve(*loaded, path, recovery))),
        Target::Session { loaded, path, recovery, look_in: Some(folder) } => {
            Ok(reader.look(loaded, path, recovery, &folder))
        }
    }
}

/// Why a file that is not edited by itself cannot be opened, and where it goes instead.
fn no_document(path: &Path, kind: Kind) -> String {
    let what = match kind {
        Kind::Environment => "this is an environment and no scene; use Library > Load..., or drop it on the window",
        Kind::Texture => "this is a picture and no scene; load it as a map of a material, or drop it on an object",
        Kind::Material => "this is a material and no scene; use Load... in the Material tab, or drop it on an object",
        Kind::Brdf => {
            "this is a BRDF and no scene; use Load... under the model in the Material tab, or drop it on an object"
        }
        Kind::Lights => "these are lights and no scene; use Load... in the Lights tab, or drop them on the window",
        Kind::Scene | Kind::Dataset | Kind::Session | Kind::Unknown => return foreign(path),
    };
    format!("{what} ({})", path.display())
}

fn ready(ready: Ready) -> Opened {
    Opened::Ready(ready.into())
}

/// A dataset that is not there, or damaged, only has to be baked again.
fn read_if_there(path: &Path, warnings: &mut Vec<String>) -> Option<Baked> {
    if !path.is_file() {
        return None;
    }
    match Dataset::read(path, image::decode) {
        Ok(dataset) => Some(Baked::begun(dataset)),
        Err(error) => {
            warnings.push(format!("The bake cannot be used, bake again: {error}"));
            None
        }
    }
}

fn open_dataset(path: &Path) -> Result<Ready> {
    let baked = Baked::begun(Dataset::read(path, image::decode)?);
    let document = Document::of_dataset(&baked.dataset, path.into(), None);
    Ok(Ready { recent: Some(path.into()), ..Ready::new(document, Some(baked), None, Vec::new()) })
}

/// What moves in the glTF file beside a dataset that has its name, as the window and most others write it. Files that cannot be
/// read or do not fit are passed over: the dataset does not say that they are its own.
fn animation_beside(dataset: &Path, scene: &Scene) -> Option<Arc<Animation>> {
    let files = animation::endings().into_iter().map(|ending| dataset.with_extension(ending));
    let file = files.into_iter().find(|file| file.is_file())?;
    let animation = Arc::new(animation::read(&file, &ImportOptions::default()).ok()?);
    BoundAnimation::new(animation.clone(), scene).is_ok().then_some(animation)
}

/// Path of the draft of a bake, which is shown at once while the bake continues.
pub fn draft_of(output: &Path) -> PathBuf {
    output.with_extension("draft.cuts")
}

/// Path in the folder `bakes` of a bake that began by itself. Another version of the scene has another bake.
pub fn kept_in(bakes: &Path, scene: &Path, hash: &str) -> PathBuf {
    let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
    bakes.join(format!("{stem}-{}.cuts", hash.get(..16).unwrap_or(hash)))
}

/// The bakes of a scene.
struct Found {
    /// The whole one, or one of another version of the scene, and its file.
    whole: Option<(Baked, PathBuf)>,
    /// A draft of one, if there is no whole one.
    draft: Option<Baked>,
    /// Where a bake goes that begins by itself.
    kept_output: PathBuf,
}

impl Reader<'_> {
    /// A scene whose bakes go to `output`.
    fn scene(&self, path: &Path, output: PathBuf) -> Result<Ready> {
        let source = self.consent.import(path)?;
        let mut warnings = source.report.warnings.clone();
        let found = self.bakes_of(&source, path, &output, &mut warnings);
        let document = match &found.whole {
            Some((baked, file)) if *file == output => {
                Document::of_dataset(&baked.dataset, output.clone(), Some(path.into()))
            }
            // The look is that of the scene as it is now. The file is not named: another machine would look for it in vain.
            Some((kept, _)) => Document::of_scene(&source.scene, Some(path.into())).with_bake(&kept.dataset),
            None => Document::of_scene(&source.scene, Some(path.into())),
        };
        Ok(Ready { recent: Some(path.into()), bake_output: Some(output), ..found.ready(document, source, warnings) })
    }

    fn bundled(&self, scene: &Path) -> Result<Ready> {
        let source = self.consent.import(scene)?;
        let output = kept_in(self.bakes, scene, &source.hash);
        let mut warnings = source.report.warnings.clone();
        let found = self.bakes_of(&source, scene, &output, &mut warnings);
        let document = Document::of_scene(&source.scene, Some(scene.into()));
        // A bake of other settings, poses or times is one that the user asked for.
        let document = match &found.whole {
            Some((baked, _)) => document.with_bake(&baked.dataset),
            None => document,
        };
        // Named before it is there, so that a session finds it later.
        let document = Document { dataset: Some(output.clone()), ..document };
        Ok(Ready { bake_output: Some(output), ..found.ready(document, source, warnings) })
    }

    /// The bakes of a scene: the one at `output`, or else one that is kept, or else a draft. Of another version of the scene
    /// only the first counts.
    fn bakes_of(&self, source: &Source, scene: &Path, output: &Path, warnings: &mut Vec<String>) -> Found {
        let kept_output = kept_in(self.bakes, scene, &source.hash);
        let is_of_scene = |baked: &Baked| baked.dataset.scene_hash == source.hash;
        let mut read = |path: &Path| read_if_there(path, warnings);
        let asked_for = read(output).map(|baked| (baked, output.to_owned()));
        let whole = match asked_for {
            Some(asked_for) if is_of_scene(&asked_for.0) => Some(asked_for),
            asked_for => {
                let kept = read(&kept_output).filter(is_of_scene).map(|baked| (baked, kept_output.clone()));
                kept.iter().for_each(|(_, file)| kept_bakes::touch(file));
                kept.or(asked_for)
            }
        };
        let draft = if whole.is_none() { read(&draft_of(&kept_output)).filter(is_of_scene) } else { None };
        Found { whole, draft, kept_output }
    }

    fn session(&self, file: &Path, path: Option<PathBuf>, recovery: Option<Recovery>) -> Result<Opened> {
        let loaded = session::load(file)?;
        if loaded.missing.is_empty() {
            return Ok(ready(self.resolve(loaded, path, recovery)));
        }
        Ok(Opened::Missing { loaded: loaded.into(), path, recovery, found: None })
    }

    /// Looks for the missing files of a session.
    fn look(
        &self,
        mut loaded: Box<LoadedSession>,
        path: Option<PathBuf>,
        recovery: Option<Recovery>,
        folder: &Path,
    ) -> Opened {
        let found = Some(loaded.relink(folder));
        if loaded.missing.is_empty() {
            return ready(self.resolve(*loaded, path, recovery));
        }
        Opened::Missing { loaded, path, recovery, found }
    }

    /// All files that the session names, as far as they can be read; unreadable ones are left out with a warning.
    fn resolve(&self, loaded: LoadedSession, path: Option<PathBuf>, recovery: Option<Recovery>) -> Ready {
        let mut warnings = Vec::new();
        let scene_path = loaded.session.scene.clone();
        let source = scene_path.as_deref().and_then(|path| self.source_if_there(path, &mut warnings));
        let output = loaded.session.dataset.clone().or_else(|| scene_path.as_ref().map(|p| p.with_extension("cuts")));
        let named = source.as_ref().zip(scene_path.as_deref()).zip(output.as_deref());
        let found = named.map(|((source, scene), output)| self.bakes_of(source, scene, output, &mut warnings));
        let baked = match &found {
            Some(found) => found.best(),
            // A dataset whose scene is gone can still be seen.
            None => output.as_deref().and_then(|output| read_if_there(output, &mut warnings)),
        };
        let unknown = loaded.unknown.clone();
        let ground = loaded.session.bake.ground;
        // What will be shown: a bake of the scene as it is, with the ground that the session has.
        let suits = |baked: &Baked| match &source {
            Some(source) => baked.dataset.scene_hash == source.hash && (ground == Ground::Off || baked.has_ground()),
            None => true,
        };
        let preview = || source.as_ref().map(|source| source.unshadowed(ground));
        let rendered = baked.clone().filter(suits).or_else(preview);
        let (document, remarks) = loaded.into_document(rendered.as_ref().map(|rendered| &rendered.dataset.scene));
        warnings.extend(remarks);
        let recent = path.clone();
        let bake_output = source.is_some().then_some(output).flatten();
        let ready = match found.zip(source) {
            Some((found, source)) => found.ready(document, source, warnings),
            None => Ready::new(document, baked, None, warnings),
        };
        Ready { unknown, session: path, recovery, bake_output, recent, ..ready }
    }

    /// Without its scene a session can still be seen, but not baked again.
    fn source_if_there(&self, path: &Path, warnings: &mut Vec<String>) -> Option<Source> {
        if !path.is_file() {
            return None;
        }
        let source = self.consent.import(path);
        source.map_err(|error| warnings.push(format!("The scene cannot be baked again: {error}"))).ok()
    }
}

impl Found {
    /// The best of them.
    fn best(&self) -> Option<Baked> {
        self.whole.as_ref().map(|(baked, _)| baked).or(self.draft.as_ref()).cloned()
    }

    /// The document of a scene with these bakes.
    fn ready(self, mut document: Document, source: Source, warnings: Vec<String>) -> Ready {
        let baked = self.best();
        // Of another version of the scene there may be something to see, but only if the user says so.
        let is_seen = baked.as_ref().is_some_and(|baked| baked.dataset.scene_hash == source.hash);
        let preview = (!is_seen).then(|| source.unshadowed(document.bake.ground));
        // A ground has a material of its own.
        let rendered = preview.as_ref().or(baked.as_ref());
        let own = document.own_materials();
        let lacks_some = |baked: &&&Baked| own < baked.dataset.scene.materials.len();
        if let Some(rendered) = rendered.as_ref().filter(lacks_some) {
            fit_materials(&mut document, &rendered.dataset);
            let [before, after] = [own, document.own_materials()].map(|count| OwnMaterials { count, ground: None });
            document.renumber_materials(&Renumbering { before, after });
        }
        if let Some(rendered) = rendered {
            document.take_objects(&rendered.dataset.scene);
        }
        let (lacks_bake, is_draft, kept_output) = (self.whole.is_none(), self.draft.is_some(), Some(self.kept_output));
        Ready { preview, lacks_bake, is_draft, kept_output, ..Ready::new(document, baked, Some(source), warnings) }
    }
}

impl Ready {
    fn new(document: Document, baked: Option<Baked>, source: Option<Source>, warnings: Vec<String>) -> Self {
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
