//! Moves the objects of a scene away from their places in the file.

use super::{
    Mesh, MeshError, Scene,
    placed::Placed,
    pose::{DeformedObject, Objects, Pose, Poses, check_shown},
};
use glam::Vec3;
use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
};

impl Objects {
    /// The objects of a scene as baked. A vertex shared by several objects goes to the first.
    pub fn of(scene: &Scene) -> Self {
        Self::of_mesh(&scene.mesh, scene.objects.len())
    }
}

impl Scene {
    /// Places the objects of a scene that is still as in its file. Where poses deform objects, `clip_time` should give their time.
    ///
    /// # Errors
    /// Places beyond [`MOST_COORDINATE`](crate::bounds::MOST_COORDINATE); the scene is then unchanged.
    pub fn place(&mut self, poses: &Poses) -> Result<(), MeshError> {
        self.place_objects(poses, &poses.all_shown(), poses.moved().collect())
    }

    /// Places the objects of a baked scene anew, by poses relative to the file. Where the bake deformed objects, they keep their form.
    ///
    /// # Errors
    /// As [`Self::place`].
    pub fn place_again(&mut self, of_file: &Poses) -> Result<(), MeshError> {
        let is_deformed = |placed: &&Placed| self.clip_time.is_some() || placed.pose == Pose::AS_BAKED;
        let deformed = self.placed.iter().filter(is_deformed).map(|placed| placed.object);
        let placed = deformed.chain(of_file.moved()).collect();
        self.place_objects(of_file, &self.poses_since_baked(&of_file.all_shown()), placed)
    }

    /// Moves the mesh by poses `since` its present state, notes the `placed` objects, and hides some.
    fn place_objects(&mut self, of_file: &Poses, since: &Poses, placed: BTreeSet<u32>) -> Result<(), MeshError> {
        let before = Objects::of(self);
        let mut placed_scene = self.with_mesh(since.pose(&self.mesh, &before)?);
        // A deformed object has another box than in its file but still turns about the file's center.
        let after = Objects::of(&placed_scene);
        let note = |object: u32| Placed {
            object,
            pose: of_file.of(object),
            center: self.center_in_file(object).unwrap_or(before.center(object)),
            baked_center: after.center(object),
        };
        let placed = placed.into_iter().filter(|&object| (object as usize) < before.len());
        placed_scene.placed = placed.map(note).collect();
        placed_scene.hidden.clear();
        for Placed { object, baked_center, .. } in placed_scene.placed.iter().filter(|placed| placed.pose.hidden) {
            let vertices = after.vertices(*object);
            placed_scene.hidden.insert(*object, DeformedObject::of_mesh(&placed_scene.mesh, vertices));
            placed_scene.mesh.collapse(vertices, *baked_center);
        }
        if !placed_scene.hidden.is_empty() {
            check_shown(&placed_scene.mesh)?;
        }
        *self = placed_scene;
        Ok(())
    }

    /// Restores what is known of `hidden` objects from the positions of their vertices, object by object.
    pub(crate) fn keep_hidden(&mut self, hidden: &[u32], mut positions: &[Vec3]) {
        let objects = Objects::of(self);
        let mut mesh = self.mesh.clone();
        for &object in hidden {
            let (own, others) = positions.split_at(objects.vertices(object).len());
            own.iter().zip(objects.vertices(object)).for_each(|(&at, &v)| mesh.positions[v as usize] = at);
            self.hidden.insert(object, DeformedObject::of_mesh(&mesh, objects.vertices(object)));
            positions = others;
        }
    }

    /// Poses of its objects relative to the file.
    pub fn placed_poses(&self) -> Poses {
        let mut poses = Poses::default();
        self.placed.iter().for_each(|placed| poses.set(placed.object, placed.pose));
        poses
    }

    /// Converts poses relative to the file to poses relative to the bake.
    pub fn poses_since_baked(&self, of_file: &Poses) -> Poses {
        let mut poses = of_file.clone();
        self.placed.iter().for_each(|placed| poses.set(placed.object, placed.since_baked(of_file.of(placed.object))));
        let shown_again = self.hidden.iter().filter(|(object, _)| !of_file.of(**object).hidden);
        shown_again.for_each(|(&object, vertices)| poses.deform(object, Some(vertices.clone())));
        poses
    }

