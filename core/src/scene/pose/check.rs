//! Checks of poses.

use super::{MOST_SCALE, Pose};
use crate::bounds::{MOST_COORDINATE, is_within_reach};
use thiserror::Error;

/// Why an object cannot take a pose.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PoseError {
    /// No object has this name.
    #[error("the scene has no object \"{name}\"; it has {}", listed(known))]
    NoSuchObject {
        /// The requested name.
        name: String,
        /// Names of the scene's objects.
        known: Vec<String>,
    },
    /// The ground lies under everything and does not move.
    #[error("the ground cannot be posed; pose what stands on it")]
    Ground,
    /// A scale of zero or below, beyond the limit, or NaN.
    #[error("the scale of \"{name}\" is {scale}; it must be above 0, from {} to {MOST_SCALE}", 1.0 / MOST_SCALE)]
    Scale {
        /// Name of the object.
        name: String,
        /// The scale.
        scale: f32,
    },
    /// A translation or rotation that is NaN or out of reach.
    #[error("the pose of \"{name}\" is out of reach; coordinates and degrees are numbers up to {MOST_COORDINATE:e}")]
    OutOfReach {
        /// Name of the object.
        name: String,
    },
}

/// Largest number of names in a message.
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
