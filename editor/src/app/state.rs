//! The state of the window. Its behaviour is in the files of this folder: each adds a part to [`EditorState`], which
//! knows none of them.

pub mod interface;
pub mod prompt;

use super::{
    dialogs::FileDialogs,
    opening::{Consent, Opening, Target},
};
use crate::{
    bake::Baking,
    compare::Comparison,
    document::{
        autosave::{self, Autosave, Recovery},
        library::EnvironmentLibrary,
        recent::RecentFiles,
    },
    environment::Environments,
    explain::ExplainWindow,
    export::Exporting,
    jobs::{load::Loader, watch::Watcher},
    ladder::LadderWindow,
    lights::LightsPanel,
    materials::MaterialPanel,
    paths::Folders,
    picture::Picture,
    pose::Posing,
    preferences::Preferences,
    workspace::Workspace,
};
use interface::Interface;
use lapidary_render::BackendFactory;
use lapidary_studies::jobs::Wake;
use prompt::{Prompt, Then};
use std::{collections::VecDeque, path::PathBuf, time::Duration};

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
    pub(super) bundled: Bundled,
    pub(super) loader: Loader,
    pub(super) watcher: Watcher,
    pub(super) opening: Option<Opening>,
    pub(super) baking: Baking,
    pub(super) environments: Environments,
    pub(super) picture: Picture,
    pub(super) comparison: Comparison,
    pub(super) ladder: LadderWindow,
    pub(super) explain: ExplainWindow,
    pub(super) exporting: Exporting,
    pub(super) pose: Posing,
    pub(super) lights: LightsPanel,
    pub(super) materials: MaterialPanel,
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
            bundled,
            loader: Loader::new(wake.clone()),
            watcher: Watcher::start(wake.clone()),
            opening: None,
            baking: Baking::default(),
            environments: Environments::new(library, wake.clone()),
            picture: Picture::new(factory.clone(), wake.clone()),
            comparison: Comparison::new(factory, wake),
            ladder: LadderWindow::default(),
            explain: ExplainWindow::default(),
            exporting: Exporting::default(),
            pose: Posing::default(),
            lights: LightsPanel::default(),
            materials: MaterialPanel::default(),
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
