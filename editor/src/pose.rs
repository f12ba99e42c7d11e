//! Poses of objects: by the document, by handles, and by the time of an animation.

mod cache;
mod handles;
mod play;
pub mod timeline;

use crate::viewport::gizmo::{Pivot, Tool};
use cache::PoseCache;
use timeline::Timeline;

/// How objects are posed.
#[derive(Default)]
pub struct Posing {
    /// The tool of the handles; `None` shows no handles.
    pub tool: Option<Tool>,
    /// The pivot about which several objects turn and scale.
    pub pivot: Pivot,
    /// How clips play.
    pub timeline: Timeline,
    cache: PoseCache,
}
