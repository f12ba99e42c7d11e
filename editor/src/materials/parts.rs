//! Assigns materials to parts: another of the document, their own, a variant's. None of it needs a bake.

use crate::{
    document::{
        Edit, in_place_of,
        parts::{Assignment, as_added},
    },
    workspace::Workspace,
};
use lapidary_core::{material::Material, parts::Part, scene::Scene};

/// Gives a part another material of the document, as a step of undo.
pub fn assign(work: &mut Workspace, part: Part, material: usize) {
    let is_there = material < work.document.materials.len();
    if !is_there || is_of_ground(work, part) || work.scene.ground_material() == Some(material) {
        return;
    }
    let assigned = work.document.assigning([(part, material)]);
    work.do_step(Edit::Assigned(assigned), "Assign material");
    show_part(work, part);
}

/// Gives a part its own material: a copy of its present one, or `material`. If it has its own already, that takes the values.
pub fn make_unique(work: &mut Workspace, part: Part, material: Option<Material>) {
    let index = work.document.material_of(part);
    let Some(present) = work.document.materials.get(index).cloned().filter(|_| !is_of_ground(work, part)) else {
        return;
    };
    let material = material.unwrap_or_else(|| present.clone());
    let of_all = work.bounds.parts.iter();
    let edit = if of_all.filter(|other| work.document.material_of(**other) == index).count() > 1 {
        let added = Material { double_sided: present.double_sided, ..as_added(&work.document, material) };
        let assigned = work.document.assigning([(part, work.document.materials.len())]);
        Edit::Added { material: Some(added.into()), assigned }
    } else {
        Edit::Material { index, material: in_place_of(&present, material).into() }
    };
    work.do_step(edit, "Make unique");
    show_part(work, part);
}

/// Shows a variant, or the file's default; materials of other parts stay.
pub fn choose_variant(work: &mut Workspace, variant: Option<usize>) {
    let Some(assigned) = work.scene.rendered().map(|baked| assigning_variant(work, &baked.dataset.scene, variant))
    else {
        return;
    };
    work.do_step(Edit::Assigned(assigned), "Variant");
    work.selection.part.into_iter().for_each(|part| show_part(work, part));
}

fn assigning_variant(work: &Workspace, scene: &Scene, variant: Option<usize>) -> Assignment {
    let variant = variant.filter(|&variant| variant < scene.variants.names.len());
    work.document.assigning(scene.variants.shown(variant).map(|(part, material)| (part, material as usize)))
}

fn show_part(work: &mut Workspace, part: Part) {
    work.selection.part = Some(part);
    work.selection.material = Some(work.document.material_of(part));
}

/// A ground keeps its material, and no other surface can have it.
fn is_of_ground(work: &Workspace, part: Part) -> bool {
    work.scene.ground_object() == Some(part.object)
}
