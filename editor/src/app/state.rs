//! The state of the window. Its behaviour is in the files of this folder: each adds a part to [`EditorState`], which
//! knows none of them.

pub mod comparison;
pub mod environments;
pub mod explain;
pub mod exporting;
pub mod interface;
pub mod ladder;
pub mod pictures;
pub mod prompt;
pub mod requests;

use super::{
    dialogs::FileDialogs,
    opening::{Consent, Opening, Target},
};
use crate::{
    bake::Baking,
    document::{
        autosave::{self, Autosave, Recovery},
        library::EnvironmentLibrary,
        recent::RecentFiles,
    },
    jobs::{load::Loader, render_thread::RenderThread, watch::Watcher},
    paths::Folders,
    preferences::Preferences,
    workspace::Workspace,
};
use comparison::Comparison;
use environments::Environments;
use explain::ExplainWindow;
use exporting::Exporting;
use interface::Interface;
use ladder::LadderWindow;
use lapidary_render::BackendFactory;
use lapidary_studies::jobs::Wake;
use pictures::Pictures;
use prompt::{Prompt, Then};
use requests::Requests;
use std::{
    collections::{HashMap, VecDeque},
    path::PathBuf,
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

/// All that the window knows.
pub struct EditorState {
    pub(super) work: Workspace,
    pub(super) interface: Interface,
    pub(super) dialogs: FileDialogs,
    /// Questions that wait, the one that is asked first.
    pub(super) prompts: VecDeque<Prompt>,
    /// The action after the session has been saved.
    pub(super) after_save: Option<Then>,
    pub(super) recent: RecentFiles,
    pub(super) library: EnvironmentLibrary,
    pub(super) bundled: Bundled,
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
        let work = Workspace::new(folders, factory.clone(), wake.clone());
        let recoverable = autosave::recoverable(&work.folders.state);
        let prompts = (!recoverable.is_empty()).then_some(Prompt::Recover(recoverable)).into_iter().collect();
        let library = EnvironmentLibrary::open(&work.folders.config, bundled.environments.clone());
        Self {
            interface: Interface::new([work.preferences.side_width, work.preferences.inspector_width]),
            dialogs: FileDialogs::new(wake.clone(), system_dialogs),
            prompts,
            after_save: None,
            recent: RecentFiles::open(&work.folders.config),
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
            comparison: Comparison::new(factory, wake),
            ladder: LadderWindow::default(),
            explain: ExplainWindow::default(),
            exporting: Exporting::default(),
            requests: Requests::default(),
            autosave: Autosave::new(&work.folders.state, AUTOSAVE_INTERVAL),
            autosaved: 0,
            recovered: None,
            may_close: false,
            themed: None,
            window_size: None,
            work,
        }
    }

    /// Begins to open something. Whether changes would be lost is asked once the new document is ready.
    pub fn open(&mut self, target: Target) {
        self.open_with(target, Consent::from(self.work.preferences.outside.clone()));
    }

    /// Begins to open something without files outside the folder of its scene.
    pub fn open_without(&mut self, target: Target) {
        self.open_with(target, Consent::refused());
    }

    fn open_with(&mut self, target: Target, consent: Consent) {
        self.opening = Some(Opening::start(target, self.work.folders.bakes(), consent, self.work.wake.clone()));
    }
}
