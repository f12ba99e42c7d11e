//! What a pose may be.

use super::{MOST_SCALE, Pose};
use crate::bounds::{MOST_COORDINATE, is_within_reach};
use thiserror::Error;

/// Why an object cannot be posed as asked.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PoseError {
    /// No object has this name.
    #[error("the scene has no object \"{name}\"; it has {}", listed(known))]
    NoSuchObject {
        /// What was asked for.
        name: String,
        /// Those of the scene.
        known: Vec<String>,
    },
    /// The ground lies under everything, and stays.
    #[error("the ground cannot be posed; pose what stands on it")]
    Ground,
    /// A scale of zero or below, beyond the limit, or no number.
    #[error("the scale of \"{name}\" is {scale}; it must be above 0, from {} to {MOST_SCALE}", 1.0 / MOST_SCALE)]
    Scale {
        /// Which object.
        name: String,
        /// The scale.
        scale: f32,
    },
    /// A move or a turn that is no number, or out of reach.
    #[error("the pose of \"{name}\" is out of reach; coordinates and degrees are numbers up to {MOST_COORDINATE:e}")]
    OutOfReach {
        /// Which object.
        name: String,
    },
}

/// Most names that a message lists.
const LISTED: usize = 20;

fn listed(known: &[String]) -> String {
    let (some, more) = known.split_at(known.len().min(LISTED));
    match (known.len(), more.len()) {
        (0, _) => "none".into(),
        (_, 0) => some.join(", "),
        (_, more) => format!("{} and {more} more", some.join(", ")),
    }
}

impl Pose {
    /// Checks the pose of an object of this name.
    ///
    /// # Errors
    /// [`PoseError::Scale`] or [`PoseError::OutOfReach`].
    pub fn validate(&self, name: &str) -> Result<(), PoseError> {
        let (name, scale) = (|| name.to_owned(), self.scale);
        if !(1.0 / MOST_SCALE..=MOST_SCALE).contains(&scale) {
            return Err(PoseError::Scale { name: name(), scale });
        }
        let is_in_reach = is_within_reach(self.translate) && is_within_reach(self.rotate_degrees);
        if is_in_reach { Ok(()) } else { Err(PoseError::OutOfReach { name: name() }) }
    }
}
