//! The autosave: the document is written aside now and then, and what is written elsewhere is removed.

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
    /// The autosave that the document was recovered from, until it is written elsewhere.
    pub recovered: Option<Recovery>,
}

impl Safekeeping {
    /// With nothing to keep in the folder of the state.
    pub fn new(work: &Workspace) -> Self {
        Self { autosave: Autosave::new(&work.folders.state, INTERVAL), autosaved: 0, recovered: None }
    }

    /// Writes the document aside when it is time, and comes back for it.
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

    /// Recovered work is written elsewhere by now.
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
