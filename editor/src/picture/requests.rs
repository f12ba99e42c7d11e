//! The last request to the render thread.

use crate::{
    document::{Document, parts::Assignment},
    jobs::render_thread::RenderRequest,
};
use lapidary_render::{Assigned, Baked};
use std::cell::RefCell;

/// The last request.
#[derive(Default)]
pub struct Requests {
    /// The request as sent.
    pub sent: Option<RenderRequest>,
    /// Send the next one even if it is the same.
    pub is_forgotten: bool,
    /// Revision of the document when no button was last held.
    pub at_rest: u64,
    /// The last materials of triangles.
    assigned: RefCell<Option<Found>>,
}

/// The materials of all triangles and their inputs, kept since they take a pass over the mesh.
struct Found {
    baked: Baked,
    assignment: Assignment,
    materials: [usize; 2],
    assigned: Assigned,
}

impl Requests {
    /// The materials of a dataset's triangles in a document.
    pub fn assigned(&self, document: &Document, baked: &Baked) -> Assigned {
        let mut found = self.assigned.borrow_mut();
        let materials = [document.materials.len(), document.added];
        let holds = |found: &Found| {
            found.baked.is_same(baked) && found.materials == materials && found.assignment == document.assigned
        };
        if !found.as_ref().is_some_and(holds) {
            let assigned = document.assigned_to(&baked.dataset.scene.mesh);
            let assignment = document.assigned.clone();
            *found = Some(Found { baked: baked.clone(), assignment, materials, assigned });
        }
        found.as_ref().and_then(|found| found.assigned.clone())
    }

    /// The last request to the render thread.
    pub fn last_sent(&self) -> Option<&RenderRequest> {
        self.sent.as_ref()
    }

    /// Sends the next request even if it equals the last one: the scene was replaced in place.
    pub fn forget(&mut self) {
        self.is_forgotten = true;
    }
}