    /// The mesh with the objects that a bake hid, where they would be.
    pub fn shown_mesh(&self) -> Cow<'_, Mesh> {
        if self.hidden.is_empty() {
            return Cow::Borrowed(&self.mesh);
        }
        let mut shown = Poses::default();
        self.hidden.iter().for_each(|(&object, vertices)| shown.deform(object, Some(vertices.clone())));
        Cow::Owned(shown.pose(&self.mesh, &Objects::of(self)).expect("vertices of this mesh"))
    }

    /// The same scene with the objects that a bake hid.
    pub fn with_all_shown(&self) -> Cow<'_, Self> {
        match self.shown_mesh() {
            Cow::Borrowed(_) => Cow::Borrowed(self),
            Cow::Owned(mesh) => Cow::Owned(Self { hidden: BTreeMap::new(), ..self.with_mesh(mesh) }),
        }
    }

    /// The mesh with all objects at their places in the file.
    pub(crate) fn unplaced(&self) -> Mesh {
        let (mut mesh, objects) = (self.shown_mesh().into_owned(), Objects::of(self));
        for placed in &self.placed {
            let (file_from_baked, rotation) = (placed.baked_from_file().inverse(), placed.pose.rotation().inverse());
            for &vertex in objects.vertices(placed.object) {
                mesh.turn_vertex(vertex as usize, file_from_baked, rotation);
            }
        }
        mesh
    }

    /// The center of an object in the file, if the object was moved or deformed.
    pub fn center_in_file(&self, object: u32) -> Option<Vec3> {
        self.placed.iter().find(|placed| placed.object == object).map(|placed| placed.center)
    }

    /// Whether all placed objects match the scene's objects.
    pub(crate) fn placed_fits(&self) -> bool {
        let different: BTreeSet<u32> = self.placed.iter().map(|placed| placed.object).collect();
        different.len() == self.placed.len() && self.placed.iter().all(|placed| placed.fits(self.objects.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scene::{
            placed::{deformed_hash, hash},
            pose::{ClipTime, DeformedObject, Pose, PosedVertices},
        },
        test_scenes::cubes,
    };

    fn pose(x: f32, degrees: f32, scale: f32) -> Pose {
        let rotate_degrees = Vec3::new(degrees, -0.5 * degrees, 2.0 * degrees);
        Pose { translate: Vec3::new(x, 0.3, -x), rotate_degrees, scale, ..Pose::AS_BAKED }
    }

    fn poses(of: [(u32, Pose); 2]) -> Poses {
        let mut poses = Poses::default();
        of.into_iter().for_each(|(object, pose)| poses.set(object, pose));
        poses
    }

    #[test]
    fn poses_since_a_bake_lead_to_where_those_of_the_file_do() {
        let file = cubes(3);
        let baked_so = poses([(0, pose(0.4, 25.0, 1.5)), (2, pose(-0.7, -70.0, 0.6))]);
        let now = poses([(0, pose(-0.2, 10.0, 0.9)), (1, pose(0.1, 5.0, 1.1))]);
        let mut baked = file.clone();
        baked.place(&baked_so).unwrap();
        let since = baked.poses_since_baked(&now);
        let found = since.pose(&baked.mesh, &Objects::of(&baked)).unwrap();
        let expected = now.pose(&file.mesh, &Objects::of(&file)).unwrap();
        let apart = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(apart(&found.positions, &expected.positions) < 1e-5 && apart(&found.normals, &expected.normals) < 1e-5);
        let as_in_the_file = now.pose(&baked.mesh, &Objects::of(&baked)).unwrap();
        assert!(apart(&as_in_the_file.positions, &expected.positions) > 0.3, "negative control");
        assert!(baked.poses_since_baked(&baked_so).is_empty(), "to the bit");
        assert_eq!((baked.placed_poses(), baked.center_in_file(1)), (baked_so, None));
    }

    #[test]
    fn an_object_that_a_bake_hid_comes_back_to_the_bit() {
        let hidden = poses([(0, Pose { hidden: true, ..pose(0.4, 25.0, 1.5) }), (2, pose(-0.7, -70.0, 0.6))]);
        let shown = hidden.all_shown();
        let scene = |poses: &Poses| {
            let mut scene = cubes(3);
            scene.place(poses).unwrap();
            scene
        };
        let again = |scene: &Scene, poses: &Poses| {
            let mut scene = scene.clone();
            scene.place_again(poses).unwrap();
            scene
        };
        let seen = |scene: &Scene, of_file: &Poses| {
            scene.poses_since_baked(of_file).pose(&scene.mesh, &Objects::of(scene)).unwrap()
        };
        let [without, with] = [&hidden, &shown].map(scene);
        assert!(without.mesh != with.mesh && *without.shown_mesh() == with.mesh, "negative control: one lacks it");
        assert!(without.poses_since_baked(&hidden).is_empty() && without.placed_poses() == hidden);
        assert_eq!(with.poses_since_baked(&hidden).hidden().collect::<Vec<_>>(), [0]);
        assert!(seen(&without, &shown) == with.mesh && seen(&with, &hidden).positions == without.mesh.positions);
        let (back, gone) = (again(&without, &shown), again(&with, &hidden));
        assert!(back.mesh == with.mesh && back.hidden.is_empty() && back.placed_poses() == shown);
        assert!(gone.mesh == without.mesh && gone.hidden == without.hidden);
        let elsewhere = poses([(0, pose(-0.2, 10.0, 0.9)), (1, pose(0.1, 5.0, 1.1))]);
        let (found, expected) = (seen(&without, &elsewhere), scene(&elsewhere).mesh);
        let apart = found.positions.iter().zip(&expected.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(apart < 1e-5, "{apart}: shown, and moved");
        assert_eq!(hash(&hidden, None), hash(&shown, None), "a bake begins with all objects shown");
    }

    /// The result of an animation: a cube that slides and grows.
    fn slid(scene: &Scene, object: u32, x: f32) -> DeformedObject {
        let (mesh, objects) = (&scene.mesh, Objects::of(scene));
        let mut vertices = PosedVertices::default();
        for vertex in objects.vertices(object).iter().map(|&vertex| vertex as usize) {
            vertices.positions.push(mesh.positions[vertex] * Vec3::new(1.0, 1.2, 1.0) + Vec3::X * x);
            vertices.normals.push(mesh.normals[vertex]);
            vertices.tangents.push(mesh.tangents[vertex]);
        }
        DeformedObject::new(vertices, [0, 0, x.to_bits()])
    }

    #[test]
    fn an_object_that_was_baked_deformed_turns_about_its_center_at_rest() {
        let file = cubes(3);
        let mut at_that_time = Poses::default();
        at_that_time.deform(1, Some(slid(&file, 1, 2.0)));
        let mut baked = file.clone();
        baked.place(&at_that_time).unwrap();
        assert!(baked.placed_poses().is_empty() && baked.poses_since_baked(&Poses::default()).is_empty());
        assert_eq!(baked.center_in_file(1), Some(Objects::of(&file).center(1)));
        assert_eq!(baked.unplaced(), baked.mesh, "to the bit");
        let turned = poses([(1, pose(0.1, 90.0, 1.1)), (2, pose(0.2, 30.0, 1.0))]);
        let shown = baked.poses_since_baked(&turned).pose(&baked.mesh, &Objects::of(&baked)).unwrap();
        let mut again = file.clone();
        let mut both = turned.clone();
        both.deform(1, at_that_time.deformed(1).cloned());
        again.place(&both).unwrap();
        let apart = |mesh: &Mesh| {
            let places = mesh.positions.iter().zip(&again.mesh.positions);
            places.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
        };
        assert!(apart(&shown) < 1e-5, "{}", apart(&shown));
        let about_its_box = turned.pose(&baked.mesh, &Objects::of(&baked)).unwrap();
        assert!(apart(&about_its_box) > 1.0, "negative control");
    }

    #[test]
    fn a_scene_is_told_apart_by_its_poses() {
        let (one, other) = (
            poses([(0, pose(1.0, 0.0, 1.0)), (1, Pose::AS_BAKED)]),
            poses([(1, pose(1.0, 0.0, 1.0)), (0, Pose::AS_BAKED)]),
        );
        assert!(hash(&one, None).is_some() && hash(&one, None) != hash(&other, None));
        assert_eq!(hash(&Poses::default(), None), None);
        let at = |seconds| ClipTime { clip: "walk".into(), seconds };
        assert_ne!(hash(&one, Some(&at(1.0))), hash(&one, Some(&at(2.0))));
        assert_ne!(hash(&one, Some(&at(1.0))), hash(&one, None));
        let deformed = |object, x| {
            let mut poses = one.clone();
            poses.deform(object, Some(slid(&cubes(2), object, x)));
            deformed_hash(&poses)
        };
        assert!(deformed(0, 1.0).is_some() && deformed(0, 1.0) == deformed(0, 1.0));
        assert!(deformed(0, 1.0) != deformed(0, 1.5) && deformed(0, 1.0) != deformed(1, 1.0));
        assert_eq!(deformed_hash(&one), None);
        assert_eq!(one.clone().at(at(1.0)), one, "nothing is deformed");
    }

    #[test]
    fn objects_out_of_reach_leave_the_scene_as_it_is() {
        let mut scene = cubes(1);
        let far = poses([(0, Pose { translate: Vec3::splat(1e30), ..Pose::AS_BAKED }), (1, Pose::AS_BAKED)]);
        assert!(scene.place(&far).is_err());
        assert_eq!((&scene.mesh, &scene.placed[..]), (&cubes(1).mesh, &[][..]));
        let mut all = Poses::default();
        all.set(0, Pose { hidden: true, ..Pose::AS_BAKED });
        assert_eq!(scene.place(&all), Err(MeshError::NothingShown));
        assert!(all.pose(&scene.mesh, &Objects::of(&scene)).is_err() && cubes(2).place(&all).is_ok());
        assert_eq!((scene.mesh, scene.placed), (cubes(1).mesh, Vec::new()));
    }
}
