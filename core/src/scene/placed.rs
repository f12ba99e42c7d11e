//! Objects that a bake moved or deformed relative to its scene file.
//!
//! Poses of a document are relative to the file, poses of a picture to its bake.

use super::pose::{ClipTime, Pose, PosedVertices, Poses};
use glam::{Affine3A, Vec3};
use serde::{Deserialize, Serialize};

/// An object that a bake moved or deformed relative to its file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// Index of the object.
    pub object: u32,
    /// Pose relative to the file; [`Pose::AS_BAKED`] for an object that is only deformed.
    pub pose: Pose,
    /// Center of its box in the file, in meters.
    pub center: Vec3,
    /// The center of its box as baked, in meters.
    pub baked_center: Vec3,
}

impl Placed {
    fn world_from_file(&self, pose: &Pose) -> Affine3A {
        pose.world_from_baked(self.center)
    }

    /// Transform from its place in the file to its place in the bake.
    pub(crate) fn baked_from_file(&self) -> Affine3A {
        self.world_from_file(&self.pose)
    }

    /// Converts a pose relative to the file to one relative to the bake.
    pub(super) fn since_baked(&self, of_file: Pose) -> Pose {
        // An object that the bake hid stays a point until its vertices are put back; see `Scene::poses_since_baked`.
        let hidden = of_file.hidden && !self.pose.hidden;
        if of_file.shown() == self.pose.shown() {
            return Pose { hidden, ..Pose::AS_BAKED };
        }
        let from_baked = self.world_from_file(&of_file) * self.world_from_file(&self.pose).inverse();
        Pose {
            translate: from_baked.transform_point3(self.baked_center) - self.baked_center,
            scale: of_file.scale / self.pose.scale,
            hidden,
            ..Pose::AS_BAKED.with_rotation(of_file.rotation() * self.pose.rotation().inverse())
        }
    }

    /// Whether it is valid in a scene of `objects` objects.
    pub(super) fn fits(&self, objects: usize) -> bool {
        let are_finite = self.center.is_finite() && self.baked_center.is_finite();
        (self.object as usize) < objects && are_finite && self.pose.validate("").is_ok()
    }
}

/// A hash of poses and a time, in hexadecimal; `None` if everything is as in the file. Hidden objects count as shown: so they are
/// when a bake begins.
pub fn hash(poses: &Poses, time: Option<&ClipTime>) -> Option<String> {
    let mut hasher = blake3::Hasher::new();
    let poses = poses.all_shown();
    for object in poses.without_deformed().moved() {
        let Pose { translate, rotate_degrees, scale, .. } = poses.of(object);
        hasher.update(&object.to_le_bytes());
        let numbers = [translate.to_array(), rotate_degrees.to_array(), [scale, 0.0, 0.0]];
        hasher.update(bytemuck::cast_slice(numbers.as_flattened()));
    }
    if let Some(ClipTime { clip, seconds }) = time {
        hasher.update(clip.as_bytes()).update(&seconds.to_le_bytes());
    }
    (hasher.count() > 0).then(|| hasher.finalize().to_hex().to_string())
}

/// A hash of the vertices that an animation deforms, in hexadecimal; `None` if there are none. They depend on
/// keyframes, which neither the scene nor [`hash`] covers.
pub fn deformed_hash(poses: &Poses) -> Option<String> {
    let mut hasher = blake3::Hasher::new();
    for (object, deformed) in poses.moved().filter_map(|object| Some((object, poses.deformed(object)?))) {
        let PosedVertices { positions, normals, tangents } = deformed.vertices();
        hasher.update(&object.to_le_bytes()).update(&(positions.len() as u64).to_le_bytes());
        hasher.update(bytemuck::cast_slice(positions));
        hasher.update(bytemuck::cast_slice(normals)).update(bytemuck::cast_slice(tangents));
    }
    (hasher.count() > 0).then(|| hasher.finalize().to_hex().to_string())
}
