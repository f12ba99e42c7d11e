//! How objects are handled in the window: whether they are locked, and the pivots placed on them.

use super::{Document, objects::ObjectNumbers};
use glam::Vec3;
use lapidary_core::bounds::is_within_reach;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, mem::take};

/// How an object is handled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Handling {
    /// Clicks in the viewport go through it, and it keeps its pose.
    pub locked: bool,
    /// Its pivot; `None` for its center.
    pub pivot: Option<PlacedPivot>,
}

/// A pivot placed on an object, which moves along with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlacedPivot {
    /// The point about which it turns and scales, in meters, with the object as in the scene file.
    pub point: Vec3,
    /// The unit direction of a hinge, if it was placed on an edge.
    #[serde(default)]
    pub hinge: Option<Vec3>,
}

impl PlacedPivot {
    /// Whether its point is within reach, and its direction of unit length.
    pub fn is_valid(&self) -> bool {
        is_within_reach(self.point) && self.hinge.is_none_or(|hinge| hinge.is_normalized())
    }
}

/// By object index; only objects that are handled otherwise than usual.
pub type HandlingOfObjects = BTreeMap<u32, Handling>;

/// Renumbers the objects, and drops deleted ones.
pub fn renumber(handling: &mut HandlingOfObjects, numbers: &ObjectNumbers) {
    *handling = take(handling).into_iter().filter_map(|(object, own)| Some((numbers.of(object)?, own))).collect();
}

impl Document {
    /// How an object is handled.
    pub fn handling_of(&self, object: u32) -> Handling {
        self.handling.get(&object).copied().unwrap_or_default()
    }

    /// The handling of all objects, with a change to that of some.
    pub fn with_handling(
        &self,
        objects: impl IntoIterator<Item = u32>,
        change: impl Fn(&mut Handling),
    ) -> HandlingOfObjects {
        let mut all = self.handling.clone();
        objects.into_iter().for_each(|object| change(all.entry(object).or_default()));
        all.retain(|_, own| *own != Handling::default());
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_unusual_handling_is_kept_and_it_follows_its_object() {
        let names = |names: &[&str]| names.iter().copied().map(String::from).collect::<Vec<_>>();
        let mut document = Document { objects: names(&["pot", "lid"]), ..Document::empty() };
        let pivot = PlacedPivot { point: Vec3::Y, hinge: Some(Vec3::X) };
        document.handling = document.with_handling([0, 1], |own| own.locked = true);
        document.handling = document.with_handling([1], |own| own.pivot = Some(pivot));
        document.handling = document.with_handling([0], |own| own.locked = false);
        let lid = Handling { locked: true, pivot: Some(pivot) };
        assert_eq!(document.handling, [(1, lid)].into());
        assert_eq!((document.handling_of(1), document.handling_of(0)), (lid, Handling::default()));
        renumber(&mut document.handling, &ObjectNumbers::between(&document.objects, &names(&["lid", "pot"])));
        assert_eq!(document.handling, [(0, lid)].into());
        renumber(&mut document.handling, &ObjectNumbers::between(&names(&["lid"]), &names(&["pot"])));
        assert!(document.handling.is_empty());
    }

    #[test]
    fn a_pivot_out_of_reach_or_with_a_long_hinge_is_not_valid() {
        let pivot = |point, hinge| PlacedPivot { point, hinge }.is_valid();
        assert!(pivot(Vec3::Y, Some(Vec3::X)) && pivot(Vec3::Y, None));
        assert!(!pivot(Vec3::splat(f32::NAN), None) && !pivot(Vec3::Y, Some(Vec3::splat(2.0))));
        assert!(!pivot(Vec3::Y, Some(Vec3::ZERO)));
    }
}
