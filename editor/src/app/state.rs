//! The state of the window. Its behaviour is in the files of this folder: each adds a part to [`EditorState`], which
//! knows none of them.

pub mod baking;
pub mod comparison;
pub mod environments;
pub mod explain;
pub mod exporting;
pub mod interface;
pub mod ladder;
pub mod pictures;
pub mod prompt;
pub mod requests;
pub mod selection;

use super::{
    dialogs::FileDialogs,
    first_view::FirstView,
    opening::{Consent, Opening, Target},
};
use crate::{
    document::{
        Document, History,
        autosave::{self, Autosave, Recovery},
        library::EnvironmentLibrary,
        recent::RecentFiles,
        session::Unknown,
    },
    jobs::{Imported, load::Loader, render_thread::RenderThread, watch::Watcher},
    messages::Messages,
    paths::Folders,
    preferences::Preferences,
    viewport::pick,
};
use baking::Baking;
use comparison::Comparison;
use environments::Environments;
use explain::ExplainWindow;
use exporting::Exporting;
use interface::Interface;
use ladder::LadderWindow;
use lapidary_core::{
    animation::Animation,
    bounds::Bounds,
    parts::{Part, parts_of},
    scene::Mesh,
};
use lapidary_render::{BackendFactory, Baked};
use lapidary_studies::jobs::Wake;
use pictures::Pictures;
use prompt::{Prompt, Then};
use requests::Requests;
use selection::Selection;
use std::{
    collections::{HashMap, VecDeque},
    path::PathBuf,
    sync::Arc,
    time::Duration,
};

/// Seconds between two autosaves.
pub(super) const AUTOSAVE_INTERVAL: Duration = Duration::from_secs(20);

/// Parts of the window.
pub struct Setup {
    /// Where preferences, autosaves and bakes that begin by themselves are.
    pub folders: Folders,
    /// The bundled scenes, and the bundled environments.
    pub bundled: Bundled,
    /// Makes the renderer.
    pub factory: BackendFactory,
    /// Makes the window look for results of jobs.
    pub wake: Wake,
    /// Whether the system's file dialogs may be used.
    pub system_dialogs: bool,
}

/// Data bundled with the program, as far as they were found.
#[derive(Clone, Debug, Default)]
pub struct Bundled {
    /// The scenes; the first one opens where no file is named.
    pub scenes: Vec<PathBuf>,
    /// The environments.
    pub environments: Vec<PathBuf>,
}

/// The scene that is open, as far as it is not in the document.
#[derive(Default)]
pub struct OpenScene {
    /// The dataset, which can be rendered.
    pub baked: Option<Baked>,
    /// The scene without shadows, which is rendered until there is a dataset.
    pub preview: Option<Baked>,
    /// The scene, which can be baked.
    pub source: Option<Imported>,
    /// What moves in a scene that cannot be baked.
    pub animation: Option<Arc<Animation>>,
    /// Where a bake goes that the user asks for.
    pub bake_output: Option<PathBuf>,
    /// Where a bake goes that begins by itself.
    pub kept_output: Option<PathBuf>,
    /// Whether the dataset is a draft of a bake that is not finished.
    pub is_draft: bool,
    /// Show a bake of another version of the scene.
    pub show_stale: bool,
    /// The session file.
    pub session: Option<PathBuf>,
    /// Keys of the session file that this version does not know.
    pub unknown: Unknown,
    /// The camera that it was first seen by.
    pub first_view: Option<FirstView>,
}

impl OpenScene {
    /// Whether the dataset was baked from another version of the scene.
    pub fn is_stale(&self) -> bool {
        let hashes = self.baked.as_ref().zip(self.source.as_ref());
        hashes.is_some_and(|(baked, source)| baked.dataset.scene_hash != source.hash)
    }

    /// The dataset if it is rendered: a bake of the scene as it is now. One without a ground that was asked for is not.
    pub fn shown(&self) -> Option<&Baked> {
        let is_replaced = |baked: &Baked| self.preview.as_ref().is_some_and(Baked::has_ground) && !baked.has_ground();
        self.baked.as_ref().filter(|baked| self.show_stale || !(self.is_stale() || is_replaced(baked)))
    }

    /// What is rendered: the dataset, or the scene without shadows.
    pub fn rendered(&self) -> Option<&Baked> {
        self.shown().or(self.preview.as_ref())
    }
}

/// Bounds and parts of the mesh, computed when it changes: a pass over the mesh takes longer than a frame should.
#[derive(Default)]
pub struct ShownBounds {
    /// Address of the dataset, and the selected objects.
    of: Option<(usize, Vec<u32>)>,
    /// All of it.
    pub scene: Option<Bounds>,
    /// The selected objects, each.
    pub selection: Vec<Bounds>,
    /// All parts.
    pub parts: Vec<Part>,
}

