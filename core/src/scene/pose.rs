//! Where the objects of a scene are, beside where they were baked.
//!
//! A pose scales and turns an object about the center of its box, and then moves it. An animation deforms it before that. All triangles
//! stay the same, so that what a bake says of a vertex is found by its index under any pose.

mod check;
mod deformed;
mod file;
mod similarity;

pub use check::PoseError;
pub use deformed::{DeformedObject, PosedVertices};
pub use file::PoseFileError;
pub use similarity::Similarity;

use crate::{
    bounds::Bounds,
    mesh::{Mesh, MeshError, check_extent},
};
use glam::{Affine3A, EulerRot, Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};

/// The largest scale, and the inverse of the least.
pub const MOST_SCALE: f32 = 1e4;

/// Where an object is, relative to where it was baked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pose {
    /// In meters.
    pub translate: Vec3,
    /// Turns about the world's axes through the center of the object as baked, in degrees: first about X, then Y, then Z.
    pub rotate_degrees: Vec3,
    /// Size, 1 as baked; above 0, at most [`MOST_SCALE`].
    pub scale: f32,
}

impl Default for Pose {
    fn default() -> Self {
        Self::AS_BAKED
    }
}

impl Pose {
    /// Where it was baked.
    pub const AS_BAKED: Self = Self { translate: Vec3::ZERO, rotate_degrees: Vec3::ZERO, scale: 1.0 };

    /// The turn.
    pub fn rotation(&self) -> Quat {
        let Vec3 { x, y, z } = self.rotate_degrees.map(f32::to_radians);
        Quat::from_euler(EulerRot::XYZEx, x, y, z)
    }

    /// The same with another turn.
    pub fn with_rotation(self, rotation: Quat) -> Self {
        let (x, y, z) = rotation.to_euler(EulerRot::XYZEx);
        Self { rotate_degrees: Vec3::new(x, y, z).map(f32::to_degrees), ..self }
    }

    /// From the place where an object with this center was baked to where it is, in meters.
    pub fn world_from_baked(&self, center: Vec3) -> Affine3A {
        let about_center =
            Affine3A::from_scale_rotation_translation(Vec3::splat(self.scale), self.rotation(), Vec3::ZERO);
        Affine3A::from_translation(center + self.translate) * about_center * Affine3A::from_translation(-center)
    }
}

/// A time of a clip of an animation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ClipTime {
    /// Name of the clip.
    pub clip: String,
    /// In seconds from its beginning.
    pub seconds: f32,
}

/// The poses of the objects that are not where they were baked, by index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Poses {
    of_object: BTreeMap<u32, Pose>,
    deformed: BTreeMap<u32, DeformedObject>,
    clip_time: Option<ClipTime>,
}

impl Poses {
    /// Whether all is as it was baked.
    pub fn is_empty(&self) -> bool {
        self.of_object.is_empty() && self.deformed.is_empty()
    }

    /// The pose of an object, by which it is moved as a whole.
    pub fn of(&self, object: u32) -> Pose {
        self.of_object.get(&object).copied().unwrap_or_default()
    }

    /// Whether an object is where it was baked.
    pub fn is_as_baked(&self, object: u32) -> bool {
        !self.of_object.contains_key(&object) && !self.deformed.contains_key(&object)
    }

    /// The vertices of an object, if it is deformed; its pose comes on top, about its center as baked.
    pub fn deformed(&self, object: u32) -> Option<&DeformedObject> {
        self.deformed.get(&object)
    }

    /// Deforms an object, or lets it be as it was baked.
    pub fn deform(&mut self, object: u32, deformed: Option<DeformedObject>) {
        match deformed {
            Some(deformed) => self.deformed.insert(object, deformed),
            None => self.deformed.remove(&object),
        };
        self.clip_time = None;
    }

    /// When in an animation the deformed objects are as they are, if that is known.
    pub fn clip_time(&self) -> Option<&ClipTime> {
        self.clip_time.as_ref()
    }

    /// The same, known to be deformed as at a time of an animation, if anything is deformed. Other deformed objects are of no known time.
    pub fn at(self, time: ClipTime) -> Self {
        Self { clip_time: Some(time).filter(|_| !self.deformed.is_empty()), ..self }
    }

    /// The same without deformed objects.
    pub fn without_deformed(&self) -> Self {
        Self { of_object: self.of_object.clone(), ..Self::default() }
    }

