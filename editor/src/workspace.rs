//! State that all features share: the document with its history, the open scene, the selection, messages, preferences. Features
//! change it; it knows none of them.

mod another_scene;
pub mod first_view;
mod outputs;
mod scene;
mod selection;
mod shown_bounds;
mod steps;
mod tabs;

pub use outputs::{Written, brdf_files, files_in_use};
pub use scene::{BakeStage, OpenScene};
pub use selection::Selection;
pub use shown_bounds::ShownBounds;
pub use tabs::{Inspector, Side, Tabs};

use crate::{
    document::{Document, History},
    messages::Messages,
    paths::Folders,
    preferences::Preferences,
};
use lapidary_render::BackendFactory;
use lapidary_studies::jobs::Wake;
use std::path::Path;

/// State that all features share.
pub struct Workspace {
    /// The document.
    pub document: Document,
    /// Its steps of undo.
    pub history: History,
    /// The open scene, without the document.
    pub scene: OpenScene,
    /// The selection.
    pub selection: Selection,
    /// Bounds and parts of the shown scene.
    pub bounds: ShownBounds,
    /// The visible panels and tabs.
    pub tabs: Tabs,
    /// Width and height of the viewport in pixels.
    pub viewport_size: [u32; 2],
    /// Messages to the user.
    pub messages: Messages,
    /// Preferences of the user.
    pub preferences: Preferences,
    /// Folders of preferences, autosaves and automatic bakes.
    pub folders: Folders,
    /// Makes renderers, for jobs that need one of their own.
    pub factory: BackendFactory,
    /// Makes the window look for results of jobs.
    pub wake: Wake,
}

impl Workspace {
    /// With nothing open.
    pub fn new(folders: Folders, factory: BackendFactory, wake: Wake) -> Self {
        let (preferences, problem) = Preferences::load(&folders.config);
        let mut messages = Messages::default();
        problem.into_iter().for_each(|p| messages.warning(p));
        Self {
            document: Document::empty(),
            history: History::new(),
            scene: OpenScene::default(),
            selection: Selection::default(),
            bounds: ShownBounds::default(),
            tabs: Tabs::default(),
            viewport_size: [1, 1],
            messages,
            preferences,
            folders,
            factory,
            wake,
        }
    }

    /// Whether there are unsaved changes.
    pub fn is_modified(&self) -> bool {
        self.history.is_modified()
    }

    /// The open file: the session, else the scene, else the dataset.
    pub fn file(&self) -> Option<&Path> {
        let Document { scene, dataset, .. } = &self.document;
        self.scene.session.as_deref().or(scene.as_deref()).or(dataset.as_deref())
    }

    /// Title of the window.
    pub fn title(&self) -> String {
        self.file().and_then(|p| p.file_name()).map_or("Untitled".into(), |name| name.to_string_lossy().into_owned())
    }

    /// Diagonal of the scene in meters, else the distance of the camera's target.
    pub fn scene_size(&self) -> f32 {
        let camera = &self.document.camera;
        let diagonal = self.scene.bounds().map(|bounds| bounds.diagonal());
        diagonal.filter(|size| *size > 0.0).unwrap_or_else(|| camera.eye.distance(camera.target))
    }

    /// Width over height of the viewport.
    pub fn aspect(&self) -> f32 {
        let [width, height] = self.viewport_size;
        width as f32 / height.max(1) as f32
    }

    /// Sets and saves preferences.
    pub fn prefer(&mut self, preferences: Preferences) {
        self.preferences = preferences.clamped();
        if let Err(error) = self.preferences.save(&self.folders.config) {
            self.messages.warning(format!("{error:#}"));
        }
    }
}
