//! The selected objects that can be posed, and their handles.

use super::Posing;
use crate::{
    viewport::gizmo::{Movable, Subject},
    workspace::Workspace,
};

impl Posing {
    /// The selected objects, if they have handles: none for a ground or a hidden object, or while a light is selected.
    pub fn movable(&self, work: &Workspace) -> Option<Movable> {
        let tool = self.tool.filter(|_| work.selected_light().is_none())?;
        let posable = self.posable(work);
        let (&active, others) = posable.split_first()?;
        let is_shown = |subject: &Subject| !work.document.poses.of(subject.object).hidden;
        let others = others.iter().copied().filter(is_shown).collect();
        is_shown(&active).then_some(Movable { active, others, pivot: self.pivot, tool })
    }

    /// The selected objects that can be posed, the active one first; none if the active one cannot be, as a ground.
    pub fn posable(&self, work: &Workspace) -> Vec<Subject> {
        let Some(baked) = work.scene.rendered() else { return Vec::new() };
        let can_be_posed =
            |object: u32| (object as usize) < work.document.objects.len() && work.scene.ground_object() != Some(object);
        let poses = self.poses_since(work, baked);
        let subject = |object: u32| self.cache.subject(baked, &poses, object).filter(|_| can_be_posed(object));
        let Some(active) = work.selection.object.and_then(subject) else { return Vec::new() };
        [active].into_iter().chain(work.selection.others.iter().filter_map(|&object| subject(object))).collect()
    }
}
