//! Poses in a file: `{"objects": {"NAME": {"translate": [x, y, z], "rotate_degrees": [x, y, z], "scale": s}}}`.

use super::{Pose, PoseError, Poses};
use crate::{input, scene::Scene};
use serde::{Deserialize, Serialize};
use std::{
    collections::BTreeMap,
    io,
    path::{Path, PathBuf},
};
use thiserror::Error;

/// Why a file of poses cannot be used.
#[derive(Debug, Error)]
pub enum PoseFileError {
    /// The file cannot be read.
    #[error("cannot read the poses: {source} ({})", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is not JSON of poses.
    #[error(
        "cannot read the poses: {source}; write them as {{\"objects\": {{\"NAME\": {{\"translate\": [0, 0, 0], \"rotate_degrees\": [0, 0, 0], \
         \"scale\": 1}}}}}} ({})",
        path.display()
    )]
    Json {
        /// The file.
        path: PathBuf,
        /// The cause, with line and column.
        source: serde_json::Error,
    },
    /// A pose in the file is invalid.
    #[error("{source} ({})", path.display())]
    Pose {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: PoseError,
    },
}

/// The contents of a file of poses.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PoseFile {
    objects: BTreeMap<String, Pose>,
}

impl Poses {
    /// Reads a file of poses for a scene. All objects of a name get its pose.
    ///
    /// # Errors
    /// A file that cannot be read, or that poses unknown objects; see [`PoseFileError`].
    pub fn read(path: &Path, scene: &Scene) -> Result<Self, PoseFileError> {
        let path = || path.to_owned();
        let text = input::read_text(&path()).map_err(|source| PoseFileError::Read { path: path(), source })?;
        let file: PoseFile =
            serde_json::from_str(&text).map_err(|source| PoseFileError::Json { path: path(), source })?;
        Self::named(&file.objects, scene).map_err(|source| PoseFileError::Pose { path: path(), source })
    }

    /// Poses from a map of object names.
    ///
    /// # Errors
    /// Unknown names and invalid poses; see [`PoseError`].
    pub fn named(poses: &BTreeMap<String, Pose>, scene: &Scene) -> Result<Self, PoseError> {
        let mut found = Self::default();
        for (name, pose) in poses {
            pose.validate(name)?;
            objects_called(name, scene)?.into_iter().for_each(|object| found.set(object, *pose));
        }
        Ok(found)
    }
}

/// The objects called `name`, which may be the ground's.
fn objects_called(name: &str, scene: &Scene) -> Result<Vec<u32>, PoseError> {
    let called = (0..).zip(&scene.objects).filter(|(_, object)| object.name == name).map(|(object, _)| object);
    let (ground, found): (Vec<u32>, Vec<u32>) = called.partition(|&object| scene.mesh.ground_object() == Some(object));
    match (found.is_empty(), ground.is_empty()) {
        (false, _) => Ok(found),
        (true, false) => Err(PoseError::Ground),
        (true, true) => {
            let known = scene.objects.iter().map(|object| object.name.clone()).collect();
            Err(PoseError::NoSuchObject { name: name.to_owned(), known })
        }
    }
}
