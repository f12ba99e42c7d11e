//! The selected objects that handles and numbers move together, and their pivot. Independent of the screen.

use super::{
    change::{Axis, Change, posed},
    tool::Tool,
};
use glam::Vec3;
use lapidary_core::scene::pose::{Pose, Poses, Similarity};
use std::collections::BTreeMap;

/// The pivot about which objects turn and scale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pivot {
    /// The pivot of the object selected last.
    #[default]
    Active,
    /// The mean of the pivots of all selected objects. It is invariant under turns and scales about itself, unlike the center of a
    /// box around the objects.
    Selection,
    /// Each object's own pivot.
    Own,
}

impl Pivot {
    /// All pivots, each with its name and tooltip.
    pub const CHOICES: [(Self, &str, &str); 3] = [
        (Self::Active, "Selected last", "Turns and scales all about the pivot of the object selected last"),
        (Self::Selection, "All selected", "Turns and scales all about the middle of their pivots"),
        (Self::Own, "Own pivots", "Turns and scales each object about its own pivot"),
    ];
}

/// An object that can be posed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subject {
    /// Its index.
    pub object: u32,
    /// The center of its pose: its own center in the file, in meters.
    pub center: Vec3,
    /// The point about which it turns, without its pose, in meters: the pivot placed on it, else the center of its present shape,
    /// which an animation may move.
    pub middle: Vec3,
    /// The unit direction of its hinge, without its pose.
    pub hinge: Option<Vec3>,
}

impl Subject {
    /// Position of its middle, in meters.
    pub fn place(&self, poses: &Poses) -> Vec3 {
        let pose = poses.of(self.object);
        self.center + pose.translate + pose.rotation() * (pose.scale * (self.middle - self.center))
    }
}

/// Objects posed together, with pivot and tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Movable {
    /// The object selected last.
    pub active: Subject,
    /// The objects that move along.
    pub others: Vec<Subject>,
    /// The pivot.
    pub pivot: Pivot,
    /// The tool.
    pub tool: Tool,
}

impl Movable {
    fn subjects(&self) -> impl Iterator<Item = &Subject> {
        [&self.active].into_iter().chain(&self.others)
    }

    /// Whether both pose the same objects the same way, wherever these are.
    pub fn is_same(&self, other: &Self) -> bool {
        let objects = |movable: &Self| movable.subjects().map(|subject| subject.object).collect::<Vec<_>>();
        (self.pivot, self.tool) == (other.pivot, other.tool) && objects(self) == objects(other)
    }

    /// Position of the handles, in meters: at the pivot, or the active object if each has its own.
    pub fn place(&self, poses: &Poses) -> Vec3 {
        match self.pivot {
            Pivot::Active | Pivot::Own => self.active.place(poses),
            Pivot::Selection => {
                let sum: Vec3 = self.subjects().map(|subject| subject.place(poses)).sum();
                sum / (1 + self.others.len()) as f32
            }
        }
    }

    /// The axes of turns: the hinge of the active object alone, else those of the world.
    pub fn turn_axes(&self, poses: &Poses) -> Vec<Axis> {
        let hinge = self.active.hinge.filter(|_| self.pivot != Pivot::Selection);
        let posed = |hinge: Vec3| vec![Axis::Hinge((poses.of(self.active.object).rotation() * hinge).normalize())];
        hinge.map_or(Axis::OF_WORLD.into(), posed)
    }

    /// The objects' poses out of all.
    pub fn poses(&self, of_all: &Poses) -> BTreeMap<u32, Pose> {
        self.subjects().map(|subject| (subject.object, of_all.of(subject.object))).collect()
    }

    /// The change, limited to what all objects allow.
    pub fn limited(&self, change: Change, before: &Poses) -> Change {
        change.limited(self.subjects().map(|subject| before.of(subject.object).scale))
    }

    /// The objects' poses after a similarity, about their pivot.
    pub fn changed(&self, before: &Poses, by: Similarity) -> BTreeMap<u32, Pose> {
        let common = self.place(before);
        let changed = |subject: &Subject| {
            let pivot = if self.pivot == Pivot::Own { subject.place(before) } else { common };
            let by = Similarity { pivot, ..by };
            (subject.object, posed(before.of(subject.object), &by, subject.center))
        };
        self.subjects().map(changed).collect()
    }

