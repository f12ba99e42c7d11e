//! Other materials of parts: one of the document, one of their own, those of a variant. None of it needs a bake.

use super::state::EditorState;
use crate::document::{
    Edit, in_place_of,
    parts::{Assignment, as_added},
};
use lapidary_core::{material::Material, parts::Part, scene::Scene};

impl EditorState {
    /// Gives a part another material of the document, as a step of undo.
    pub(super) fn assign(&mut self, part: Part, material: usize) {
        let is_there = material < self.work.document.materials.len();
        if !is_there || self.is_of_ground(part) || self.work.scene.ground_material() == Some(material) {
            return;
        }
        let assigned = self.work.document.assigning([(part, material)]);
        self.work.do_step(Edit::Assigned(assigned), "Material of a surface");
        self.show_part(part);
    }

    /// Gives a part a material that no other has: a copy of what it has, or `material`. One that no other has already takes the
    /// values.
    pub(super) fn make_unique(&mut self, part: Part, material: Option<Material>) {
        let index = self.work.document.material_of(part);
        let Some(present) = self.work.document.materials.get(index).cloned().filter(|_| !self.is_of_ground(part))
        else {
            return;
        };
        let material = material.unwrap_or_else(|| present.clone());
        let of_all = self.work.bounds.parts.iter();
        let edit = if of_all.filter(|other| self.work.document.material_of(**other) == index).count() > 1 {
            let added = Material { double_sided: present.double_sided, ..as_added(&self.work.document, material) };
            let assigned = self.work.document.assigning([(part, self.work.document.materials.len())]);
            Edit::Added { material: Some(added.into()), assigned }
        } else {
            Edit::Material { index, material: in_place_of(&present, material).into() }
        };
        self.work.do_step(edit, "Material of its own");
        self.show_part(part);
    }

    /// Shows a variant, or what the file shows first; materials of other parts stay.
    pub(super) fn choose_variant(&mut self, variant: Option<usize>) {
        let Some(assigned) =
            self.work.scene.rendered().map(|baked| self.assigning_variant(&baked.dataset.scene, variant))
        else {
            return;
        };
        self.work.do_step(Edit::Assigned(assigned), "Variant");
        self.work.selection.part.into_iter().for_each(|part| self.show_part(part));
    }

    fn assigning_variant(&self, scene: &Scene, variant: Option<usize>) -> Assignment {
        let variant = variant.filter(|&variant| variant < scene.variants.names.len());
        self.work.document.assigning(scene.variants.shown(variant).map(|(part, material)| (part, material as usize)))
    }

    fn show_part(&mut self, part: Part) {
        self.work.selection.part = Some(part);
        self.work.selection.material = Some(self.work.document.material_of(part));
    }

    /// A ground has the material that its bake gave it, and no other surface has that.
    fn is_of_ground(&self, part: Part) -> bool {
        self.work.scene.ground_object() == Some(part.object)
    }
}
