//! A file dialog of the window's own: a path to type, and the folder's entries to click.

use super::{Mode, Purpose};
use crate::{document::absolute, widgets::copyable};
use egui::{
    Align, Context, Key, Label, Layout, Modal, RichText, ScrollArea, TextEdit, Ui,
    text::{CCursor, CCursorRange},
};
use lapidary_interchange::image::file_and_layer;
use std::path::{Path, PathBuf};

/// Entries that are listed; more can be typed.
const LISTED: usize = 2000;

/// The dialog while it is open.
pub struct PathEntry {
    purpose: Purpose,
    folder: PathBuf,
    /// The typed text: a name in the folder, or any path.
    text: String,
    entries: Vec<Entry>,
    problem: Option<String>,
    /// An existing file whose replacement is not confirmed yet.
    replacing: Option<PathBuf>,
    fresh: bool,
}

struct Entry {
    name: String,
    is_folder: bool,
}

/// `None` while the dialog stays open; then the path, or `None` if it was canceled.
type Answer = Option<Option<PathBuf>>;

impl PathEntry {
    /// Lists `folder`, with `name` as the suggested file.
    pub fn new(purpose: &Purpose, folder: PathBuf, name: String) -> Self {
        let mut entry = Self {
            purpose: purpose.clone(),
            folder: PathBuf::new(),
            text: name,
            entries: Vec::new(),
            problem: None,
            replacing: None,
            fresh: true,
        };
        entry.enter(folder);
        entry
    }

    /// Shows the dialog.
    pub fn show(&mut self, ctx: &Context) -> Answer {
        let modal = Modal::new(egui::Id::unique("path entry")).show(ctx, |ui| self.contents(ui));
        let closed = modal.should_close();
        modal.inner.or(closed.then_some(None))
    }