    /// The objects that are not in the same place by both, by index.
    pub fn differing<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = u32> + 'a {
        let all: BTreeSet<u32> = self.moved().chain(other.moved()).collect();
        let pose = |poses: &'a Self, object| (poses.of(object), poses.deformed(object));
        all.into_iter().filter(move |&object| pose(self, object) != pose(other, object))
    }

    /// Poses an object.
    pub fn set(&mut self, object: u32, pose: Pose) {
        self.replace(object, pose);
    }

    /// Poses an object, and returns the pose that it had.
    pub fn replace(&mut self, object: u32, pose: Pose) -> Pose {
        let before = match pose == Pose::AS_BAKED {
            true => self.of_object.remove(&object),
            false => self.of_object.insert(object, pose),
        };
        before.unwrap_or_default()
    }

    /// The same for objects that have other numbers, or are gone.
    pub fn renumbered(&self, number: impl Fn(u32) -> Option<u32>) -> Self {
        let of_object = self.of_object.iter().filter_map(|(&object, &pose)| Some((number(object)?, pose))).collect();
        let deformed = self.deformed.iter().filter_map(|(&object, shape)| Some((number(object)?, shape.clone())));
        Self { of_object, deformed: deformed.collect(), clip_time: None }
    }

    /// The objects that are elsewhere, by index.
    pub fn moved(&self) -> impl Iterator<Item = u32> {
        let all: BTreeSet<u32> = self.of_object.keys().chain(self.deformed.keys()).copied().collect();
        all.into_iter()
    }

    /// The mesh with its objects posed.
    ///
    /// # Errors
    /// Places beyond [`MOST_COORDINATE`](crate::bounds::MOST_COORDINATE), and vertices of a deformed object that are not those of the mesh.
    pub fn pose(&self, mesh: &Mesh, objects: &Objects) -> Result<Mesh, MeshError> {
        let mut posed = mesh.clone();
        for (&object, deformed) in self.deformed.iter().filter(|(object, _)| (**object as usize) < objects.len()) {
            deform_vertices(&mut posed, object, objects.vertices(object), deformed.vertices())?;
        }
        for (&object, pose) in self.of_object.iter().filter(|(object, _)| (**object as usize) < objects.len()) {
            pose_vertices(&mut posed, objects.vertices(object), pose, objects.center(object));
        }
        check_extent(posed.positions[..posed.vertices_of_scene()].iter().copied())?;
        Ok(posed)
    }
}

fn deform_vertices(mesh: &mut Mesh, object: u32, of: &[u32], posed: &PosedVertices) -> Result<(), MeshError> {
    let (found, expected) = (posed.positions.len(), of.len());
    if found != expected {
        return Err(MeshError::Deformed { object, found, expected });
    }
    for (k, vertex) in of.iter().map(|&vertex| vertex as usize).enumerate() {
        mesh.positions[vertex] = posed.positions[k];
        mesh.normals[vertex] = posed.normals[k];
        mesh.tangents[vertex] = posed.tangents[k];
    }
    Ok(())
}

fn pose_vertices(mesh: &mut Mesh, vertices: &[u32], pose: &Pose, center: Vec3) {
    let (world_from_baked, rotation) = (pose.world_from_baked(center), pose.rotation());
    vertices.iter().for_each(|&vertex| mesh.turn_vertex(vertex as usize, world_from_baked, rotation));
}

/// The vertices of each object of a mesh, and the centers that they turn about.
#[derive(Clone, Debug, Default)]
pub struct Objects {
    vertices: Vec<u32>,
    ranges: Vec<Range<usize>>,
    centers: Vec<Vec3>,
}

impl Objects {
    /// Those of a mesh, as it was baked, by their indices up to `count`.
    pub(super) fn of_mesh(mesh: &Mesh, count: usize) -> Self {
        let (positions, owner) = (&mesh.positions, mesh.owners());
        let mut vertices: Vec<u32> = (0..positions.len() as u32).filter(|&v| owner[v as usize] != u32::MAX).collect();
        vertices.sort_by_key(|&vertex| owner[vertex as usize]);
        let start = |object: u32| vertices.partition_point(|&vertex| owner[vertex as usize] < object);
        let ranges: Vec<_> = (0..count as u32).map(|object| start(object)..start(object + 1)).collect();
        let place = |&vertex: &u32| positions[vertex as usize];
        let center = |range: &Range<usize>| match range.is_empty() {
            true => Vec3::ZERO,
            false => Bounds::around(vertices[range.clone()].iter().map(place)).center(),
        };
        let centers = ranges.iter().map(center).collect();
        Self { centers, ranges, vertices }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ranges.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// The vertices of an object, by index.
    pub fn vertices(&self, object: u32) -> &[u32] {
        &self.vertices[self.ranges[object as usize].clone()]
    }

    /// The center of the box around an object as baked, in meters.
    pub fn center(&self, object: u32) -> Vec3 {
        self.centers[object as usize]
    }
}

#[cfg(test)]
mod tests;
