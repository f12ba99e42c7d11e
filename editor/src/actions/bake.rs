//! Requests about bakes.

use lapidary_core::camera::Camera;
use lapidary_core::dataset::BakeParts;

/// A request about bakes.
#[derive(Clone, Debug)]
pub enum BakeAction {
    /// Bake the scene with the document's settings; with `resume` from its checkpoint.
    Begin {
        /// Go on from the checkpoint.
        resume: bool,
    },
    /// Stop the bake; its checkpoint stays.
    Cancel,
    /// Choose what the next bake is of, and show its settings.
    Choose(BakeParts),
    /// Choose the views that the next bake is for, at the size of the viewport now; an empty list serves all views
    /// alike.
    ForViews(Vec<Camera>),
}
