//! The selection.

use super::{Inspector, Workspace};
use crate::{actions::SelectAction, document::objects::ObjectNumbers};
use lapidary_core::parts::Part;

/// The selection.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// The active object of the mesh: the one selected last, which panels show.
    pub object: Option<u32>,
    /// Objects that move along with it, in order of selection; none without an active one.
    pub others: Vec<u32>,
    /// A part of the active object, or of the object selected before the material.
    pub part: Option<Part>,
    /// A material.
    pub material: Option<usize>,
    /// A local light; undo may have removed it, see [`Workspace::selected_light`].
    pub light: Option<usize>,
}

impl Selection {
    /// All selected objects, the active one first.
    pub fn objects(&self) -> impl Iterator<Item = u32> {
        self.object.into_iter().chain(self.others.iter().copied())
    }

    /// Selects an object alone, or none.
    pub fn set_object(&mut self, object: Option<u32>) {
        self.object = object;
        self.others.clear();
    }

    /// Adds an object, which becomes the active one, or removes it. After a removal the object selected before becomes active.
    pub fn toggle_object(&mut self, object: u32) {
        if self.object == Some(object) {
            self.object = self.others.pop();
        } else if let Some(place) = self.others.iter().position(|&other| other == object) {
            self.others.remove(place);
        } else {
            self.others.extend(self.object.replace(object));
        }
    }

    /// Keeps only objects that fulfill a condition.
    pub fn retain_objects(&mut self, mut is_kept: impl FnMut(u32) -> bool) {
        self.others.retain(|&other| is_kept(other));
        self.object = self.object.filter(|&object| is_kept(object)).or_else(|| self.others.pop());
    }

    /// Renumbers objects, and drops deleted ones.
    pub fn renumber_objects(&mut self, numbers: &ObjectNumbers) {
        self.retain_objects(|object| numbers.of(object).is_some());
        self.object
            .iter_mut()
            .chain(&mut self.others)
            .for_each(|object| *object = numbers.of(*object).unwrap_or(*object));
        self.part = self.part.and_then(|part| numbers.of_part(part));
    }
}

impl Workspace {
    /// Performs an action.
    pub fn perform_select(&mut self, action: SelectAction) {
        match action {
            SelectAction::Object(object) => self.select_object(object),
            SelectAction::Toggle(object) => self.toggle_object(object),
            SelectAction::Material(material) => self.select_material(material),
            SelectAction::Part(part) => self.selection.part = Some(part),
        }
    }

    /// Selects an object alone, and with it the part and the material of its first triangle.
    pub fn select_object(&mut self, object: Option<u32>) {
        self.selection.set_object(object);
        self.show_active_object();
    }

    /// Adds an object to the selection, or removes it. A ground, which cannot be moved, is only selected alone.
    pub fn toggle_object(&mut self, object: u32) {
        let ground = self.scene.ground_object();
        if ground == Some(object) {
            self.messages.remark("The ground cannot move, and can only be selected alone");
            return;
        }
        self.selection.retain_objects(|selected| Some(selected) != ground);
        self.selection.toggle_object(object);
        self.show_active_object();
    }

    /// Selects the part and the material of the active object's first triangle.
    fn show_active_object(&mut self) {
        (self.selection.part, self.selection.light) = (None, None);
        let Some((object, baked)) = self.selection.object.zip(self.scene.rendered()) else { return };
        let mesh = &baked.dataset.scene.mesh;
        let first = mesh.triangle_object.iter().position(|&o| o == object);
        if let Some(part) = first.and_then(|triangle| Part::of_triangle(mesh, triangle)) {
            self.selection.part = Some(part);
            self.selection.material = Some(self.document.material_of(part));
            self.tabs.inspector = Inspector::Material;
        }
    }

    /// Selects a material, or none.
    pub fn select_material(&mut self, material: Option<usize>) {
        self.selection.material = material;
        if material.is_some() {
            self.tabs.inspector = Inspector::Material;
        }
    }

    /// The selected light, if it exists.
    pub fn selected_light(&self) -> Option<usize> {
        self.selection.light.filter(|&index| index < self.document.lights.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selected(selection: &Selection) -> Vec<u32> {
        selection.objects().collect()
    }

    #[test]
    fn objects_are_added_and_taken_away_and_the_last_one_is_active() {
        let mut selection = Selection::default();
        let mut toggled = |object| {
            selection.toggle_object(object);
            selected(&selection)
        };
        assert_eq!([toggled(4), toggled(2), toggled(7)], [vec![4], vec![2, 4], vec![7, 4, 2]]);
        assert_eq!(toggled(4), [7, 2], "one of the others");
        assert_eq!([toggled(7), toggled(2)], [vec![2], vec![]], "the active one");
        selection = Selection { object: Some(1), others: vec![2, 3], ..Selection::default() };
        selection.set_object(Some(2));
        assert_eq!(selected(&selection), [2]);
    }

    #[test]
    fn a_selection_follows_its_objects_to_other_numbers() {
        let part = |object| Some(Part { object, material: 1 });
        let mut selection = Selection { object: Some(2), others: vec![1, 0], part: part(2), ..Selection::default() };
        let renumbered = |selection: &mut Selection, before: &[&str], now: &[&str]| {
            let [before, now] = [before, now].map(|names| names.iter().copied().map(String::from).collect::<Vec<_>>());
            selection.renumber_objects(&ObjectNumbers::between(&before, &now));
            (selected(selection), selection.part)
        };
        let moved = renumbered(&mut selection, &["floor", "lid", "pot"], &["rug", "pot", "floor", "lid"]);
        assert_eq!(moved, (vec![1, 3, 2], part(1)));
        let fewer = renumbered(&mut selection, &["rug", "pot", "floor", "lid"], &["lid", "floor"]);
        assert_eq!(fewer, (vec![1, 0], None), "the pot is gone, and the floor was selected after the lid");
    }

    #[test]
    fn objects_that_are_gone_leave_the_selection() {
        let mut selection = Selection { object: Some(9), others: vec![1, 8, 3], ..Selection::default() };
        selection.retain_objects(|object| object < 10);
        assert_eq!(selected(&selection), [9, 1, 8, 3], "negative control");
        selection.retain_objects(|object| object < 8);
        assert_eq!(selected(&selection), [3, 1]);
        selection.retain_objects(|_| false);
        assert!(selected(&selection).is_empty());
    }
}
