//! Opens, saves and leaves documents, asks the questions on the way, and searches for missing files.

use super::state::{
    EditorState,
    prompt::{Again, Prompt, Then},
};
use crate::{
    actions::{Action, FileAction},
    bake::{Asker, BakeOrder, From},
    document::{History, session},
    jobs::opening::{Opened, Ready, Target},
    ladder::LadderWindow,
    workspace::{OpenScene, Selection, Written, first_view::FirstView},
};
use egui::{Context, ViewportCommand};
use lapidary_precompute::Leftover;
use std::path::{Path, PathBuf};

impl EditorState {
    /// Closes the window after asking about changes.
    pub(super) fn quit(&mut self, ctx: &Context) {
        if self.work.history.is_modified() {
            self.questions.ask(Prompt::Unsaved { then: Then::Quit });
        } else {
            self.leave_now(ctx, Then::Quit);
        }
    }

    /// Leaves the document without asking.
    pub(super) fn leave_now(&mut self, ctx: &Context, then: Then) {
        match then {
            Then::Show(ready) => self.take_document(*ready),
            Then::Quit => {
                self.questions.may_close = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }

    /// Opens one of the scenes that come with the program.
    pub fn open_bundled(&mut self, index: usize) {
        match self.bundled.scenes.get(index).cloned() {
            Some(scene) => self.open(Target::Bundled(scene)),
            None => self
                .work
                .messages
                .error("Bundled scene not found; start with --data DIR, set LAPIDARY_DATA, or open another scene"),
        }
    }

    pub(super) fn save(&mut self, ctx: &Context) {
        match self.work.scene.session.clone() {
            Some(path) => self.save_to(ctx, &path),
            None => self.ask_for_path(Action::File(FileAction::SaveAs(None))),
        }
    }

    pub(super) fn save_to(&mut self, ctx: &Context, path: &Path) {
        if !self.work.may_write(path, Written::Session) {
            self.questions.after_save = None;
            return;
        }
        if let Err(error) = session::save(&self.work.document, &self.work.scene.unknown, path) {
            self.questions.after_save = None;
            return self.work.messages.error(error.to_string());
        }
        self.work.history.mark_saved();
        self.safe.forget_autosave(&mut self.work);
        self.safe.forget_recovered(&mut self.work);
        self.work.scene.session = Some(path.to_owned());
        self.remember(path);
        self.work.messages.note(format!("Saved ({})", path.display()));
        if let Some(then) = self.questions.after_save.take() {
            self.leave_now(ctx, then);
        }
    }

    pub(super) fn remember(&mut self, path: &Path) {
        if let Err(error) = self.recent.add(path) {
            self.work.messages.warning(format!("{error:#}"));
        }
    }

    pub(super) fn forget_recent(&mut self, path: &Path) {
        self.work.messages.warning(format!("File not found; it was removed from the list ({})", path.display()));
        if let Err(error) = self.recent.remove(path) {
            self.work.messages.warning(format!("{error:#}"));
        }
    }

    pub(super) fn collect_opened(&mut self) {
        let Some(result) = self.opening.as_ref().and_then(|opening| opening.poll()) else { return };
        self.opening = None;
        match result {
            Ok(Opened::Ready(ready)) if self.work.history.is_modified() => {
                self.questions.ask(Prompt::Unsaved { then: Then::Show(ready) });
            }
            Ok(Opened::Ready(ready)) => self.take_document(*ready),
            Ok(Opened::Missing { loaded, path, recovery, found }) => {
                if let Some(found) = found {
                    let missing = loaded.missing.len();
                    self.work.messages.note(format!("Found {found} files; {missing} still missing"));
                }
                self.questions.ask(Prompt::Missing { loaded, path, recovery });
            }
            Ok(Opened::Outside { target, scene, names }) => {
                self.questions.ask(Prompt::Outside { file: scene, names, then: Again::Open(*target) });
            }
            Err(error) => self.work.messages.error(error),
        }
    }

    fn take_document(&mut self, ready: Ready) {
        let Ready {
            document,
            unknown,
            session,
            recovery,
            baked,
            preview,
            source,
            animation,
            bake_output,
            kept_output,
            lacks_bake,
            is_draft,
            warnings,
            recent,
        } = ready;
        self.safe.forget_autosave(&mut self.work);
        self.baking.clear();
        self.ladder = LadderWindow::default();
        self.loader.forget_document();
        self.work.document = document;
        self.work.history = if recovery.is_some() { History::unsaved() } else { History::new() };
        self.safe.recovered = recovery;
        // Sessions and recovered work keep their cameras.
        let is_kept = session.is_some() || self.safe.recovered.is_some();
        let first_view = Some(FirstView::of(&self.work.document, is_kept));
        let show_stale = false;
        self.work.scene = OpenScene {
            baked,
            preview,
            source,
            animation,
            bake_output,
            kept_output,
            is_draft,
            show_stale,
            session,
            unknown,
            first_view,
        };
        self.stop_waiting_for_clicks();
        self.pose.forget_document();
        self.interface.scene.forget_document();
        self.lights.forget_document();
        self.materials.forget_document();
        self.work.selection =
            Selection { material: (!self.work.document.materials.is_empty()).then_some(0), ..Selection::default() };
        self.reset_camera();
        self.picture.clear();
        self.picture.requests.forget();
        let name = self.work.title();
        self.work.messages.warnings(&name, &warnings);
        self.work.drop_lost_clip();
        recent.into_iter().for_each(|path| self.remember(&path));
        if lacks_bake && self.work.preferences.bakes_scenes && self.work.scene.source.is_some() {
            let (has_draft, has_chunks) =
                (self.work.scene.baked.is_some(), self.baking.leftover(&self.work) == Leftover::Fitting);
            let from = if has_draft && has_chunks { From::Checkpoint } else { From::Beginning };
            self.baking.bake(&mut self.work, BakeOrder { asked_by: Asker::Nobody, from, draft_first: !has_draft });
        }
    }

    /// Searches for the missing files of the waiting session.
    pub(super) fn relink(&mut self, folder: PathBuf) {
        match self.questions.waiting.pop_front() {
            Some(Prompt::Missing { loaded, path, recovery }) => {
                self.open(Target::Session { loaded, path, recovery, look_in: Some(folder) });
            }
            other => {
                other.into_iter().for_each(|prompt| self.questions.waiting.push_front(prompt));
                self.environments.relink_library(&mut self.work, &folder);
            }
        }
    }
}
