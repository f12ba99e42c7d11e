//! The environment: its map, the library of maps, and their panels.

mod load;
pub mod panel;
mod state;

pub use state::Environments;

use crate::{actions::Action, document::library, picture::Picture, workspace::Workspace};
use egui::Ui;
use lapidary_core::environment::Environment;
use panel::{EnvironmentContext, LibraryEntry};
use std::sync::Arc;

impl Environments {
    /// Shows the tab.
    pub fn show(&mut self, ui: &mut Ui, work: &Workspace, picture: &Picture, actions: &mut Vec<Action>) {
        let Self { panel, loaded, problem, .. } = self;
        panel::show(ui, panel, &context(work, picture, (loaded, problem), &[]), actions);
    }

    /// Shows the maps to choose from.
    pub fn show_library(&mut self, ui: &mut Ui, work: &Workspace, picture: &Picture, actions: &mut Vec<Action>) {
        let entries = self.entries();
        let Self { panel, loaded, problem, .. } = self;
        panel::show_library(ui, panel, &context(work, picture, (loaded, problem), &entries), actions);
    }

    /// The maps of the library with their pictures.
    fn entries(&mut self) -> Vec<LibraryEntry> {
        let entries = self.library.entries().into_iter();
        let with_picture = |entry: library::LibraryEntry| {
            let spec = entry.path.to_string_lossy().into_owned();
            let thumbnail = if entry.missing { None } else { self.picture(&spec).cloned() };
            // With its extension, to distinguish it from a formula of the same name.
            let name = entry.path.file_name().map_or(entry.name, |name| name.to_string_lossy().into_owned());
            LibraryEntry { name, spec, missing: entry.missing, thumbnail }
        };
        entries.map(with_picture).collect()
    }
}

/// Input of the panels: the loaded map, or the problem with it.
fn context<'a>(
    work: &'a Workspace,
    picture: &'a Picture,
    (loaded, problem): (&'a Option<Arc<Environment>>, &'a Option<String>),
    library: &'a [LibraryEntry],
) -> EnvironmentContext<'a> {
    let (scene, shown) = (&work.scene, picture.shown());
    let lacks_ground = scene.rendered().is_some_and(|baked| !baked.has_ground());
    EnvironmentContext {
        lacks_ground: lacks_ground && scene.source.is_none(),
        document: &work.document,
        environment: loaded.as_ref(),
        library,
        tree: scene.rendered().map(|baked| &baked.dataset.tree),
        lighting: shown.map(|s| &s.lighting),
        light_revision: shown.map_or(0, |s| s.light_revision),
        message: problem.as_deref(),
    }
}
