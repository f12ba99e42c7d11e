//! Animations of glTF files: clips that move nodes, skins that follow them, and morph targets.
//!
//! [`Animation::read`] reads what a file says of motion; the mesh stays with the scene, or with the dataset that was baked of it.
//! [`BoundAnimation`] binds the two, and gives poses at a time.
//!
//! From a time to a mesh:
//! * `keyframes`: values of a channel; `clip`: what a clip does to the nodes
//! * `nodes`: the hierarchy; `skin`: joints; `surface`: vertices on their way into the world; `shape`: all of these together
//! * `nearest` and `binding`: from the vertices of the file to those of the bake; `sheets`: where that cannot be told

mod binding;
mod bound;
pub(crate) mod clip;
pub(crate) mod keyframes;
mod nearest;
pub(crate) mod nodes;
pub(crate) mod shape;
mod sheets;
pub(crate) mod skin;
pub(crate) mod surface;

pub use bound::BoundAnimation;
pub use clip::{Clip, Playback};

use crate::import::{self, ImportError, ImportOptions};
use nodes::{NodeState, Nodes};
use serde::{Deserialize, Serialize};
use shape::{Posture, Shape};
use skin::Skin;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What a file says of motion.
#[derive(Debug)]
pub struct Animation {
    pub(crate) path: PathBuf,
    pub(crate) nodes: Nodes,
    pub(crate) skins: Vec<Skin>,
    pub(crate) clips: Vec<Clip>,
    /// Clips that cannot be played: their names, and why.
    pub(crate) broken: Vec<(String, String)>,
    /// What some clip moves, in the order of the objects.
    pub(crate) shapes: Vec<Shape>,
    /// Names of all objects of the file.
    pub(crate) objects: Vec<String>,
    pub(crate) warnings: Vec<String>,
}

/// A time of a clip.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ClipTime {
    /// Name of the clip.
    pub clip: String,
    /// In seconds from its beginning.
    pub seconds: f32,
}

/// Why a scene cannot be posed by a file's animation.
#[derive(Debug, Error)]
pub enum AnimationError {
    /// The file cannot be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A format without animations.
    #[error("only .gltf and .glb files hold animations; give the file that the scene was baked of ({})", path.display())]
    NoGltf {
        /// The file.
        path: PathBuf,
    },
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
        /// In metres.
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
    /// Reads a glTF or GLB file. Pictures are not read. Skins, morph targets and clips that cannot be used are left out, see
    /// [`Self::warnings`].
    ///
    /// # Errors
    /// A file that cannot be read, or has no clip that can be played.
    pub fn read(path: &Path, options: &ImportOptions) -> Result<Self, AnimationError> {
        if !import::is_gltf(path) {
            return Err(AnimationError::NoGltf { path: path.into() });
        }
        let mut animation = import::animation(path, options)?;
        animation.clip(None).map(drop)?;
        animation.warnings.extend(sheets::remark(&animation));
        Ok(animation)
    }

    /// The clips that can be played, in the order of the file.
    pub fn clips(&self) -> &[Clip] {
        &self.clips
    }

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

    /// What of the file cannot be used, and what to do.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
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

#[cfg(test)]
mod tests;
