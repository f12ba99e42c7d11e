//! All that the window knows, and what happens in a frame of it. It runs without a window too, as in tests.

use super::{
    baking::Baking,
    comparison::Comparison,
    dialogs::FileDialogs,
    environments::Environments,
    explain::ExplainWindow,
    export::Exporting,
    first_view::FirstView,
    ladder::LadderWindow,
    layout::{self, Interface},
    messages::Messages,
    opening::{Opening, Target},
    pictures::Pictures,
    prompts::{self, Prompt, Then},
    requests::Requests,
};
use crate::{
    actions::Action,
    document::{
        Document, History,
        autosave::{self, Autosave, Recovery},
        library::EnvironmentLibrary,
        recent::RecentFiles,
        session::Unknown,
    },
    jobs::{
        Imported, Wake,
        load::Loader,
        render_thread::{Factory, RenderThread},
        watch::Watcher,
    },
    paths::Folders,
    preferences::Preferences,
    viewport::pick,
};
use egui::{Event, Ui, ViewportCommand};
use lapidary_core::{bounds::Bounds, scene::Mesh};
use lapidary_render::Baked;
use std::{
    collections::{HashMap, VecDeque},
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

/// Seconds between two autosaves.
const AUTOSAVE_INTERVAL: Duration = Duration::from_secs(20);

/// What the window is made of.
pub struct Setup {
    /// Where preferences, autosaves and bakes of bundled scenes are.
    pub folders: Folders,
    /// The bundled scenes, and the bundled environments.
    pub bundled: Bundled,
    /// Makes the renderer.
    pub factory: Factory,
    /// Makes the window look for results of jobs.
    pub wake: Wake,
    /// Whether the system's file dialogs may be used.
    pub system_dialogs: bool,
}

/// What comes with the program, as far as it was found.
#[derive(Clone, Debug, Default)]
pub struct Bundled {
    /// The scenes; the first one opens where no file is named.
    pub scenes: Vec<PathBuf>,
    /// The environments.
    pub environments: Vec<PathBuf>,
}

/// What is selected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// An object of the mesh.
    pub object: Option<u32>,
    /// A material.
    pub material: Option<usize>,
    /// A local light; undo may have taken it away, see [`EditorState::selected_light`].
    pub light: Option<usize>,
}

/// The scene that is open, as far as it is not in the document.
#[derive(Default)]
pub struct OpenScene {
    /// What can be rendered.
    pub baked: Option<Baked>,
    /// What can be baked.
    pub source: Option<Imported>,
    /// Where a bake goes.
    pub bake_output: Option<PathBuf>,
    /// Show a bake of another version of the scene.
    pub show_stale: bool,
    /// The session file.
    pub session: Option<PathBuf>,
    /// What the session file has that this version does not know.
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

    /// What is rendered.
    pub fn shown(&self) -> Option<&Baked> {
        self.baked.as_ref().filter(|_| self.show_stale || !self.is_stale())
    }
}

/// Bounds of what is shown, found when it changes: a pass over the mesh takes longer than a frame should.
#[derive(Default)]
pub struct ShownBounds {
    of: Option<(usize, Option<u32>)>,
    /// All of it.
    pub scene: Option<Bounds>,
    /// What is selected.
    pub selection: Option<Bounds>,
}

