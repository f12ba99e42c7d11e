//! Edits: a value to swap in. Swapping leaves the old value in the edit, which is then its inverse.

use super::{
    ComponentSettings, Document, EnvironmentSettings, ViewSettings,
    handling::{self, HandlingOfObjects},
    looks::{LookState, NamedLook},
    objects::ObjectNumbers,
    parts::{Assignment, Renumbering, renumber},
};
use lapidary_core::{camera::Camera, dataset::BakeSettings, lights::Light, material::Material, scene::pose::Pose};
use lapidary_render::Solution;
use std::{
    collections::BTreeMap,
    mem::{discriminant, swap, take},
};

/// One change to a document.
#[derive(Clone, Debug)]
pub enum Edit {
    /// Another value for a material.
    Material {
        /// Which.
        index: usize,
        /// Its new value.
        material: Box<Material>,
    },
    /// Other materials for parts.
    Assigned(Assignment),
    /// Adds a material or removes the last added one, with other materials for parts.
    Added {
        /// The new material; `None` to take one away.
        material: Option<Box<Material>>,
        /// The materials of parts with it, or without it.
        assigned: Assignment,
    },
    /// Other poses of objects, by index.
    Poses(BTreeMap<u32, Pose>),
    /// Objects that are handled otherwise.
    Handling(HandlingOfObjects),
    /// Another environment.
    Environment(EnvironmentSettings),
    /// Another value for a local light.
    Light {
        /// Which.
        index: usize,
        /// Its new value.
        light: Box<Light>,
    },
    /// Other local lights: more, fewer, or in another order.
    Lights(Vec<Light>),
    /// Other switches of the parts of the light.
    Components(ComponentSettings),
    /// Another way to compute bounced light.
    Solution(Solution),
    /// Other view settings.
    View(ViewSettings),
    /// Other bookmarks.
    Bookmarks(Vec<Camera>),
    /// What a look shows, or a part of it.
    Look(Box<LookState>),
    /// Other looks.
    Looks(Vec<NamedLook>),
    /// Other settings for the next bake.
    Bake(Box<BakeSettings>),
}

impl Edit {
    /// Puts the edit's value into the document, and the document's into the edit.
    ///
    /// # Panics
    /// If it names a material or a light, or takes away a material, that the document does not have.
    pub fn swap(&mut self, document: &mut Document) {
        match self {
            Self::Material { index, material } => swap(&mut **material, &mut document.materials[*index]),
            Self::Assigned(assigned) => swap(assigned, &mut document.assigned),
            Self::Added { material, assigned } => {
                swap(assigned, &mut document.assigned);
                *material = swap_last(material.take(), document);
            }
            Self::Poses(poses) => {
                poses.iter_mut().for_each(|(&object, pose)| *pose = document.poses.replace(object, *pose));
            }
            Self::Handling(handling) => swap(handling, &mut document.handling),
            Self::Environment(environment) => swap(environment, &mut document.environment),
            Self::Light { index, light } => swap(&mut **light, &mut document.lights[*index]),
            Self::Lights(lights) => swap(lights, &mut document.lights),
            Self::Components(components) => swap(components, &mut document.components),
            Self::Solution(solution) => swap(solution, &mut document.solution),
            Self::View(view) => swap(view, &mut document.view),
            Self::Bookmarks(bookmarks) => swap(bookmarks, &mut document.bookmarks),
            Self::Look(state) => state.swap(document),
            Self::Looks(looks) => swap(looks, &mut document.looks),
            Self::Bake(bake) => swap(&mut **bake, &mut document.bake),
        }
    }

    /// Whether the document has the value that this edit replaces.
    pub fn fits(&self, document: &Document) -> bool {
        match self {
            Self::Material { index, .. } => *index < document.materials.len(),
            Self::Light { index, .. } => *index < document.lights.len(),
            Self::Added { material, .. } => material.is_some() || document.added > 0,
            Self::Look(state) => state.materials.as_ref().is_none_or(|of_look| {
                of_look.materials.len().checked_sub(of_look.added) == Some(document.own_materials())
            }),
            // Poses of deleted objects have no target.
            Self::Poses(poses) => {
                !poses.is_empty() && poses.keys().all(|&object| (object as usize) < document.objects.len())
            }
            _ => true,
        }
    }

