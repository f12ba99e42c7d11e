//! Objects of a document, matched by name, since another version of the scene may order them differently.

use super::{Document, Edit, handling, parts::Assignment};
use lapidary_core::{
    ground,
    parts::Part,
    scene::{Scene, pose::Pose},
};
use std::{
    borrow::Cow,
    collections::{HashMap, VecDeque},
    mem::take,
};

/// A renumbering of objects.
#[derive(Clone, Debug)]
pub struct ObjectNumbers(Vec<Option<u32>>);

impl ObjectNumbers {
    /// From the names before to the names now. Objects of one name stay in their order.
    pub fn between(before: &[String], now: &[String]) -> Self {
        let mut places: HashMap<&str, VecDeque<u32>> = HashMap::new();
        (0..).zip(now).for_each(|(place, name)| places.entry(name).or_default().push_back(place));
        Self(before.iter().map(|name| places.get_mut(name.as_str())?.pop_front()).collect())
    }

    /// The new number of an object; `None` if it is gone.
    pub fn of(&self, object: u32) -> Option<u32> {
        *self.0.get(object as usize)?
    }

    /// The same part; `None` if its object is gone.
    pub fn of_part(&self, part: Part) -> Option<Part> {
        Some(Part { object: self.of(part.object)?, ..part })
    }

    /// Renumbers the objects of an assignment.
    pub fn renumber(&self, assigned: &mut Assignment) {
        let found = take(assigned).into_iter().filter_map(|(part, material)| Some((self.of_part(part)?, material)));
        *assigned = found.collect();
    }
}

impl Document {
    /// Takes the objects of another version of the scene, and returns their numbers. Parts and poses follow the names of their
    /// objects.
    pub fn take_objects(&mut self, scene: &Scene) -> ObjectNumbers {
        self.take_names(names_of(scene))
    }

    fn take_names(&mut self, names: Vec<String>) -> ObjectNumbers {
        let numbers = ObjectNumbers::between(&self.objects, &names);
        numbers.renumber(&mut self.assigned);
        self.looks.iter_mut().for_each(|look| look.state.renumber_objects(&numbers));
        self.poses = self.poses.renumbered(|object| numbers.of(object));
        handling::renumber(&mut self.handling, &numbers);
        self.objects = names;
        numbers
    }

    /// The document with the objects of another version of its scene, followed by its ground, if any.
    pub fn with_objects_of(&self, scene: &Scene) -> Cow<'_, Self> {
        let mut names = names_of(scene);
        names.extend(self.objects.last().filter(|name| *name == ground::NAME).cloned());
        if names == self.objects {
            return Cow::Borrowed(self);
        }
        let mut other = self.clone();
        other.take_names(names);
        Cow::Owned(other)
    }

    /// The edit that hides objects, or shows them.
    pub fn hiding(&self, objects: impl IntoIterator<Item = u32>, hidden: bool) -> Edit {
        Edit::Poses(objects.into_iter().map(|object| (object, Pose { hidden, ..self.poses.of(object) })).collect())
    }

    /// The object of a name, preferably at `place`.
    pub fn object_called(&self, name: &str, place: u32) -> Option<u32> {
        let is_there = self.objects.get(place as usize).is_some_and(|known| known == name);
        let found = || self.objects.iter().position(|known| known == name).map(|found| found as u32);
        if is_there { Some(place) } else { found() }
    }
}

/// Names of all objects of a scene.
pub fn names_of(scene: &Scene) -> Vec<String> {
    scene.objects.iter().map(|object| object.name.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::scene::Object;

    const RAISED: Pose = Pose { translate: glam::Vec3::Y, ..Pose::AS_BAKED };

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().copied().map(String::from).collect()
    }

    fn scene(objects: &[&str]) -> Scene {
        let objects = names(objects).into_iter().map(|name| Object { name }).collect();
        Scene { objects, ..Default::default() }
    }

    fn part(object: u32) -> Part {
        Part { object, material: 0 }
    }

    /// A document whose second object is raised and has another material.
    fn document(objects: &[&str]) -> Document {
        let mut document = Document { objects: names(objects), ..Document::empty() };
        document.poses.set(1, RAISED);
        document.assigned = [(part(1), 2)].into();
        document
    }

    #[test]
    fn parts_and_poses_are_found_again_by_the_name_of_their_object() {
        let mut document = document(&["floor", "pot"]);
        document.assigned.insert(part(0), 1);
        document.take_objects(&scene(&["rug", "vase", "pot"]));
        assert_eq!(document.assigned, [(part(2), 2)].into(), "the floor is gone");
        assert_eq!(document.poses.moved().collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn objects_of_one_name_stay_in_their_order_and_apart() {
        let numbers = ObjectNumbers::between(&names(&["a", "b", "b", "c"]), &names(&["new", "a", "b", "b"]));
        assert_eq!([0, 1, 2, 3, 4].map(|object| numbers.of(object)), [Some(1), Some(2), Some(3), None, None]);
    }

    #[test]
    fn a_ground_comes_after_the_objects_of_any_version_of_a_scene() {
        let mut document = document(&["floor", "pot", ground::NAME]);
        document.assigned.insert(part(2), 3);
        assert!(matches!(document.with_objects_of(&scene(&["floor", "pot"])), Cow::Borrowed(_)));
        let other = document.with_objects_of(&scene(&["floor", "rug", "pot"])).into_owned();
        assert_eq!(other.assigned, [(part(2), 2), (part(3), 3)].into());
        assert_eq!((other.poses.of(2), document.poses.of(1)), (RAISED, RAISED));
        let fewer = document.with_objects_of(&scene(&["floor"])).into_owned();
        assert!(fewer.poses.is_empty() && fewer.assigned == [(part(1), 3)].into(), "the pot's are not the ground's");
    }
}