    fn contents(&mut self, ui: &mut Ui) -> Answer {
        ui.set_width(520.0);
        ui.heading(self.purpose.title);
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            if ui.button("Up").on_hover_text("Go to the parent folder").clicked() {
                self.enter_parent();
            }
            ui.add(Label::new(RichText::new(self.folder.display().to_string()).weak()).truncate().selectable(true));
        });
        let picked = self.list(ui);
        let typed = self.text_field(ui);
        if let Some(problem) = &self.problem {
            copyable(ui, RichText::new(problem).color(ui.visuals().error_fg_color));
        }
        ui.add_space(4.0);
        let (accepted, cancelled) = self.buttons(ui);
        if cancelled {
            return Some(None);
        }
        if picked || typed || accepted { self.accept().map(Some) } else { None }
    }

    /// Returns whether the path was accepted or the dialog canceled. The button that replaces a file is not where the first click
    /// was.
    fn buttons(&self, ui: &mut Ui) -> (bool, bool) {
        let replaces = self.replacing.is_some();
        let row = ui.horizontal(|ui| {
            let accepts = ui.add_enabled(!replaces, egui::Button::new(self.purpose.button)).clicked();
            let cancels = ui.button("Cancel").clicked();
            (accepts || replaces && ui.button("Replace").clicked(), cancels)
        });
        row.inner
    }

    /// Returns whether a file was double-clicked.
    fn list(&mut self, ui: &mut Ui) -> bool {
        let mut entered = None;
        let mut picked = false;
        let height = ui.spacing().interact_size.y;
        ScrollArea::vertical().max_height(260.0).min_scrolled_height(260.0).auto_shrink(false).show_rows(
            ui,
            height,
            self.entries.len(),
            |ui, rows| {
                for entry in &self.entries[rows] {
                    let label = if entry.is_folder { format!("{}/", entry.name) } else { entry.name.clone() };
                    let row = egui::Button::selectable(self.text == entry.name, label);
                    let left = Layout::top_down_justified(Align::LEFT);
                    let response = ui.with_layout(left, |ui| ui.add(row.truncate())).inner;
                    if response.clicked() && entry.is_folder {
                        entered = Some(entry.name.clone());
                    } else if response.clicked() {
                        self.text.clone_from(&entry.name);
                        self.replacing = None;
                        picked = response.double_clicked();
                    }
                }
                if self.entries.is_empty() {
                    ui.weak(format!("No {} here", self.purpose.files.to_lowercase()));
                }
            },
        );
        if let Some(name) = entered {
            self.enter(self.folder.join(name));
        }
        picked
    }

    /// Returns whether Enter was pressed in it.
    fn text_field(&mut self, ui: &mut Ui) -> bool {
        let edit = TextEdit::singleline(&mut self.text).desired_width(f32::INFINITY).hint_text("Name or path");
        let mut output = edit.show(ui);
        let field = output.response.response.accessible_name("Path");
        if std::mem::take(&mut self.fresh) {
            field.request_focus();
            // Typing replaces the suggested name and keeps its extension.
            let stem = Path::new(&self.text).file_stem().map_or(0, |stem| stem.to_string_lossy().chars().count());
            let range = CCursorRange::two(CCursor::new(0), CCursor::new(stem));
            output.state.cursor.set_char_range(Some(range));
            output.state.store(ui.ctx(), field.id);
        }
        if field.changed() {
            self.problem = None;
            self.replacing = None;
        }
        field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter))
    }

    /// The path if it is valid; otherwise shows the reason, or opens the folder that was typed.
    fn accept(&mut self) -> Option<PathBuf> {
        let typed = self.text.trim();
        let path = if typed.is_empty() { self.folder.clone() } else { absolute(&self.folder.join(expand_home(typed))) };
        match self.purpose.mode {
            Mode::Folder if path.is_dir() => return Some(path),
            _ if path.is_dir() && !typed.is_empty() => {
                self.text.clear();
                self.enter(path);
            }
            _ if typed.is_empty() => self.problem = Some("Choose a file or type a path.".into()),
            Mode::Save => return self.accept_to_write(path),
            Mode::Open | Mode::OpenMany if file_and_layer(&path).0.is_file() => return Some(path),
            _ => self.problem = Some(format!("File not found; check the path ({})", path.display())),
        }
        None
    }

    fn accept_to_write(&mut self, path: PathBuf) -> Option<PathBuf> {
        let path = self.purpose.with_extension(path);
        if path.parent().is_some_and(|folder| !folder.is_dir()) {
            self.problem = Some(format!("Folder not found; create it first ({})", path.display()));
        } else if path.exists() && self.replacing.as_ref() != Some(&path) {
            self.problem = Some(format!("File already exists. Replace it? ({})", path.display()));
            self.replacing = Some(path);
        } else {
            return Some(path);
        }
        None
    }

    fn enter_parent(&mut self) {
        if let Some(parent) = self.folder.parent().map(Path::to_owned) {
            self.enter(parent);
        }
    }

    fn enter(&mut self, folder: PathBuf) {
        let folder = absolute(&folder);
        self.replacing = None;
        match std::fs::read_dir(&folder) {
            Ok(entries) => {
                let entries = entries.flatten().filter_map(|entry| self.entry(&entry));
                self.entries = entries.take(LISTED).collect();
                self.entries.sort_by_key(|e| (!e.is_folder, e.name.to_lowercase()));
                self.folder = folder;
                self.problem = None;
            }
            Err(error) => {
                self.problem = Some(format!("Cannot read the folder: {error} ({})", folder.display()));
                if self.folder.as_os_str().is_empty() {
                    self.folder = folder;
                }
            }
        }
    }

    /// Whether an entry is listed: folders and files of this purpose, without hidden ones and checkpoints of bakes.
    fn entry(&self, entry: &std::fs::DirEntry) -> Option<Entry> {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_folder = path.is_dir();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let fits = self.purpose.extensions.contains(&extension.as_str()) && self.purpose.mode != Mode::Folder;
        let is_shown = !name.starts_with('.') && !name.ends_with(".cuts.partial");
        (is_shown && (is_folder || fits)).then_some(Entry { name, is_folder })
    }
}

