//! Kept bakes: writes an automatic bake where the user wants it, keeps drafts for the next start, and limits how many stay.

use super::{
    stale::stale_now,
    state::{Baking, Run},
};
use crate::{
    jobs::kept_bakes::{self, draft_of, kept_in},
    workspace::{Workspace, Written},
};
use lapidary_core::dataset::{BakeSettings, Dataset};
use lapidary_studies::jobs::spawn;
use std::sync::{Arc, mpsc::channel};

impl Baking {
    /// Writes the shown bake where the user wants it, if another bake would give the same. Returns whether it would.
    pub fn write_kept(&mut self, work: &mut Workspace) -> bool {
        let is_elsewhere = work.scene.kept_output != work.scene.bake_output && work.document.dataset.is_none();
        let is_elsewhere = is_elsewhere || self.is_unwritten;
        let whole = work.scene.shown().filter(|_| is_elsewhere && !work.scene.is_draft && stale_now(work).is_empty());
        let Some((whole, output)) = whole.cloned().zip(work.scene.bake_output.clone()) else { return false };
        if work.may_write(&output, Written::Dataset) {
            let (sender, written) = channel();
            self.written = Some(written);
            // The document decides how a ground is shown.
            let settings = BakeSettings { ground: work.document.bake.ground, ..whole.dataset.settings.clone() };
            let wake = work.wake.clone();
            spawn("write the bake", move || {
                // Fails only if another scene was opened.
                let _ = sender.send(
                    whole.dataset.write_as(&output, &settings).map(|()| output).map_err(|error| error.to_string()),
                );
                wake();
            });
        }
        true
    }

    /// Reports a written bake.
    pub fn collect_written(&mut self, work: &mut Workspace) {
        let Some(written) = self.written.as_ref().and_then(|written| written.try_recv().ok()) else { return };
        self.written = None;
        match written {
            Ok(output) => {
                work.messages.note(format!("Bake written ({})", output.display()));
                work.document.dataset = Some(output);
                self.is_unwritten = false;
            }
            Err(error) => work.messages.error(error),
        }
    }
}

/// Reports a finished bake, and remembers its file if the user asked for it.
pub fn note_bake(work: &mut Workspace, run: &Run, vertices: usize) {
    work.messages.note(format!("Baked {vertices} vertices in {:.0} s", run.job.elapsed_secs()));
    if work.scene.bake_output.as_ref() == Some(&run.output) {
        work.document.dataset = Some(run.output.clone());
    }
    let (folder, latest) = (work.folders.bakes(), run.output.clone());
    if latest.starts_with(&folder) {
        spawn("kept bakes", move || {
            // A draft that cannot be removed ages like the others.
            let _ = std::fs::remove_file(draft_of(&latest));
            kept_bakes::remove_oldest(&folder, &latest, kept_bakes::MOST_BYTES);
        });
    }
}

/// Keeps the draft for the next start, in case the bake is not finished by then.
pub fn keep_draft(work: &Workspace, dataset: &Arc<Dataset>) {
    let Some(scene) = &work.document.scene else { return };
    // Named after the scene as it was when the bake began.
    let path = draft_of(&kept_in(&work.folders.bakes(), scene, &dataset.scene_hash));
    let dataset = dataset.clone();
    spawn("keep draft", move || {
        // Without it the next start bakes a draft again.
        let _ = path.parent().map(std::fs::create_dir_all);
        let _ = dataset.write(&path);
    });
}
