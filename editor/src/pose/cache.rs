//! Caches posed scenes, and animations bound to bakes.

use crate::{document::Document, viewport::gizmo::Subject};
use glam::Vec3;
use lapidary_core::{
    animation::{Animation, BoundAnimation, ClipTime},
    bounds::Bounds,
    scene::{
        Scene,
        pose::{Objects, Poses},
    },
};
use lapidary_render::Baked;
use std::{cell::RefCell, sync::Arc};

/// Cached poses of a document.
#[derive(Default)]
pub struct PoseCache {
    /// The last posed scene.
    posed: RefCell<Option<Posed>>,
    /// The animation of the scene, bound to its bake.
    bound: RefCell<Option<Bound>>,
    /// Poses at the time requested last.
    in_time: RefCell<Option<InTime>>,
    /// The objects of the scene as it was baked.
    objects: RefCell<Option<(Baked, Arc<Objects>)>>,
}

/// An animation bound to a bake, or why it cannot be.
struct Bound {
    baked: Baked,
    animation: Arc<Animation>,
    bound: Result<Arc<BoundAnimation>, String>,
}

/// Poses at a time of an animation, relative to a bake, and their inputs.
struct InTime {
    baked: Baked,
    animation: Option<Arc<Animation>>,
    of_file: Poses,
    time: Option<ClipTime>,
    found: Result<Poses, String>,
}

/// A posed scene, and its poses.
struct Posed {
    baked: Baked,
    poses: Poses,
    posed: Baked,
}

impl PoseCache {
    /// An animation bound to a bake.
    ///
    /// # Errors
    /// In words, why it does not fit.
    pub fn bound(&self, animation: &Arc<Animation>, baked: &Baked) -> Result<Arc<BoundAnimation>, String> {
        let mut known = self.bound.borrow_mut();
        let is_same = |known: &Bound| known.baked.is_same(baked) && Arc::ptr_eq(&known.animation, animation);
        if !known.as_ref().is_some_and(is_same) {
            let bound = BoundAnimation::new(animation.clone(), &baked.dataset.scene);
            let bound = bound.map(Arc::new).map_err(|error| error.to_string());
            *known = Some(Bound { baked: baked.clone(), animation: animation.clone(), bound });
        }
        known.as_ref().map_or_else(|| Err(String::new()), |known| known.bound.clone())
    }

    /// Poses of a document relative to a bake: its own, and those of its animation at its time. Objects without a pose at that
    /// time stay as baked.
    pub fn poses_since(&self, document: &Document, animation: Option<&Arc<Animation>>, baked: &Baked) -> Poses {
        let in_time = self.in_time(document, animation, baked);
        in_time.unwrap_or_else(|_| baked.dataset.scene.poses_since_baked(&document.poses))
    }

    /// Poses of a document relative to a bake: its own, and those of its animation at its time.
    ///
    /// # Errors
    /// In words, why there are no poses at that time.
    pub fn in_time(
        &self,
        document: &Document,
        animation: Option<&Arc<Animation>>,
        baked: &Baked,
    ) -> Result<Poses, String> {
        let mut known = self.in_time.borrow_mut();
        let is_same = |known: &InTime| {
            let animations = [known.animation.as_ref(), animation].map(|animation| animation.map(Arc::as_ptr));
            known.baked.is_same(baked)
                && animations[0] == animations[1]
                && known.of_file == document.poses
                && known.time == document.clip_time
        };
        if let Some(known) = known.as_ref().filter(|known| is_same(known)) {
            return known.found.clone();
        }
        let found = self.find_in_time(document, animation, baked);
        *known = Some(InTime {
            baked: baked.clone(),
            animation: animation.cloned(),
            of_file: document.poses.clone(),
            time: document.clip_time.clone(),
            found: found.clone(),
        });
        found
    }

    fn find_in_time(
        &self,
        document: &Document,
        animation: Option<&Arc<Animation>>,
        baked: &Baked,
    ) -> Result<Poses, String> {
        let (scene, time) = (&baked.dataset.scene, document.clip_time.as_ref());
        let poses = scene.poses_since_baked(&document.poses);
        let is_at_rest = time.is_none() && scene.clip_time.is_none();
        let Some(animation) = animation.filter(|_| !is_at_rest) else { return Ok(poses) };
        let bound = self.bound(animation, baked)?;
        let Some(ClipTime { clip, seconds }) = time else { return Ok(bound.poses_at_rest(&poses)) };
        let posed = animation.clip(Some(clip)).and_then(|clip| bound.poses_at(clip, *seconds, &poses));
        posed.map_err(|error| error.to_string())
    }

    /// The posed scene, for picking. While a button is held it is the previous one, since posing takes longer than a frame should.
    /// Objects that cannot be posed stay in place.
    pub fn posed(&self, poses: Poses, baked: &Baked, is_held: bool) -> Baked {
        if poses.is_empty() {
            return baked.clone();
        }
        let mut known = self.posed.borrow_mut();
        let of_scene = known.as_ref().filter(|known| known.baked.is_same(baked));
        match of_scene {
            Some(known) if is_held || known.poses == poses => return known.posed.clone(),
            None if is_held || baked.intersector_if_ready().is_none() => return baked.clone(),
            _ => {}
        }
        let before = of_scene.map_or(baked, |known| &known.posed);
        let posed = baked.posed(&poses).unwrap_or_else(|_| before.clone());
        *known = Some(Posed { baked: baked.clone(), poses, posed: posed.clone() });
        posed
    }

    /// The objects of a bake.
    pub fn objects(&self, baked: &Baked) -> Arc<Objects> {
        let mut known = self.objects.borrow_mut();
        match &*known {
            Some((of, objects)) if of.is_same(baked) => objects.clone(),
            _ => known.insert((baked.clone(), Arc::new(Objects::of(&baked.dataset.scene)))).1.clone(),
        }
    }

    /// An object for handles, under poses relative to a bake; `None` if it has no vertices.
    pub fn subject(&self, baked: &Baked, poses: &Poses, object: u32) -> Option<Subject> {
        let objects = self.objects(baked);
        if (object as usize) >= objects.len() || objects.vertices(object).is_empty() {
            return None;
        }
        let (scene, as_baked) = (&baked.dataset.scene, objects.center(object));
        let center = scene.center_in_file(object).unwrap_or(as_baked);
        let middle = match poses.deformed(object) {
            Some(deformed) => Some(Bounds::around(deformed.vertices().positions.iter().copied()).center()),
            None => scene.clip_time.as_ref().map(|_| as_baked),
        };
        let middle = middle.map_or(center, |middle| without_pose(scene, object, middle));
        Some(Subject { object, center, middle, hinge: None })
    }
}

/// Moves a point of an object as baked, in meters, to its position without the baked pose.
fn without_pose(scene: &Scene, object: u32, place: Vec3) -> Vec3 {
    let placed = scene.placed.iter().find(|placed| placed.object == object);
    placed.map_or(place, |placed| placed.pose.world_from_baked(placed.center).inverse().transform_point3(place))
}
