//! An animation bound to a scene: to the repaired and tessellated mesh of a bake.

use super::{Animation, AnimationError, Clip, ClipTime, binding::BoundObject, shape::Posture};
use crate::{
    bounds::is_within_reach,
    names::told_apart,
    scene::{
        Object, Scene,
        placed::Placed,
        pose::{DeformedObject, Objects, PosedVertices, Poses},
    },
};
use rayon::prelude::*;
use std::{
    collections::BTreeSet,
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering},
    },
};

/// Largest distance of a vertex from the file's surface, relative to the diagonal of the scene; beyond it the shape is another.
const MOST_DISTANCE: f32 = 1e-3;

/// Replaces the index of a clip where the file is at rest.
const AT_REST: u32 = u32::MAX;

/// Identifies bound animations, so that their poses are never confused.
static NEXT: AtomicU32 = AtomicU32::new(0);

/// Poses the objects of one scene.
#[derive(Debug)]
pub struct BoundAnimation {
    animation: Arc<Animation>,
    /// Posture of the bake.
    as_baked: Posture,
    /// Objects that the bake moved relative to the file.
    placed: Vec<Placed>,
    /// Objects that the bake hid.
    hidden: BTreeSet<u32>,
    objects: Vec<BoundObject>,
    number: u32,
}

impl BoundAnimation {
    /// Binds an animation to a scene imported from its file, or baked from it at rest or at a time. Takes about a
    /// microsecond per movable vertex.
    ///
    /// # Errors
    /// A scene with other objects, or with objects of another shape.
    pub fn new(animation: impl Into<Arc<Animation>>, scene: &Scene) -> Result<Self, AnimationError> {
        let animation = animation.into();
        check_objects(&animation, scene)?;
        let state = match &scene.clip_time {
            Some(time) => animation.clips[animation.clip(Some(&time.clip))?].state_at(time.seconds, &animation.nodes),
            None => animation.nodes.at_rest(),
        };
        let (as_baked, mesh) = (animation.posture(state), scene.unplaced());
        let (objects, most) = (Objects::of(scene), MOST_DISTANCE * mesh.bounds().diagonal());
        let moving: Vec<u32> = animation.moving_objects().collect();
        let bind = |&object: &u32| {
            BoundObject::new(object, animation.shapes_of(object), &as_baked, &mesh, objects.vertices(object))
        };
        let bound: Vec<(BoundObject, f32)> = moving.par_iter().map(bind).collect();
        if let Some((object, distance)) = bound.iter().find(|(_, distance)| !(*distance <= most)) {
            let name = scene.objects[object.object as usize].name.clone();
            return Err(AnimationError::OtherShape { path: animation.path.clone(), object: name, distance: *distance });
        }
        let objects = bound.into_iter().map(|(object, _)| object).collect();
        let (placed, hidden) = (scene.placed.clone(), scene.hidden.keys().copied().collect());
        Ok(Self { animation, as_baked, placed, hidden, objects, number: NEXT.fetch_add(1, Ordering::Relaxed) })
    }

    /// The clips.
    pub fn clips(&self) -> &[Clip] {
        &self.animation.clips
    }

    /// The bound animation.
    pub fn animation(&self) -> &Animation {
        &self.animation
    }

    /// The objects that some clip can move, by index.
    pub fn objects(&self) -> impl Iterator<Item = u32> {
        self.objects.iter().map(|object| object.object)
    }

    /// `poses` with objects deformed at a time of a clip, in seconds, clamped to the clip. The clip is an index into
    /// [`Self::clips`]. The objects' own poses stay; deformations of other clips and times are replaced.
    ///
    /// # Errors
    /// A missing clip, or vertices out of reach.
    pub fn poses_at(&self, clip: usize, seconds: f32, poses: &Poses) -> Result<Poses, AnimationError> {
        let (number, index) = (self.number, clip);
        let clip = self.clips().get(clip).ok_or_else(|| self.animation.no_clip(&format!("number {index}")))?;
        let seconds = clip.time_at(seconds, super::Playback::Once);
        let posture = self.animation.posture(clip.state_at(seconds, &self.animation.nodes));
        let posed = self.poses_in(&posture, [number, index as u32, seconds.to_bits()], poses);
        let are_within_reach =
            |deformed: &DeformedObject| deformed.vertices().positions.iter().all(|place| is_within_reach(*place));
        match self.objects().find(|&object| !posed.deformed(object).is_none_or(are_within_reach)) {
            Some(object) => {
                let object = self.animation.objects[object as usize].clone();
                let (path, clip) = (self.animation.path.clone(), clip.name.clone());
                Err(AnimationError::OutOfReach { path, clip, object, seconds })
            }
            None => Ok(posed.at(ClipTime { clip: clip.name.clone(), seconds })),
        }
    }

    /// `poses` with all objects at rest as in their file, for a scene baked at a time of a clip. The objects' own poses stay.
    pub fn poses_at_rest(&self, poses: &Poses) -> Poses {
        let posture = self.animation.posture(self.animation.nodes.at_rest());
        self.poses_in(&posture, [self.number, AT_REST, 0], poses)
    }

    /// `poses` with objects deformed by a posture. Each revision identifies one posture.
    fn poses_in(&self, posture: &Posture, revision: [u32; 3], poses: &Poses) -> Poses {
        let mut posed = poses.without_deformed();
        let deformed: Vec<_> = self.objects.par_iter().map(|object| self.deformed(object, posture)).collect();
        for (object, vertices) in self.objects.iter().zip(deformed) {
            posed.deform(object.object, vertices.map(|vertices| DeformedObject::new(vertices, revision)));
        }
        // An object that the bake hid is a point, or it has its vertices again.
        for &object in &self.hidden {
            let (shown, in_time) = (poses.deformed(object), posed.deformed(object));
            posed.deform(object, shown.map(|shown| in_time.unwrap_or(shown).clone()));
        }
        posed
    }

    fn deformed(&self, object: &BoundObject, posture: &Posture) -> Option<PosedVertices> {
        let shapes = self.animation.shapes_of(object.object);
        let is_as_baked = shapes.iter().all(|shape| shape.is_same(&self.as_baked, posture));
        let posed = if is_as_baked { None } else { object.posed(shapes, posture) }?;
        Some(match self.placed.iter().find(|placed| placed.object == object.object) {
            Some(placed) => posed.turned(placed.baked_from_file(), placed.pose.rotation()),
            None => posed,
        })
    }
}

/// Checks that a scene has the objects of a file, by name and in order. A ground follows them.
fn check_objects(animation: &Animation, scene: &Scene) -> Result<(), AnimationError> {
    let of_scene = (0..).zip(&scene.objects).filter(|(object, _)| scene.mesh.ground_object() != Some(*object));
    // Older bakes have equal names.
    let names = told_apart(of_scene.map(|(_, Object { name })| name.clone()).collect());
    let of_file = &animation.objects;
    if names == *of_file {
        return Ok(());
    }
    let path = animation.path.clone();
    Err(match of_file.iter().zip(&names).find(|(a, b)| a != b).filter(|_| names.len() == of_file.len()) {
        Some((found, expected)) => {
            AnimationError::OtherObject { path, found: found.clone(), expected: expected.clone() }
        }
        None => AnimationError::OtherCount { path, found: of_file.len(), expected: names.len() },
    })
}