impl ShownBounds {
    fn update(&mut self, shown: Option<&Baked>, selected: Option<u32>) {
        let of = shown.map(|baked| (Arc::as_ptr(&baked.dataset) as usize, selected));
        if of != self.of {
            let mesh = shown.map(|baked| &baked.dataset.scene.mesh);
            self.of = of;
            self.scene = mesh.map(Mesh::bounds);
            self.selection = mesh.zip(selected).and_then(|(mesh, object)| pick::object_bounds(mesh, object));
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
    /// What is done once the session has been saved.
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
    pub(super) factory: Factory,
    pub(super) exporting: Exporting,
    pub(super) requests: Requests,
    autosave: Autosave,
    autosaved: u64,
    /// The autosave that the document was recovered from, until it is written elsewhere.
    pub(super) recovered: Option<Recovery>,
    /// Nothing is left to ask: the window may close.
    pub(super) may_close: bool,
    themed: Option<Preferences>,
    /// Size of the window in points, but not while it fills the screen.
    window_size: Option<[f32; 2]>,
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
            interface: Interface::default(),
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

    /// Begins to open something. Whether changes would be lost is asked once it is there to take their place.
    pub fn open(&mut self, target: Target) {
        self.opening = Some(Opening::start(target, self.wake.clone()));
    }

    /// Whether there are changes that are not saved.
    pub fn is_modified(&self) -> bool {
        self.history.is_modified()
    }

    /// One frame: what jobs have done, the interface, what it asked for, and what is to be rendered then.
    pub fn frame(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        if self.themed.as_ref() != Some(&self.preferences) {
            super::theme::apply(&ctx, &self.preferences);
            self.themed = Some(self.preferences.clone());
        }
        self.note_window_size(&ctx);
        self.collect(&ctx);
        self.bounds.update(self.scene.shown(), self.selection.object);
        self.take_pasted_camera(&ctx);
        let mut actions = Vec::new();
        let laid = layout::show(ui, self, &mut actions);
        self.take_drops(&ctx, &laid, &mut actions);
        self.show_dialog(&ctx, &mut actions);
        self.show_ladder(&ctx, &mut actions);
        self.show_explanation(&ctx);
        prompts::show(&ctx, self, &mut actions);
        self.show_sequence_dialog(&ctx, &mut actions);
        self.messages.show(&ctx, laid.status_height);
        self.ask_before_closing(&ctx, &mut actions);
        if !actions.is_empty() {
            // What is on the screen is from before the actions.
            ctx.request_repaint();
        }
        for action in actions {
            self.perform(&ctx, action);
        }
        self.load_environment();
        self.request_picture(&ctx, laid.viewport);
        self.compare();
        self.keep_safe(&ctx);
    }

    /// Remembers how large the window is, for the next start.
    fn note_window_size(&mut self, ctx: &egui::Context) {
        let scale = self.preferences.ui_scale;
        self.window_size = ctx.input(|i| {
            let window = i.viewport();
            let fills = window.maximized == Some(true) || window.fullscreen == Some(true);
            // The interface's points are larger than the window's by its scale.
            window.inner_rect.filter(|_| !fills).map(|rect| [rect.width() * scale, rect.height() * scale])
        });
    }

    /// Shows the file dialog, if one is open. Cancelling where to save to cancels what was to follow.
    fn show_dialog(&mut self, ctx: &egui::Context, actions: &mut Vec<Action>) {
        let was_open = self.dialogs.is_open();
        let chosen = self.dialogs.show(ctx);
        if was_open && !self.dialogs.is_open() && chosen.is_empty() {
            self.after_save = None;
        }
        if let Some((files, folder)) = self.dialogs.left() {
            let mut preferences = self.preferences.clone();
            preferences.folders.remember(files, &folder);
            actions.push(Action::Preferences(preferences));
        }
        actions.extend(chosen);
    }

    /// The text that was asked of the clipboard arrives a frame later, or never if there is none.
    fn take_pasted_camera(&mut self, ctx: &egui::Context) {
        if self.interface.pasting_camera == 0 {
            return;
        }
        self.interface.pasting_camera -= 1;
        let pasted = ctx.input_mut(|i| {
            let place = i.events.iter().position(|e| matches!(e, Event::Paste(_)))?;
            Some(i.events.remove(place))
        });
        if let Some(Event::Paste(text)) = pasted {
            self.interface.pasting_camera = 0;
            self.paste_camera(&text);
        }
    }

    /// Takes what jobs have made since the last frame.
    fn collect(&mut self, ctx: &egui::Context) {
        self.collect_opened();
        self.collect_loaded();
        self.collect_bake();
        self.collect_pictures(ctx);
        self.collect_comparison(ctx);
        self.collect_export();
        self.collect_changed_files();
        self.environments.collect(ctx);
    }

    /// A window that is about to close asks about changes first.
    fn ask_before_closing(&mut self, ctx: &egui::Context, actions: &mut Vec<Action>) {
        if ctx.input(|i| i.viewport().close_requested()) && !self.may_close {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            actions.push(Action::Quit);
        }
    }

    /// Writes the document aside when it is time, and comes back for it.
    fn keep_safe(&mut self, ctx: &egui::Context) {
        let session = self.scene.session.as_deref();
        let tick = self.autosave.tick(Instant::now(), &self.document, &self.history, &self.scene.unknown, session);
        match tick {
            Ok(true) => {
                self.autosaved = self.history.revision();
                self.forget_recovered();
            }
            Ok(false) => {}
            Err(error) => self.messages.error(format!("The autosave failed: {error}")),
        }
        if self.history.is_modified() && self.autosaved != self.history.revision() {
            ctx.request_repaint_after(AUTOSAVE_INTERVAL);
        }
    }

    /// Recovered work is written elsewhere by now.
    pub(super) fn forget_recovered(&mut self) {
        if let Some(recovered) = self.recovered.take()
            && let Err(error) = recovered.discard()
        {
            self.messages.warning(format!("An autosave cannot be removed: {error}"));
        }
    }

    /// Begins with another document.
    pub(super) fn forget_autosave(&mut self) {
        if let Err(error) = self.autosave.finish() {
            self.messages.warning(error.to_string());
        }
        self.autosaved = 0;
    }

    /// The window closes with nothing left to lose.
    pub fn finish(&mut self) {
        self.forget_autosave();
        if let Some([side, inspector]) = self.interface.panel_widths {
            (self.preferences.side_width, self.preferences.inspector_width) = (side, inspector);
        }
        if let Some(size) = self.window_size {
            self.preferences.window_size = size;
        }
        if let Err(error) = self.preferences.save(&self.folders.config) {
            eprintln!("warning: {error:#}");
        }
    }
}