    /// The objects' poses after typing a number of the active one's pose, which becomes `typed`; the others follow the change.
    pub fn typed(&self, before: &Poses, typed: Pose) -> BTreeMap<u32, Pose> {
        let active = before.of(self.active.object);
        let by = match self.tool {
            Tool::Move => Change::Move(typed.translate - active.translate).similarity(),
            Tool::Turn => {
                Similarity { rotation: typed.rotation() * active.rotation().inverse(), ..Similarity::IDENTITY }
            }
            Tool::Scale => self.limited(Change::Scale(typed.scale / active.scale), before).similarity(),
        };
        let mut poses = self.changed(before, by);
        // One pose has many numbers; the typed ones are kept.
        match (self.tool, poses.get_mut(&self.active.object)) {
            (Tool::Move, Some(active)) => active.translate = typed.translate,
            (Tool::Turn, Some(active)) => active.rotate_degrees = typed.rotate_degrees,
            _ => {}
        }
        poses
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;
    use lapidary_core::scene::pose::MOST_SCALE;

    const CENTERS: [Vec3; 3] = [Vec3::new(1.0, 0.5, 0.0), Vec3::new(-1.0, 0.0, 2.0), Vec3::new(0.0, 3.0, -1.0)];
    const PIVOTS: [Pivot; 3] = [Pivot::Active, Pivot::Selection, Pivot::Own];
    const TURN: Change = Change::Turn { axis: Axis::World(1), degrees: 70.0 };

    fn group(pivot: Pivot) -> Movable {
        let [active, a, b] = [0, 1, 2].map(|object| {
            let center = CENTERS[object as usize];
            Subject { object, center, middle: center, hinge: None }
        });
        Movable { active, others: vec![a, b], pivot, tool: Tool::Turn }
    }

    /// One object as baked, one turned, one moved and scaled.
    fn before() -> Poses {
        let mut poses = Poses::default();
        poses.set(1, Pose { rotate_degrees: Vec3::new(20.0, -40.0, 10.0), ..Pose::AS_BAKED });
        poses.set(2, Pose { translate: Vec3::new(0.5, -1.0, 0.2), scale: 1.5, ..Pose::AS_BAKED });
        poses
    }

    /// Two vertices of each object.
    fn vertices(poses: &Poses) -> Vec<Vec3> {
        let world_from_baked = |o: usize| -> Affine3A { poses.of(o as u32).world_from_baked(CENTERS[o]) };
        let corners = [Vec3::new(0.1, 0.2, -0.1), Vec3::new(-0.2, 0.0, 0.1)];
        let of_object = |o: usize| corners.map(|corner| world_from_baked(o).transform_point3(CENTERS[o] + corner));
        (0..3).flat_map(of_object).collect()
    }

    fn after(movable: &Movable, change: Change) -> Poses {
        let mut poses = before();
        let changed = movable.changed(&before(), movable.limited(change, &before()).similarity());
        changed.into_iter().for_each(|(object, pose)| poses.set(object, pose));
        poses
    }

    /// The largest change of a distance between two vertices, against a scale of all, in meters.
    fn deformation(poses: &Poses, scale: f32) -> f32 {
        let (old, new) = (vertices(&before()), vertices(poses));
        let pairs = (0..old.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        let change = |(a, b): (usize, usize)| (new[a].distance(new[b]) - scale * old[a].distance(old[b])).abs();
        pairs.map(change).fold(0.0, f32::max)
    }

    #[test]
    fn a_group_turns_and_scales_as_one_about_one_pivot_and_falls_apart_about_several() {
        for (change, scale) in [(TURN, 1.0), (Change::Scale(1.7), 1.7)] {
            for pivot in [Pivot::Active, Pivot::Selection] {
                let off = deformation(&after(&group(pivot), change), scale);
                assert!(off < 1e-5, "{pivot:?}, {change:?}: {off}");
            }
            let off = deformation(&after(&group(Pivot::Own), change), scale);
            assert!(off > 0.1, "negative control: each about its own, {change:?}: {off}");
        }
    }

    #[test]
    fn an_object_that_an_animation_moved_turns_and_scales_about_its_middle() {
        let rest = group(Pivot::Own);
        let moved = Subject { middle: CENTERS[1] + Vec3::new(0.5, -0.2, 0.1), ..rest.others[0] };
        let movable = Movable { active: moved, others: Vec::new(), ..rest };
        let middle = |poses: &Poses| poses.of(1).world_from_baked(CENTERS[1]).transform_point3(moved.middle);
        assert!(movable.place(&before()).distance(middle(&before())) < 1e-6, "turned by its pose before");
        for change in [TURN, Change::Scale(1.7)] {
            let after = after(&movable, change);
            assert!(middle(&after).distance(middle(&before())) < 1e-5, "{change:?}");
            let center = |poses: &Poses| CENTERS[1] + poses.of(1).translate;
            assert!(center(&after).distance(center(&before())) > 0.1, "negative control, {change:?}");
        }
    }

    #[test]
    fn a_lid_turns_about_its_hinge_wherever_it_was_moved_before() {
        let rest = group(Pivot::Active);
        let (point, hinge) = (CENTERS[1] + Vec3::new(-0.3, 0.1, 0.0), Vec3::new(0.0, 0.6, 0.8));
        let lid =
            Movable { active: Subject { middle: point, hinge: Some(hinge), ..rest.others[0] }, others: vec![], ..rest };
        let axes = lid.turn_axes(&before());
        let [axis @ Axis::Hinge(_)] = axes[..] else { panic!("{axes:?}") };
        let opened = after(&lid, Change::Turn { axis, degrees: 80.0 });
        let at = |poses: &Poses, along: f32| {
            poses.of(1).world_from_baked(CENTERS[1]).transform_point3(point + along * hinge)
        };
        for along in [-1.0, 0.0, 2.0] {
            let way = at(&opened, along).distance(at(&before(), along));
            assert!(way < 1e-4, "{along} m along the hinge: {way}");
        }
        let world = after(&lid, Change::Turn { axis: Axis::World(0), degrees: 80.0 });
        assert!(at(&world, 2.0).distance(at(&before(), 2.0)) > 0.1, "negative control: about an axis of the world");
        assert_eq!(group(Pivot::Active).turn_axes(&before()), Axis::OF_WORLD);
        let all = Movable { pivot: Pivot::Selection, ..lid };
        assert_eq!(all.turn_axes(&before()), Axis::OF_WORLD, "several have no hinge in common");
    }

    #[test]
    fn a_drag_stays_with_its_objects_while_an_animation_moves_them() {
        let (before, mut later) = (group(Pivot::Own), group(Pivot::Own));
        later.active.middle.x += 1.0;
        assert!(before.is_same(&later) && before != later);
        let (others, tool) = (group(Pivot::Active), Movable { tool: Tool::Move, ..group(Pivot::Own) });
        let fewer = Movable { others: Vec::new(), ..group(Pivot::Own) };
        assert!(![others, tool, fewer].iter().any(|other| before.is_same(other)), "negative control");
    }

    #[test]
    fn moves_take_all_by_the_same_vector_about_any_pivot() {
        for movable in PIVOTS.map(group) {
            let offset = Vec3::new(0.3, -0.2, 5.0);
            let moved = after(&movable, Change::Move(offset));
            for object in 0..3 {
                let pose = before().of(object);
                assert_eq!(moved.of(object), Pose { translate: pose.translate + offset, ..pose });
            }
        }
    }

    #[test]
    fn the_pivot_stays_where_it_is() {
        for (movable, moves_others) in PIVOTS.map(group).into_iter().zip([true, true, false]) {
            let turned = after(&movable, TURN);
            assert!(movable.place(&turned).distance(movable.place(&before())) < 1e-5, "{:?}", movable.pivot);
            let other = movable.others[0];
            let way = other.place(&turned).distance(other.place(&before()));
            assert_eq!(way > 0.5, moves_others, "{:?}: {way}", movable.pivot);
        }
        let [active, all] = [Pivot::Active, Pivot::Selection].map(|pivot| group(pivot).place(&before()));
        assert!(active.distance(all) > 0.5, "negative control: the pivots are different places");
    }

    #[test]
    fn a_scale_stops_for_all_where_the_first_object_reaches_the_limit() {
        for (factor, limit) in [(1e9, MOST_SCALE / 1.5), (0.5, 0.5)] {
            let scaled = after(&group(Pivot::Selection), Change::Scale(factor));
            for object in 0..3 {
                let expected = before().of(object).scale * limit;
                assert!(
                    (scaled.of(object).scale / expected - 1.0).abs() < 1e-6 && scaled.of(object).validate("").is_ok()
                );
            }
        }
    }
}
