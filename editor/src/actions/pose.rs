//! Requests about animations.

use lapidary_core::animation::ClipTime;

/// A request about animations.
#[derive(Clone, Debug)]
pub enum PoseAction {
    /// Show a time of an animation, or the scene at rest.
    ClipTime(Option<ClipTime>),
    /// Play the animation, or stop.
    Play,
}