/// `~/` stands for the home folder.
fn expand_home(typed: &str) -> PathBuf {
    match (typed.strip_prefix("~/"), std::env::var_os("HOME")) {
        (Some(rest), Some(home)) => Path::new(&home).join(rest),
        _ => typed.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actions::Action;
    use crate::actions::{EnvironmentAction, FileAction};
    use egui_kittest::{Harness, kittest::Queryable};

    fn entry(action: &Action, folder: &Path, name: &str) -> PathEntry {
        PathEntry::new(&Purpose::of(action).unwrap(), folder.to_owned(), name.into())
    }

    #[test]
    fn folders_come_first_and_foreign_files_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        for file in ["b.obj", "a.cuts", "notes.txt", ".hidden.obj"] {
            std::fs::write(folder.path().join(file), b"").unwrap();
        }
        for inner in ["z", "a.cuts.partial"] {
            std::fs::create_dir(folder.path().join(inner)).unwrap();
        }
        let entry = entry(&Action::File(FileAction::Open(None)), folder.path(), "");
        let names: Vec<_> = entry.entries.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(names, ["z", "a.cuts", "b.obj"]);
    }

    #[test]
    fn detours_are_taken_out_of_paths() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("a")).unwrap();
        std::fs::write(folder.path().join("b.obj"), b"").unwrap();
        let mut entry = entry(&Action::File(FileAction::Open(None)), &folder.path().join("a/../a"), "../b.obj");
        assert_eq!(entry.folder, folder.path().join("a"));
        assert_eq!(entry.accept(), Some(folder.path().join("b.obj")));
        entry.enter_parent();
        assert_eq!(entry.folder, folder.path());
    }

    #[test]
    fn a_layer_of_a_picture_is_opened() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.exr"), b"").unwrap();
        let load = Action::Environment(EnvironmentAction::Load(None));
        let typed = |name: &str| entry(&load, folder.path(), name).accept();
        assert_eq!(typed("a.exr#Normal"), Some(folder.path().join("a.exr#Normal")));
        assert_eq!([typed("gone.exr#Normal"), typed("a.png#Normal")], [None, None], "negative control");
    }

    #[test]
    fn only_files_that_are_there_can_be_opened_and_replacing_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.lapidary"), b"").unwrap();
        assert!(entry(&Action::File(FileAction::Open(None)), folder.path(), "gone.obj").accept().is_none());
        assert_eq!(
            entry(&Action::File(FileAction::Open(None)), folder.path(), "a.lapidary").accept(),
            Some(folder.path().join("a.lapidary"))
        );
        let mut save = entry(&Action::File(FileAction::SaveAs(None)), folder.path(), "a");
        assert!(save.accept().is_none() && save.problem.is_some());
        assert_eq!(save.accept(), Some(folder.path().join("a.lapidary")));
        assert_eq!(
            entry(&Action::File(FileAction::SaveAs(None)), folder.path(), "b").accept(),
            Some(folder.path().join("b.lapidary")),
            "a new file needs no question"
        );
        assert!(entry(&Action::File(FileAction::SaveAs(None)), folder.path(), "no/b").accept().is_none());
    }

    #[test]
    fn a_path_can_be_typed_and_the_dialog_cancelled() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.obj"), b"").unwrap();
        let state = (entry(&Action::File(FileAction::Open(None)), folder.path(), ""), None::<Answer>);
        let mut harness = Harness::new_ui_state(
            |ui, (entry, answer): &mut (PathEntry, Option<Answer>)| {
                if let Some(path) = entry.show(ui.ctx()) {
                    *answer = Some(Some(path));
                }
            },
            state,
        );
        harness.run_steps(3);
        harness.get_by_label("a.obj").click();
        harness.run_steps(2);
        harness.get_by_label("Open").click();
        harness.run_steps(2);
        assert_eq!(harness.state().1, Some(Some(Some(folder.path().join("a.obj")))));
        harness.get_by_label("Cancel").click();
        harness.run_steps(2);
        assert_eq!(harness.state().1, Some(Some(None)));
    }
}
