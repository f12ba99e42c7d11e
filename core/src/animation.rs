//! Animations of glTF files: clips that move nodes, skins that follow them, and morph targets.
//!
//! An [`Animation`] is the motion stored in a file; the mesh stays with the scene, or with the dataset baked from it.
//! [`BoundAnimation`] binds the two, and gives poses at a time.
//!
//! From a time to a mesh:
//! * `keyframes`: values of a channel; `clip`: effect of a clip on the nodes
//! * `nodes`: the hierarchy; `skin`: joints; `surface`: transformation of vertices into the world; `shape`: all of these combined
//! * `nearest` and `binding`: from the vertices of the file to those of the bake; `sheets`: where the binding is ambiguous

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

/// The motion in a file.
#[derive(Debug)]
pub struct Animation {
    /// Path of the file.
    pub path: PathBuf,
    /// Its nodes.
    pub nodes: Nodes,
    /// Its skins.
    pub skins: Vec<Skin>,
    /// The playable clips, in the order of the file.
    pub clips: Vec<Clip>,
    /// Unplayable clips: their names and the reasons.
    pub broken: Vec<(String, String)>,
    /// Primitives that some clip moves, in the order of the objects.
    pub shapes: Vec<Shape>,
    /// Names of all objects of the file.
    pub objects: Vec<String>,
    /// Unusable parts of the file, with remedies.
    pub warnings: Vec<String>,
}

/// Why a file's animation cannot pose a scene.
#[derive(Debug, Error)]
pub enum AnimationError {
    /// The file has no clip.
    #[error("the file has no animation; export it with one ({})", path.display())]
    NoClips {
        /// Path of the file.
        path: PathBuf,
    },
    /// The file has no clip of this name.
    #[error("the file has no clip \"{name}\"; it has {} ({})", known.join(", "), path.display())]
    NoSuchClip {
        /// Path of the file.
        path: PathBuf,
        /// The requested name.
        name: String,
        /// Names of the clips.
        known: Vec<String>,
    },
    /// The clip is damaged.
    #[error("the clip \"{clip}\" cannot be played: {reason}; export it again ({})", path.display())]
    Broken {
        /// Path of the file.
        path: PathBuf,
        /// Name of the clip.
        clip: String,
        /// The problem and its place.
        reason: String,
    },
    /// The scene has another number of objects.
    #[error("the file has {found} objects, the scene {expected}; give the file that the scene was baked of, or bake it again ({})", path.display())]
    OtherCount {
        /// Path of the file.
        path: PathBuf,
        /// Objects of the file.
        found: usize,
        /// Objects of the scene.
        expected: usize,
    },
    /// The scene has another object at this index.
    #[error("the file has an object \"{found}\" where the scene has \"{expected}\"; give the file that the scene was baked of, or bake it again ({})", path.display())]
    OtherObject {
        /// Path of the file.
        path: PathBuf,
        /// Object of the file.
        found: String,
        /// Object of the scene.
        expected: String,
    },
    /// The object has another shape in the scene.
    #[error("\"{object}\" of the scene is up to {distance} m away from its shape in the file; give the file that the scene was baked of, or bake it again ({})", path.display())]
    OtherShape {
        /// Path of the file.
        path: PathBuf,
        /// Name of the object.
        object: String,
        /// The distance in meters.
        distance: f32,
    },
    /// A pose is not finite or out of reach.
    #[error("at {seconds} s the clip \"{clip}\" takes \"{object}\" out of reach, or to no place at all; repair its keyframes ({})", path.display())]
    OutOfReach {
        /// Path of the file.
        path: PathBuf,
        /// Name of the clip.
        clip: String,
        /// Name of the object.
        object: String,
        /// Time in seconds.
        seconds: f32,
    },
}

impl Animation {
    /// The index of a clip by name, or of the first clip without a name.
    ///
    /// # Errors
    /// A clip that is missing or damaged.
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

    /// Names of objects with surfaces that coincide at rest and move apart.
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
