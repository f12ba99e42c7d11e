//! What the render thread was asked for last.

use crate::jobs::render_thread::RenderRequest;

/// What was asked for last.
#[derive(Default)]
pub struct Requests {
    pub(in crate::app) sent: Option<RenderRequest>,
    /// The next one is sent even if it is the same.
    pub(in crate::app) is_forgotten: bool,
    /// Revision of the document when no button was held.
    pub(in crate::app) at_rest: u64,
}

impl Requests {
    /// What the render thread was asked for last.
    pub fn last_sent(&self) -> Option<&RenderRequest> {
        self.sent.as_ref()
    }

    /// Sends the next request even if it is that of before: the scene was replaced in place.
    pub fn forget(&mut self) {
        self.is_forgotten = true;
    }
}
