//! File dialogs. The system's own dialog runs on its own thread. Without one, as on a bare X server, the window has a
//! dialog that lists folders.

mod path_entry;
mod purpose;

pub use purpose::{Mode, Purpose};

use crate::{
    actions::Action,
    document::{absolute, folder_of},
    preferences::{FileUse, LastFolders},
};
use egui::Context;
use lapidary_studies::jobs::Wake;
use path_entry::PathEntry;
use std::{
    path::{Path, PathBuf},
    sync::mpsc::{Receiver, TryRecvError, channel},
    time::{Duration, Instant},
};

/// An answer faster than anyone can press Cancel means that the system has no dialog.
const FASTER_THAN_A_PERSON: Duration = Duration::from_millis(300);

/// The dialog that is open, if any.
pub struct FileDialogs {
    open: Option<Open>,
    /// Whether the system has file dialogs.
    system: bool,
    /// Purpose and folder of the last answered dialog, until they are remembered.
    left: Option<(FileUse, PathBuf)>,
    wake: Wake,
}

struct Open {
    purpose: Purpose,
    action: Action,
    folder: PathBuf,
    name: String,
    by: By,
}

enum By {
    System { answer: Receiver<Option<Vec<PathBuf>>>, since: Instant },
    Window(Box<PathEntry>),
}

impl FileDialogs {
    /// With the system's dialogs if they may be used and there seem to be any.
    pub fn new(wake: Wake, system: bool) -> Self {
        Self { open: None, system: system && system_has_dialogs(), left: None, wake }
    }

    /// Asks for the path of `action`, which [`Self::show`] returns with it. The dialog begins in the last folder for
    /// this purpose, else in `folder`, and suggests `name`; a dialog that is open already stays.
    pub fn ask(&mut self, action: Action, last: &LastFolders, folder: Option<PathBuf>, name: Option<String>) {
        let Some(purpose) = Purpose::of(&action) else { return };
        if self.open.is_some() {
            return;
        }
        let folder = last.of(purpose.files_for).or(folder).map_or_else(home, |folder| absolute(&folder));
        let name = name.unwrap_or_default();
        let by = if self.system {
            By::System { answer: ask_system(&purpose, &folder, &name, self.wake.clone()), since: Instant::now() }
        } else {
            By::Window(Box::new(PathEntry::new(&purpose, folder.clone(), name.clone())))
        };
        self.open = Some(Open { purpose, action, folder, name, by });
    }

    /// Whether a dialog is open.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Purpose and folder of the last answered dialog; once.
    pub fn left(&mut self) -> Option<(FileUse, PathBuf)> {
        self.left.take()
    }

    /// Shows the dialog. Returns the action with its path once there is an answer, one action per chosen file.
    pub fn show(&mut self, ctx: &Context) -> Vec<Action> {
        let Some(open) = &mut self.open else { return Vec::new() };
        let answer = match &mut open.by {
            By::Window(entry) => entry.show(ctx).map(|path| path.map(|p| vec![p])),
            By::System { answer, since } => match answer.try_recv() {
                Err(TryRecvError::Empty) => None,
                Ok(None) | Err(_) if since.elapsed() < FASTER_THAN_A_PERSON => {
                    self.system = false;
                    let entry = PathEntry::new(&open.purpose, open.folder.clone(), open.name.clone());
                    open.by = By::Window(Box::new(entry));
                    ctx.request_repaint();
                    None
                }
                Ok(paths) => Some(paths),
                Err(TryRecvError::Disconnected) => Some(None),
            },
        };
        let Some(paths) = answer else { return Vec::new() };
        let Some(open) = self.open.take() else { return Vec::new() };
        let paths = paths.unwrap_or_default();
        if let Some(first) = paths.first() {
            let folder = if first.is_dir() { absolute(first) } else { folder_of(first) };
            self.left = Some((open.purpose.files_for, folder));
        }
        paths.into_iter().map(|path| purpose::with_path(&open.action, open.purpose.with_extension(path))).collect()
    }
}

/// Dialogs come over the session bus on Linux; without it nobody would answer.
fn system_has_dialogs() -> bool {
    if cfg!(any(windows, target_os = "macos")) {
        return true;
    }
    let bus = std::env::var_os("DBUS_SESSION_BUS_ADDRESS").is_some_and(|address| !address.is_empty());
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    bus || runtime.is_some_and(|folder| folder.join("bus").exists())
}

fn home() -> PathBuf {
    let home = std::env::var_os("HOME").or_else(|| std::env::var_os("USERPROFILE")).map(PathBuf::from);
    home.filter(|h| h.is_dir()).or_else(|| std::env::current_dir().ok()).unwrap_or_else(|| PathBuf::from("."))
}

fn ask_system(purpose: &Purpose, folder: &Path, name: &str, wake: Wake) -> Receiver<Option<Vec<PathBuf>>> {
    let (sender, receiver) = channel();
    let mut dialog = rfd::FileDialog::new().set_title(purpose.title).set_directory(folder);
    if !purpose.extensions.is_empty() {
        dialog = dialog.add_filter(&purpose.files, &purpose.extensions);
    }
    if !name.is_empty() {
        dialog = dialog.set_file_name(name);
    }
    let mode = purpose.mode;
    let work = move || {
        let paths = match mode {
            Mode::Open => dialog.pick_file().map(|p| vec![p]),
            Mode::OpenMany => dialog.pick_files(),
            Mode::Save => dialog.save_file().map(|p| vec![p]),
            Mode::Folder => dialog.pick_folder().map(|p| vec![p]),
        };
        // A window that closed meanwhile needs no answer.
        let _ = sender.send(paths);
        wake();
    };
    // Without a thread the receiver is disconnected at once, and the window's own dialog opens.
    let _ = std::thread::Builder::new().name("file dialog".into()).spawn(work);
    receiver
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actions::{ExportAction, FileAction, MaterialAction};
    use std::sync::Arc;

    #[test]
    fn each_use_begins_where_it_was_left() {
        let folder = tempfile::tempdir().unwrap();
        let (scenes, textures) = (folder.path().join("scenes"), folder.path().join("textures"));
        [&scenes, &textures].into_iter().for_each(|f| std::fs::create_dir(f).unwrap());
        let mut last = LastFolders::default();
        last.remember(FileUse::Texture, &textures);
        last.remember(FileUse::Picture, &folder.path().join("gone"));
        let begins = |action: Action| {
            let mut dialogs = FileDialogs::new(Arc::new(|| ()), false);
            dialogs.ask(action, &last, Some(scenes.join("../scenes")), None);
            dialogs.open.unwrap().folder
        };
        assert_eq!(
            begins(Action::Material(MaterialAction::LoadTexture { material: 0, map: "bump", path: None })),
            textures
        );
        assert_eq!(begins(Action::File(FileAction::Open(None))), scenes, "negative control: nothing was opened yet");
        assert_eq!(begins(Action::Export(ExportAction::Picture(None))), scenes, "a folder that is gone");
    }
}
