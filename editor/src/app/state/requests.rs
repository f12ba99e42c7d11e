//! The last request to the render thread.

use crate::jobs::render_thread::RenderRequest;

/// The last request.
#[derive(Default)]
pub struct Requests {
    pub(in crate::app) sent: Option<RenderRequest>,
    /// The next one is sent even if it is the same.
    pub(in crate::app) is_forgotten: bool,
    /// Revision of the document when no button was held.
    pub(in crate::app) at_rest: u64,
}

impl Requests {
    /// The last request to the render thread.
    pub fn last_sent(&self) -> Option<&RenderRequest> {
        self.sent.as_ref()
    }

    /// Sends the next request even if it equals the last one: the scene was replaced in place.
    pub fn forget(&mut self) {
        self.is_forgotten = true;
    }
}
