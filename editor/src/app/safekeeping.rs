//! Writes the autosave now and then, and removes it once the document is saved.

use crate::{
    document::autosave::{Autosave, Recovery},
    workspace::Workspace,
};
use egui::Context;
use std::time::{Duration, Instant};

/// Seconds between two autosaves.
const INTERVAL: Duration = Duration::from_secs(20);

/// The autosave of the document that is open.
pub struct Safekeeping {
    autosave: Autosave,
    /// Revision of the document that was written last.
    autosaved: u64,
    /// The autosave that the document was recovered from, until it is saved.
    pub recovered: Option<Recovery>,
}

impl Safekeeping {
    /// With nothing to keep yet, in the state folder.
    pub fn new(work: &Workspace) -> Self {
        Self { autosave: Autosave::new(&work.folders.state, INTERVAL), autosaved: 0, recovered: None }
    }

    /// Writes the autosave when due, and requests a frame for the next.
    pub fn keep(&mut self, work: &mut Workspace, ctx: &Context) {
        let session = work.scene.session.as_deref();
        let tick = self.autosave.tick(Instant::now(), &work.document, &work.history, &work.scene.unknown, session);
        match tick {
            Ok(true) => {
                self.autosaved = work.history.revision();
                self.forget_recovered(work);
            }
            Ok(false) => {}
            Err(error) => work.messages.error(format!("Autosave failed: {error}")),
        }
        if work.history.is_modified() && self.autosaved != work.history.revision() {
            ctx.request_repaint_after(INTERVAL);
        }
    }

    /// Removes the autosave of recovered work that is now saved.
    pub fn forget_recovered(&mut self, work: &mut Workspace) {
        if let Some(recovered) = self.recovered.take()
            && let Err(error) = recovered.discard()
        {
            work.messages.warning(format!("Cannot remove an autosave: {error}"));
        }
    }

    /// Begins with another document.
    pub fn forget_autosave(&mut self, work: &mut Workspace) {
        if let Err(error) = self.autosave.finish() {
            work.messages.warning(error.to_string());
        }
        self.autosaved = 0;
    }
}