impl ShownBounds {
    pub(super) fn update(&mut self, shown: Option<&Baked>, selected: impl Iterator<Item = u32>) {
        let of = shown.map(|baked| (Arc::as_ptr(&baked.dataset) as usize, selected.collect::<Vec<_>>()));
        if of != self.of {
            let mesh = shown.map(|baked| &baked.dataset.scene.mesh);
            let dataset = |of: &Option<(usize, _)>| of.as_ref().map(|(dataset, _)| *dataset);
            if dataset(&of) != dataset(&self.of) {
                self.parts = mesh.map(parts_of).unwrap_or_default();
            }
            let selected = of.iter().flat_map(|(_, objects)| objects);
            let bounds_in = |mesh| selected.filter_map(|&object| pick::object_bounds(mesh, object)).collect();
            self.selection = mesh.map(bounds_in).unwrap_or_default();
            self.scene = mesh.map(Mesh::bounds);
            self.of = of;
        }
    }
}

/// All that the window knows.
pub struct EditorState {
    pub(super) document: Document,
    pub(super) history: History,
    pub(super) scene: OpenScene,
    pub(super) selection: Selection,
    pub(super) bounds: ShownBounds,
    pub(super) interface: Interface,
    pub(super) messages: Messages,
    pub(super) dialogs: FileDialogs,
    /// Questions that wait, the one that is asked first.
    pub(super) prompts: VecDeque<Prompt>,
    /// The action after the session has been saved.
    pub(super) after_save: Option<Then>,
    pub(super) preferences: Preferences,
    pub(super) recent: RecentFiles,
    pub(super) library: EnvironmentLibrary,
    pub(super) folders: Folders,
    pub(super) bundled: Bundled,
    pub(super) wake: Wake,
    pub(super) render: RenderThread,
    pub(super) loader: Loader,
    /// Files that the loader reads, by the load's number.
    pub(super) loading: HashMap<u64, PathBuf>,
    pub(super) watcher: Watcher,
    pub(super) watched: Vec<PathBuf>,
    pub(super) opening: Option<Opening>,
    pub(super) baking: Baking,
    pub(super) environments: Environments,
    pub(super) pictures: Pictures,
    pub(super) comparison: Comparison,
    pub(super) ladder: LadderWindow,
    pub(super) explain: ExplainWindow,
    /// Makes renderers, for jobs that need one of their own.
    pub(super) factory: BackendFactory,
    pub(super) exporting: Exporting,
    pub(super) requests: Requests,
    pub(super) autosave: Autosave,
    pub(super) autosaved: u64,
    /// The autosave that the document was recovered from, until it is written elsewhere.
    pub(super) recovered: Option<Recovery>,
    /// Nothing is left to ask: the window may close.
    pub(super) may_close: bool,
    pub(super) themed: Option<Preferences>,
    /// Size of the window in points, but not while it fills the screen.
    pub(super) window_size: Option<[f32; 2]>,
}

impl EditorState {
    /// With nothing open; offers to recover what a process that ended too early left.
    pub fn new(setup: Setup) -> Self {
        let Setup { folders, bundled, factory, wake, system_dialogs } = setup;
        let (preferences, problem) = Preferences::load(&folders.config);
        let mut messages = Messages::default();
        problem.into_iter().for_each(|p| messages.warning(p));
        let recoverable = autosave::recoverable(&folders.state);
        let prompts = (!recoverable.is_empty()).then_some(Prompt::Recover(recoverable)).into_iter().collect();
        let library = EnvironmentLibrary::open(&folders.config, bundled.environments.clone());
        Self {
            document: Document::empty(),
            history: History::new(),
            scene: OpenScene::default(),
            selection: Selection::default(),
            bounds: ShownBounds::default(),
            interface: Interface::new([preferences.side_width, preferences.inspector_width]),
            messages,
            dialogs: FileDialogs::new(wake.clone(), system_dialogs),
            prompts,
            after_save: None,
            preferences,
            recent: RecentFiles::open(&folders.config),
            library,
            bundled,
            render: RenderThread::start(factory.clone(), wake.clone()),
            loader: Loader::new(wake.clone()),
            loading: HashMap::new(),
            watcher: Watcher::start(wake.clone()),
            watched: Vec::new(),
            opening: None,
            baking: Baking::default(),
            environments: Environments::new(wake.clone()),
            pictures: Pictures::default(),
            comparison: Comparison::new(factory.clone(), wake.clone()),
            ladder: LadderWindow::default(),
            explain: ExplainWindow::default(),
            exporting: Exporting::default(),
            factory,
            requests: Requests::default(),
            autosave: Autosave::new(&folders.state, AUTOSAVE_INTERVAL),
            autosaved: 0,
            recovered: None,
            may_close: false,
            themed: None,
            window_size: None,
            folders,
            wake,
        }
    }

    /// Begins to open something. Whether changes would be lost is asked once the new document is ready.
    pub fn open(&mut self, target: Target) {
        self.open_with(target, Consent::from(self.preferences.outside.clone()));
    }

    /// Begins to open something without files outside the folder of its scene.
    pub fn open_without(&mut self, target: Target) {
        self.open_with(target, Consent::refused());
    }

    fn open_with(&mut self, target: Target, consent: Consent) {
        self.opening = Some(Opening::start(target, self.folders.bakes(), consent, self.wake.clone()));
    }

    /// Whether there are changes that are not saved.
    pub fn is_modified(&self) -> bool {
        self.history.is_modified()
    }
}
