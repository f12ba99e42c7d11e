//! Poses of a scene's objects, relative to the bake.
//!
//! A pose scales and turns an object about the center of its box, then moves it. An animation deforms the object first.
//! The triangles stay the same, so baked data of a vertex is found by its index under any pose.

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
    scene::Scene,
};
use glam::{Affine3A, EulerRot, Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};

/// Largest scale; its inverse is the smallest.
pub const MOST_SCALE: f32 = 1e4;

/// Most objects in a scene whose objects are posed. Each has trees and grids of its own, and many loops visit all of them.
pub const MOST_OBJECTS: usize = 65_536;

/// Checks that a scene's objects can be posed one by one.
///
/// # Errors
/// More than [`MOST_OBJECTS`].
pub fn check_objects(scene: &Scene) -> Result<(), MeshError> {
    let (found, most) = (scene.objects.len(), MOST_OBJECTS);
    if found <= most { Ok(()) } else { Err(MeshError::TooManyObjects { found, most }) }
}

/// Pose of an object relative to the bake.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pose {
    /// Translation in meters.
    pub translate: Vec3,
    /// Rotation about the world's axes through the center of the object as baked, in degrees: first about X, then Y, then Z.
    pub rotate_degrees: Vec3,
    /// Scale, 1 as baked; above 0, at most [`MOST_SCALE`].
    pub scale: f32,
    /// Whether the object is hidden: no ray meets it and no picture shows it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub hidden: bool,
}

impl Default for Pose {
    fn default() -> Self {
        Self::AS_BAKED
    }
}

impl Pose {
    /// The baked pose.
    pub const AS_BAKED: Self = Self { translate: Vec3::ZERO, rotate_degrees: Vec3::ZERO, scale: 1.0, hidden: false };

    /// The same pose of the object shown.
    pub fn shown(self) -> Self {
        Self { hidden: false, ..self }
    }

    /// The rotation as a quaternion.
    pub fn rotation(&self) -> Quat {
        let Vec3 { x, y, z } = self.rotate_degrees.map(f32::to_radians);
        Quat::from_euler(EulerRot::XYZEx, x, y, z)
    }

    /// The same pose with another rotation.
    pub fn with_rotation(self, rotation: Quat) -> Self {
        let (x, y, z) = rotation.to_euler(EulerRot::XYZEx);
        Self { rotate_degrees: Vec3::new(x, y, z).map(f32::to_degrees), ..self }
    }

    /// The part of its rotation about a unit direction of the baked object, in degrees, -180 to 180: the twist of a swing-twist
    /// decomposition.
    pub fn degrees_about(&self, direction: Vec3) -> f32 {
        let rotation = self.rotation();
        let along = rotation.xyz().dot(direction);
        let half = along.atan2(rotation.w);
        wrapped_degrees(2.0 * half.to_degrees())
    }

    /// Turned further about a unit direction of the baked object, by degrees.
    pub fn turned_about(self, direction: Vec3, degrees: f32) -> Self {
        if degrees == 0.0 {
            return self;
        }
        self.with_rotation(self.rotation() * Quat::from_axis_angle(direction, degrees.to_radians()))
    }

    /// Transform from the baked to the posed object, whose baked center is `center`, in meters.
    pub fn world_from_baked(&self, center: Vec3) -> Affine3A {
        let about_center =
            Affine3A::from_scale_rotation_translation(Vec3::splat(self.scale), self.rotation(), Vec3::ZERO);
        Affine3A::from_translation(center + self.translate) * about_center * Affine3A::from_translation(-center)
    }
}

/// The same angle between -180 and 180 degrees.
fn wrapped_degrees(degrees: f32) -> f32 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

/// A time in an animation clip.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ClipTime {
    /// Name of the clip.
    pub clip: String,
    /// Seconds from its beginning.
    pub seconds: f32,
}

/// Poses by object index; only objects that differ from the bake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Poses {
    of_object: BTreeMap<u32, Pose>,
    deformed: BTreeMap<u32, DeformedObject>,
    clip_time: Option<ClipTime>,
}

impl Poses {
    /// Whether no object differs from the bake.
    pub fn is_empty(&self) -> bool {
        self.of_object.is_empty() && self.deformed.is_empty()
    }

    /// The rigid pose of an object.
    pub fn of(&self, object: u32) -> Pose {
        self.of_object.get(&object).copied().unwrap_or_default()
    }

    /// Whether an object is as baked.
    pub fn is_as_baked(&self, object: u32) -> bool {
        !self.of_object.contains_key(&object) && !self.deformed.contains_key(&object)
    }

    /// The vertices of a deformed object. Its pose applies on top, about its baked center.
    pub fn deformed(&self, object: u32) -> Option<&DeformedObject> {
        self.deformed.get(&object)
    }

    /// Deforms an object, or restores its baked vertices.
    pub fn deform(&mut self, object: u32, deformed: Option<DeformedObject>) {
        match deformed {
            Some(deformed) => self.deformed.insert(object, deformed),
            None => self.deformed.remove(&object),
        };
        self.clip_time = None;
    }

    /// The animation time of the deformed objects, if known.
    pub fn clip_time(&self) -> Option<&ClipTime> {
        self.clip_time.as_ref()
    }