    /// Whether the document's value differs from the edit's.
    pub fn changes(&self, document: &Document) -> bool {
        match self {
            Self::Material { index, material } => document.materials.get(*index).is_some_and(|m| *m != **material),
            Self::Assigned(assigned) => *assigned != document.assigned,
            Self::Added { .. } => self.fits(document),
            Self::Poses(poses) => poses.iter().any(|(&object, pose)| *pose != document.poses.of(object)),
            Self::Handling(handling) => *handling != document.handling,
            Self::Environment(environment) => *environment != document.environment,
            Self::Light { index, light } => document.lights.get(*index).is_some_and(|l| *l != **light),
            Self::Lights(lights) => *lights != document.lights,
            Self::Components(components) => *components != document.components,
            Self::Solution(solution) => *solution != document.solution,
            Self::View(view) => *view != document.view,
            Self::Bookmarks(bookmarks) => *bookmarks != document.bookmarks,
            Self::Look(state) => self.fits(document) && state.differs(document),
            Self::Looks(looks) => *looks != document.looks,
            Self::Bake(bake) => **bake != document.bake,
        }
    }

    /// Its name in undo. For poses it is the verb and the object's name, or the number of objects.
    pub fn name(&self, label: &str, document: &Document) -> String {
        let Self::Poses(poses) = self else { return label.to_owned() };
        match (poses.len(), poses.keys().next()) {
            (1, Some(&object)) => format!("{label} {}", document.object_name(object)),
            (objects, _) => format!("{label} {objects} objects"),
        }
    }

    /// Whether both edits change the same part of a document.
    pub fn same_target(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Material { index: a, .. }, Self::Material { index: b, .. })
            | (Self::Light { index: a, .. }, Self::Light { index: b, .. }) => a == b,
            (Self::Poses(a), Self::Poses(b)) => a.keys().eq(b.keys()),
            (Self::Added { .. }, Self::Added { .. }) | (Self::Look(_), Self::Look(_)) => false,
            _ => discriminant(self) == discriminant(other),
        }
    }

    /// Visits the materials that it holds.
    pub fn visit_materials(&mut self, visit: &mut dyn FnMut(&mut Material)) {
        match self {
            Self::Material { material, .. } => visit(material),
            Self::Added { material, .. } => material.as_deref_mut().into_iter().for_each(visit),
            Self::Look(state) => state.materials_mut().for_each(|(_, material)| visit(material)),
            Self::Looks(looks) => {
                looks.iter_mut().flat_map(|look| look.state.materials_mut()).for_each(|(_, material)| visit(material));
            }
            _ => {}
        }
    }

    /// Renumbers the materials that it names or holds, in a document whose materials are `now`.
    pub fn renumber_materials(&mut self, renumbering: &Renumbering, now: &[Material]) {
        match self {
            Self::Look(state) => state.renumber_materials(renumbering, now),
            Self::Looks(looks) => {
                looks.iter_mut().for_each(|look| look.state.renumber_materials(renumbering, now));
            }
            Self::Material { index, .. } => *index = renumbering.of(*index),
            Self::Assigned(assigned) | Self::Added { assigned, .. } => renumber(assigned, renumbering),
            Self::View(view) => view.renumber_materials(renumbering),
            _ => {}
        }
    }

    /// Renumbers the objects that it names, and drops deleted ones.
    pub fn renumber_objects(&mut self, numbers: &ObjectNumbers) {
        match self {
            Self::Poses(poses) => {
                let found = take(poses).into_iter().filter_map(|(object, pose)| Some((numbers.of(object)?, pose)));
                *poses = found.collect();
            }
            Self::Handling(handling) => handling::renumber(handling, numbers),
            Self::Assigned(assigned) | Self::Added { assigned, .. } => numbers.renumber(assigned),
            Self::Look(state) => state.renumber_objects(numbers),
            Self::Looks(looks) => looks.iter_mut().for_each(|look| look.state.renumber_objects(numbers)),
            _ => {}
        }
    }
}

