//! Tools of the handles for selected objects.

use super::change::{SCALE_STEP, TURN_STEP_DEGREES};

/// A tool of the handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Moves them along axes and planes.
    Move,
    /// Turns them about the axes of the world through their pivot.
    Turn,
    /// Makes them larger or smaller.
    Scale,
}

impl Tool {
    /// All tools.
    pub const ALL: [Self; 3] = [Self::Move, Self::Turn, Self::Scale];

    /// The name of its command.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Move => "Move object",
            Self::Turn => "Turn object",
            Self::Scale => "Scale object",
        }
    }

    /// Its verb, for the name of its step of undo.
    pub const fn verb(self) -> &'static str {
        match self {
            Self::Move => "Move",
            Self::Turn => "Turn",
            Self::Scale => "Scale",
        }
    }

    /// Hint on the steps with Ctrl, with steps of `move_step` meters for moves.
    pub fn steps(self, move_step: f32) -> String {
        match self {
            Self::Move => format!("Ctrl: steps of {move_step} m"),
            Self::Turn => format!("Ctrl: steps of {TURN_STEP_DEGREES}°"),
            Self::Scale => format!("Ctrl: steps of {:.0} %", 100.0 * SCALE_STEP),
        }
    }
}
