//! The window. [`EditorState`] is its state and behavior without a window, so that tests can run it; [`start`] opens
//! one.

mod camera;
mod dialogs;
mod dismissal;
mod documents;
mod drops;
mod files;
mod frame;
mod icons;
mod keyboard_map;
mod keys;
mod layout;
mod menus;
mod notice;
mod pacing;
mod perform;
mod prompts;
mod requests;
mod safekeeping;
mod side_panels;
mod start;
mod state;
mod status;
#[cfg(test)]
mod tests;
mod theme;
mod toolbar;

pub use start::{Launch, run};

use egui::{Ui, ViewportCommand};
use pacing::Pacing;
use state::EditorState;

/// The window's program.
struct EditorApp {
    state: EditorState,
    title: String,
    /// Where graphics are emulated.
    pacing: Option<Pacing>,
}

impl EditorApp {
    fn new(state: EditorState, pacing: Option<Pacing>) -> Self {
        Self { state, title: String::new(), pacing }
    }

    /// The title names the document, and marks changes.
    fn update_title(&mut self, ui: &Ui) {
        let mark = if self.state.work.is_modified() { "*" } else { "" };
        let title = format!("{mark}{} - Lapidary", self.state.work.title());
        if title != self.title {
            ui.ctx().send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for EditorApp {
    fn raw_input_hook(&mut self, _ctx: &egui::Context, _raw_input: &mut egui::RawInput) {
        if let Some(pacing) = &mut self.pacing {
            pacing.wait(self.state.picture.render.works());
        }
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.state.frame(ui);
        self.update_title(ui);
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        self.state.finish();
    }
}
