//! The selected objects that can be posed, and their handles.

use super::Posing;
use crate::{
    document::{Edit, handling::PlacedPivot},
    viewport::gizmo::{Movable, Subject, Tool},
    workspace::Workspace,
};
use lapidary_studies::sequence::Spin;

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

    /// Places the pivot of the active object, given in the world, and shows the rings about it.
    pub(super) fn place_pivot(&mut self, work: &mut Workspace, pivot: Option<PlacedPivot>) {
        self.placing_pivot = false;
        let (Some(pivot), Some(&Subject { object, center, .. })) = (pivot, self.posable(work).first()) else { return };
        let pose = work.document.poses.of(object);
        let own = PlacedPivot {
            point: pose.world_from_baked(center).inverse().transform_point3(pivot.point),
            hinge: pivot.hinge.map(|hinge| (pose.rotation().inverse() * hinge).normalize()),
        };
        let handling = work.document.with_handling([object], |handling| handling.pivot = Some(own));
        work.do_step(Edit::Handling(handling), "Place pivot");
        self.tool = Some(Tool::Turn);
    }

    /// Shows objects alone, or those again that this hid.
    pub(super) fn isolate(&mut self, work: &mut Workspace, alone: &[u32]) {
        let document = &work.document;
        let hidden = self.isolated(document).to_vec();
        let (objects, hides) = if hidden.is_empty() {
            let ground = work.scene.ground_object();
            let is_other =
                |object: &u32| !alone.contains(object) && Some(*object) != ground && !document.poses.of(*object).hidden;
            let others = (0..document.objects.len() as u32).filter(is_other);
            (if alone.is_empty() { Vec::new() } else { others.collect() }, true)
        } else {
            (hidden, false)
        };
        self.isolated = if hides { (objects.clone(), document.objects.clone()) } else { Default::default() };
        if !objects.is_empty() {
            let edit = document.hiding(objects, hides);
            work.do_step(edit, if hides { "Hide" } else { "Show" });
        }
    }

    /// The active object, which may turn alone about its pivot, and its name.
    pub fn spin(&self, work: &Workspace) -> Option<(String, Spin)> {
        let (document, active) = (&work.document, *self.posable(work).first()?);
        let center = self.cache.objects(work.scene.rendered()?).center(active.object);
        let spin = Spin { object: active.object, center, pivot: active.place(&document.poses) };
        Some((document.object_name(active.object).to_owned(), spin))
    }

    /// The selected objects that can be posed, the active one first; none if the active one cannot be, as a ground or a locked one.
    pub fn posable(&self, work: &Workspace) -> Vec<Subject> {
        let Some(baked) = work.scene.rendered() else { return Vec::new() };
        let can_be_posed =
            |object: u32| (object as usize) < work.document.objects.len() && work.scene.ground_object() != Some(object);
        let poses = self.poses_since(work, baked);
        let subject = |object: u32| {
            let handling = work.document.handling_of(object);
            let found = self.cache.subject(baked, &poses, object);
            let found = found.filter(|_| can_be_posed(object) && !handling.locked)?;
            Some(match handling.pivot {
                Some(PlacedPivot { point, hinge }) => Subject { middle: point, hinge, ..found },
                None => found,
            })
        };
        let Some(active) = work.selection.object.and_then(subject) else { return Vec::new() };
        [active].into_iter().chain(work.selection.others.iter().filter_map(|&object| subject(object))).collect()
    }
}