/// Adds a material to the document, or takes its last one away and returns it.
fn swap_last(material: Option<Box<Material>>, document: &mut Document) -> Option<Box<Material>> {
    match material {
        Some(material) => {
            document.materials.push(*material);
            document.added += 1;
            None
        }
        None => {
            document.added -= 1;
            document.materials.pop().map(Box::new)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{parts::Part, test_scenes};

    #[test]
    fn poses_are_swapped_with_those_of_their_objects_alone() {
        let objects = ["lid", "pot", "cup"].map(String::from).to_vec();
        let mut document = Document { objects, ..Document::empty() };
        let raised = Pose { translate: glam::Vec3::Y, ..Pose::AS_BAKED };
        let of = |document: &Document| [0, 1, 2].map(|object| document.poses.of(object));
        let one = |object: u32, pose: Pose| Edit::Poses([(object, pose)].into());
        let mut edit = Edit::Poses([(0, raised), (1, Pose { scale: 2.0, ..raised })].into());
        assert!(edit.fits(&document) && edit.changes(&document));
        assert!(!Edit::Poses([(0, raised), (3, raised)].into()).fits(&document));
        assert!(edit.same_target(&edit.clone()) && !edit.same_target(&one(0, raised)));
        edit.swap(&mut document);
        assert_eq!(of(&document), [raised, Pose { scale: 2.0, ..raised }, Pose::AS_BAKED]);
        assert!(!one(0, raised).changes(&document) && one(1, raised).changes(&document));
        edit.swap(&mut document);
        assert!(document.poses.is_empty());
    }

    #[test]
    fn edits_of_poses_are_called_by_their_objects() {
        let objects = ["Short block", ""].map(String::from).to_vec();
        let document = Document { objects, ..Document::empty() };
        let name = |objects: &[u32]| {
            let poses = objects.iter().map(|&object| (object, Pose::AS_BAKED)).collect();
            Edit::Poses(poses).name("Move", &document)
        };
        assert_eq!(name(&[0]), "Move Short block");
        assert_eq!([name(&[1]), name(&[2])], ["Move object"; 2], "without a name");
        assert_eq!(name(&[0, 1]), "Move 2 objects");
        assert_eq!(Edit::Lights(Vec::new()).name("Delete light", &document), "Delete light", "negative control");
    }

    #[test]
    fn swapping_twice_restores_both() {
        let mut document = Document { materials: vec![Material::default(); 2], ..Document::empty() };
        let new = Material { name: "new".into(), ..Default::default() };
        let mut edit = Edit::Material { index: 1, material: Box::new(new) };
        assert!(edit.changes(&document));
        edit.swap(&mut document);
        assert_eq!((document.materials[0].name.as_str(), document.materials[1].name.as_str()), ("", "new"));
        edit.swap(&mut document);
        assert_eq!(document.materials, vec![Material::default(); 2]);
        assert!(matches!(edit, Edit::Material { index: 1, material } if material.name == "new"));
    }

    #[test]
    fn lights_are_edited_one_by_one_and_as_a_list() {
        let light = |name: &str| Light { name: name.into(), ..test_scenes::light() };
        let mut document = Document { lights: vec![light("a"), light("b")], ..Document::empty() };
        let edit = |index, name: &str| Edit::Light { index, light: Box::new(light(name)) };
        assert!(edit(1, "c").changes(&document) && !edit(1, "b").changes(&document));
        assert!(edit(1, "c").fits(&document) && !edit(2, "c").fits(&document) && !edit(2, "c").changes(&document));
        assert!(edit(1, "c").same_target(&edit(1, "d")) && !edit(1, "c").same_target(&edit(0, "c")));
        let mut fewer = Edit::Lights(vec![light("a")]);
        fewer.swap(&mut document);
        assert!(document.lights.len() == 1 && !edit(1, "c").fits(&document));
        fewer.swap(&mut document);
        assert_eq!(document.lights[1].name, "b");
    }

    #[test]
    fn a_material_that_is_not_there_does_not_fit() {
        let document = Document { materials: vec![Material::default()], ..Document::empty() };
        let edit = |index| Edit::Material { index, material: Box::default() };
        assert!(edit(0).fits(&document) && !edit(1).fits(&document));
        assert!(!edit(1).changes(&document));
        assert!(edit(0).same_target(&edit(0)) && !edit(0).same_target(&edit(1)));
    }

    #[test]
    fn a_material_is_added_with_its_parts_and_taken_away_again() {
        let named = |name: &str| Material { name: name.into(), ..Default::default() };
        let mut document = Document { materials: vec![named("a")], ..Document::empty() };
        let assigned: Assignment = [(Part { object: 0, material: 0 }, 1)].into();
        let mut edit = Edit::Added { material: Some(Box::new(named("b"))), assigned: assigned.clone() };
        assert!(edit.changes(&document) && !edit.same_target(&edit.clone()), "each is a step of its own");
        edit.swap(&mut document);
        assert_eq!((document.materials.len(), document.added, &document.assigned), (2, 1, &assigned));
        edit.swap(&mut document);
        assert_eq!((document.materials.len(), document.added), (1, 0));
        assert!(document.assigned.is_empty());
        edit.swap(&mut document);
        assert_eq!(document.materials[1].name, "b");
        document.added = 0;
        assert!(!edit.fits(&document), "negative control: the scene's own is not taken away");
    }
}
