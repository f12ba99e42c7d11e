//! Animations of glTF files: clips that move nodes, skins that follow them, and morph targets.
//!
//! An [`Animation`] is what a file says of motion; the mesh stays with the scene, or with the dataset that was baked of it.
//! [`BoundAnimation`] binds the two, and gives poses at a time.
//!
//! From a time to a mesh:
//! * `keyframes`: values of a channel; `clip`: what a clip does to the nodes
//! * `nodes`: the hierarchy; `skin`: joints; `surface`: vertices on their way into the world; `shape`: all of these together
//! * `nearest` and `binding`: from the vertices of the file to those of the bake; `sheets`: where that cannot be told

mod binding;
mod bound;
pub mod clip;
pub mod keyframes;
mod nearest;
pub mod nodes;
pub mod shape;
mod sheets;
pub mod skin;
pub mod surface;

pub use crate::scene::pose::ClipTime;
pub use bound::BoundAnimation;
pub use clip::{Clip, Playback};

use nodes::{NodeState, Nodes};
use shape::{Posture, Shape};
use skin::Skin;
use std::path::PathBuf;
use thiserror::Error;

/// What a file says of motion.
#[derive(Debug)]
pub struct Animation {
    /// The file.
    pub path: PathBuf,
    /// Its nodes.
    pub nodes: Nodes,
    /// Its skins.
    pub skins: Vec<Skin>,
    /// The clips that can be played, in the order of the file.
    pub clips: Vec<Clip>,
    /// Clips that cannot be played: their names, and why.
    pub broken: Vec<(String, String)>,
    /// What some clip moves, in the order of the objects.
    pub shapes: Vec<Shape>,
    /// Names of all objects of the file.
    pub objects: Vec<String>,
    /// What of the file cannot be used, and what to do.
    pub warnings: Vec<String>,
}

/// Why a scene cannot be posed by a file's animation.
#[derive(Debug, Error)]
pub enum AnimationError {
    /// It has no clip at all.
    #[error("the file has no animation; export it with one ({})", path.display())]
    NoClips {
        /// The file.
        path: PathBuf,
    },
    /// It has no clip of that name.
    #[error("the file has no clip \"{name}\"; it has {} ({})", known.join(", "), path.display())]
    NoSuchClip {
        /// The file.
        path: PathBuf,
        /// What was asked for.
        name: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// The clip is there, and damaged.
    #[error("the clip \"{clip}\" cannot be played: {reason}; export it again ({})", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// Which clip.
        clip: String,
        /// What is wrong, and where.
        reason: String,
    },
    /// The scene has more objects, or fewer.
    #[error("the file has {found} objects, the scene {expected}; give the file that the scene was baked of, or bake it again ({})", path.display())]
    OtherCount {
        /// The file.
        path: PathBuf,
        /// Objects of the file.
        found: usize,
        /// Objects of the scene.
        expected: usize,
    },
    /// The scene has another object in its place.
    #[error("the file has an object \"{found}\" where the scene has \"{expected}\"; give the file that the scene was baked of, or bake it again ({})", path.display())]
    OtherObject {
        /// The file.
        path: PathBuf,
        /// Object of the file.
        found: String,
        /// Object of the scene.
        expected: String,
    },
    /// The object has another shape in the scene.
    #[error("\"{object}\" of the scene is up to {distance} m away from that of the file; give the file that the scene was baked of, or bake it again ({})", path.display())]
    OtherShape {
        /// The file.
        path: PathBuf,
        /// Which object.
        object: String,
        /// In meters.
        distance: f32,
    },
    /// A pose that is no pose.
    #[error("at {seconds} s the clip \"{clip}\" takes \"{object}\" out of reach, or to no place at all; repair its keyframes ({})", path.display())]
    OutOfReach {
        /// The file.
        path: PathBuf,
        /// Which clip.
        clip: String,
        /// Which object.
        object: String,
        /// When.
        seconds: f32,
    },
}

impl Animation {
    /// The index of a clip by its name; without one, of the first.
    ///
    /// # Errors
    /// A clip that is not there, or damaged.
    pub fn clip(&self, name: Option<&str>) -> Result<usize, AnimationError> {
        let is_meant = |known: &str| name.is_none_or(|name| name == known);
        let path = || self.path.clone();
        if let Some(index) = self.clips.iter().position(|clip| is_meant(&clip.name)) {
            return Ok(index);
        }
        if let Some((clip, reason)) = self.broken.iter().find(|(known, _)| is_meant(known)) {
            return Err(AnimationError::Broken { path: path(), clip: clip.clone(), reason: reason.clone() });
        }
        Err(name.map_or_else(|| AnimationError::NoClips { path: path() }, |name| self.no_clip(name)))
    }

    /// Names of objects with surfaces that are in one place at rest and move apart.
    pub fn parting_objects(&self) -> Vec<String> {
        let at_rest = self.posture(self.nodes.at_rest());
        let part = |&object: &u32| sheets::meet_and_part(self.shapes_of(object), &at_rest);
        self.moving_objects().filter(part).map(|object| self.objects[object as usize].clone()).collect()
    }

    fn no_clip(&self, name: &str) -> AnimationError {
        let known = self.clips.iter().map(|clip| format!("\"{}\"", clip.name)).collect();
        AnimationError::NoSuchClip { path: self.path.clone(), name: name.to_owned(), known }
    }

    fn posture(&self, state: NodeState) -> Posture {
        Posture::new(&self.nodes, &self.skins, state)
    }

    /// The objects of its shapes.
    fn moving_objects(&self) -> impl Iterator<Item = u32> {
        self.shapes.chunk_by(|a, b| a.object == b.object).map(|shapes| shapes[0].object)
    }

    fn shapes_of(&self, object: u32) -> &[Shape] {
        let end = |last: u32| self.shapes.partition_point(|shape| shape.object <= last);
        let start = self.shapes.partition_point(|shape| shape.object < object);
        &self.shapes[start..end(object)]
    }
}
