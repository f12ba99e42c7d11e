//! The state of the window: shared state, one field per feature, and state of the interface. Code across features is in the files
//! of `app`, each of which extends [`EditorState`].

pub mod interface;
pub mod prompt;

use super::{dialogs::FileDialogs, safekeeping::Safekeeping};
use crate::{
    bake::Baking,
    compare::Comparison,
    document::{autosave, library::EnvironmentLibrary, recent::RecentFiles},
    environment::Environments,
    explain::ExplainWindow,
    export::Exporting,
    jobs::{
        load::Loader,
        opening::{Consent, Opening, Target},
        watch::Watcher,
    },
    ladder::LadderWindow,
    lights::LightsPanel,
    looks::LooksPanel,
    materials::MaterialPanel,
    paths::Folders,
    picture::Picture,
    pose::Posing,
    workspace::Workspace,
};
use interface::Interface;
use lapidary_render::BackendFactory;
use lapidary_studies::{args::PathMemory, jobs::Wake};
use prompt::{Prompt, Questions};
use std::path::PathBuf;

/// Parts of the window.
pub struct Setup {
    /// Folders of preferences, autosaves and automatic bakes.
    pub folders: Folders,
    /// The bundled scenes, and the bundled environments.
    pub bundled: Bundled,
    /// Makes the renderer.
    pub factory: BackendFactory,
    /// What it measured.
    pub memory: PathMemory,
    /// Makes the window look for results of jobs.
    pub wake: Wake,
    /// Whether the system's file dialogs may be used.
    pub system_dialogs: bool,
}

/// Bundled data that were found.
#[derive(Clone, Debug, Default)]
pub struct Bundled {
    /// The scenes; the first one opens if no file is given.
    pub scenes: Vec<PathBuf>,
    /// The environments.
    pub environments: Vec<PathBuf>,
}

/// All state of the window.
pub struct EditorState {
    /// State that features share.
    pub(super) work: Workspace,
    /// State of the interface.
    pub(super) interface: Interface,
    pub(super) dialogs: FileDialogs,
    pub(super) questions: Questions,
    pub(super) recent: RecentFiles,
    pub(super) bundled: Bundled,
    /// What the renderer measured.
    pub(super) memory: PathMemory,
    pub(super) loader: Loader,
    pub(super) watcher: Watcher,
    pub(super) opening: Option<Opening>,
    pub(super) safe: Safekeeping,
    /// Each feature's own.
    pub(super) baking: Baking,
    pub(super) environments: Environments,
    pub(super) picture: Picture,
    pub(super) comparison: Comparison,
    pub(super) ladder: LadderWindow,
    pub(super) explain: ExplainWindow,
    pub(super) exporting: Exporting,
    pub(super) pose: Posing,
    pub(super) lights: LightsPanel,
    pub(super) looks: LooksPanel,
    pub(super) materials: MaterialPanel,
}

impl EditorState {
    /// With nothing open; offers to recover work of crashed processes.
    pub fn new(setup: Setup) -> Self {
        let Setup { folders, bundled, factory, memory, wake, system_dialogs } = setup;
        let work = Workspace::new(folders, factory.clone(), wake.clone());
        let recoverable = autosave::recoverable(&work.folders.state);
        let questions = Questions::of((!recoverable.is_empty()).then_some(Prompt::Recover(recoverable)));
        let library = EnvironmentLibrary::open(&work.folders.config, bundled.environments.clone());
        Self {
            interface: Interface::new([work.preferences.side_width, work.preferences.inspector_width]),
            dialogs: FileDialogs::new(wake.clone(), system_dialogs),
            questions,
            recent: RecentFiles::open(&work.folders.config),
            bundled,
            memory,
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
            looks: LooksPanel::default(),
            materials: MaterialPanel::default(),
            safe: Safekeeping::new(&work),
            work,
        }
    }

    /// Begins to open a target. Asks about unsaved changes once the new document is ready.
    pub fn open(&mut self, target: Target) {
        self.open_with(target, Consent::from(self.work.preferences.outside.clone()));
    }

    /// Begins to open a target without files outside its scene's folder.
    pub fn open_without(&mut self, target: Target) {
        self.open_with(target, Consent::refused());
    }

    fn open_with(&mut self, target: Target, consent: Consent) {
        self.opening = Some(Opening::start(target, self.work.folders.bakes(), consent, self.work.wake.clone()));
    }
}