    /// The same poses with a known animation time, if anything is deformed. Other deformed objects have no known time.
    pub fn at(self, time: ClipTime) -> Self {
        Self { clip_time: Some(time).filter(|_| !self.deformed.is_empty()), ..self }
    }

    /// Indices of the hidden objects.
    pub fn hidden(&self) -> impl Iterator<Item = u32> {
        self.of_object.iter().filter(|(_, pose)| pose.hidden).map(|(&object, _)| object)
    }

    /// Whether an object is hidden.
    pub fn has_hidden(&self) -> bool {
        self.hidden().next().is_some()
    }

    /// The same poses with all objects shown.
    pub fn all_shown(&self) -> Self {
        let mut shown = self.clone();
        self.hidden().for_each(|object| shown.set(object, self.of(object).shown()));
        shown
    }

    /// The same poses without deformed objects.
    pub fn without_deformed(&self) -> Self {
        Self { of_object: self.of_object.clone(), ..Self::default() }
    }

    /// Indices of the objects whose poses differ.
    pub fn differing<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = u32> + 'a {
        let all: BTreeSet<u32> = self.moved().chain(other.moved()).collect();
        let pose = |poses: &'a Self, object| (poses.of(object), poses.deformed(object));
        all.into_iter().filter(move |&object| pose(self, object) != pose(other, object))
    }

    /// Sets the pose of an object.
    pub fn set(&mut self, object: u32, pose: Pose) {
        self.replace(object, pose);
    }

    /// Sets the pose of an object and returns the old one.
    pub fn replace(&mut self, object: u32, pose: Pose) -> Pose {
        let before = match pose == Pose::AS_BAKED {
            true => self.of_object.remove(&object),
            false => self.of_object.insert(object, pose),
        };
        before.unwrap_or_default()
    }

    /// The same poses for objects with new indices, or `None` for removed ones.
    pub fn renumbered(&self, number: impl Fn(u32) -> Option<u32>) -> Self {
        let of_object = self.of_object.iter().filter_map(|(&object, &pose)| Some((number(object)?, pose))).collect();
        let deformed = self.deformed.iter().filter_map(|(&object, shape)| Some((number(object)?, shape.clone())));
        Self { of_object, deformed: deformed.collect(), clip_time: None }
    }

    /// Indices of the moved objects.
    pub fn moved(&self) -> impl Iterator<Item = u32> {
        let all: BTreeSet<u32> = self.of_object.keys().chain(self.deformed.keys()).copied().collect();
        all.into_iter()
    }

    /// The mesh with posed objects. A hidden object is a point.
    ///
    /// # Errors
    /// Places beyond [`MOST_COORDINATE`](crate::bounds::MOST_COORDINATE), vertices of a deformed object that do not
    /// match the mesh, or a scene whose objects are all hidden.
    pub fn pose(&self, mesh: &Mesh, objects: &Objects) -> Result<Mesh, MeshError> {
        let mut posed = mesh.clone();
        for (&object, deformed) in self.deformed.iter().filter(|(object, _)| (**object as usize) < objects.len()) {
            deformed.put(&mut posed, object, objects.vertices(object))?;
        }
        for (&object, pose) in self.of_object.iter().filter(|(object, _)| (**object as usize) < objects.len()) {
            pose_vertices(&mut posed, objects.vertices(object), pose, objects.center(object));
        }
        check_extent(posed.positions[..posed.vertices_of_scene()].iter().copied())?;
        if self.has_hidden() {
            for object in self.hidden().filter(|&object| (object as usize) < objects.len()) {
                posed.collapse(objects.vertices(object), objects.center(object) + self.of(object).translate);
            }
            check_shown(&posed)?;
        }
        Ok(posed)
    }
}

/// Checks that hidden objects leave something to see.
pub(super) fn check_shown(mesh: &Mesh) -> Result<(), MeshError> {
    let places = mesh.positions[..mesh.vertices_of_scene()].iter().copied();
    check_extent(places).map_err(|_| MeshError::NothingShown)
}

fn pose_vertices(mesh: &mut Mesh, vertices: &[u32], pose: &Pose, center: Vec3) {
    let (world_from_baked, rotation) = (pose.world_from_baked(center), pose.rotation());
    vertices.iter().for_each(|&vertex| mesh.turn_vertex(vertex as usize, world_from_baked, rotation));
}

/// The vertices of each object of a mesh, and the centers of rotation.
#[derive(Clone, Debug, Default)]
pub struct Objects {
    vertices: Vec<u32>,
    ranges: Vec<Range<usize>>,
    centers: Vec<Vec3>,
}

impl Objects {
    /// The objects of a mesh as baked, with indices below `count`.
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

    /// Number of objects.
    pub fn len(&self) -> usize {
        self.ranges.len()
    }

    /// Whether there are no objects.
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Vertex indices of an object.
    pub fn vertices(&self, object: u32) -> &[u32] {
        &self.vertices[self.ranges[object as usize].clone()]
    }

    /// Center of the box around an object as baked, in meters.
    pub fn center(&self, object: u32) -> Vec3 {
        self.centers[object as usize]
    }
}

#[cfg(test)]
mod tests;
