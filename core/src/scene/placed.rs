//! Objects that a bake has elsewhere, or deformed, beside the file of its scene.
//!
//! Poses of a document are relative to the file, those of a picture to the bake that it is made from.

use super::pose::{ClipTime, Pose, PosedVertices, Poses};
use glam::{Affine3A, Vec3};
use serde::{Deserialize, Serialize};

/// An object of a bake that is not where its file has it, or is deformed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// Its index.
    pub object: u32,
    /// Relative to the file; that of an object that is only deformed is [`Pose::AS_BAKED`].
    pub pose: Pose,
    /// The center of its box as its file has it, in meters.
    pub center: Vec3,
    /// The center of its box as baked, in meters.
    pub baked_center: Vec3,
}

impl Placed {
    fn world_from_file(&self, pose: &Pose) -> Affine3A {
        pose.world_from_baked(self.center)
    }

    /// From where its file has it to where it was baked.
    pub(crate) fn baked_from_file(&self) -> Affine3A {
        self.world_from_file(&self.pose)
    }

    /// A pose relative to the bake, from one relative to the file.
    pub(super) fn since_baked(&self, of_file: Pose) -> Pose {
        if of_file == self.pose {
            return Pose::AS_BAKED;
        }
        let from_baked = self.world_from_file(&of_file) * self.world_from_file(&self.pose).inverse();
        Pose {
            translate: from_baked.transform_point3(self.baked_center) - self.baked_center,
            scale: of_file.scale / self.pose.scale,
            ..Pose::AS_BAKED.with_rotation(of_file.rotation() * self.pose.rotation().inverse())
        }
    }

    /// Whether it can be of a scene with so many objects.
    pub(super) fn fits(&self, objects: usize) -> bool {
        let are_finite = self.center.is_finite() && self.baked_center.is_finite();
        (self.object as usize) < objects && are_finite && self.pose.validate("").is_ok()
    }
}

/// A hash of poses and of a time, as hexadecimal; `None` if all is as its file has it.
pub fn hash(poses: &Poses, time: Option<&ClipTime>) -> Option<String> {
    let mut hasher = blake3::Hasher::new();
    for object in poses.without_deformed().moved() {
        let Pose { translate, rotate_degrees, scale } = poses.of(object);
        hasher.update(&object.to_le_bytes());
        let numbers = [translate.to_array(), rotate_degrees.to_array(), [scale, 0.0, 0.0]];
        hasher.update(bytemuck::cast_slice(numbers.as_flattened()));
    }
    if let Some(ClipTime { clip, seconds }) = time {
        hasher.update(clip.as_bytes()).update(&seconds.to_le_bytes());
    }
    (hasher.count() > 0).then(|| hasher.finalize().to_hex().to_string())
}

/// A hash of the vertices that an animation deforms, as hexadecimal; `None` if there are none. They depend on keyframes, which neither
/// the scene nor [`hash`] has.
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
