//! Poses of objects: by the document, by handles, and by the time of an animation.

mod cache;
mod handles;
mod play;
pub mod timeline;

use crate::{
    document::Document,
    viewport::gizmo::{Pivot, Tool},
};
use cache::PoseCache;
use lapidary_core::{animation::Animation, scene::pose::Poses};
use lapidary_render::Baked;
use std::sync::Arc;
use timeline::Timeline;

/// How objects are posed.
#[derive(Default)]
pub struct Posing {
    /// The tool of the handles; `None` shows no handles.
    pub tool: Option<Tool>,
    /// The pivot about which several objects turn and scale.
    pub pivot: Pivot,
    /// Whether the next click into the viewport places the pivot of the active object.
    pub placing_pivot: bool,
    /// Objects that are hidden since others were isolated, and the names of all objects then.
    isolated: (Vec<u32>, Vec<String>),
    /// How clips play.
    pub timeline: Timeline,
    cache: PoseCache,
}

impl Posing {
    /// Objects that are hidden since others were isolated; none once one of them is shown, or the scene has other objects.
    pub fn isolated(&self, document: &Document) -> &[u32] {
        let (hidden, names) = &self.isolated;
        let holds = *names == document.objects && hidden.iter().all(|&object| document.poses.of(object).hidden);
        if holds { hidden } else { &[] }
    }

    /// Another document is open.
    pub fn forget_document(&mut self) {
        (self.timeline.playing, self.placing_pivot) = (false, false);
        self.isolated = Default::default();
    }
}

/// Poses of a document relative to a bake: its own, and those of its animation at its time. Objects without a pose at that time
/// stay as baked.
pub fn poses_since(document: &Document, animation: Option<&Arc<Animation>>, baked: &Baked) -> Poses {
    PoseCache::default().poses_since(document, animation, baked)
}
