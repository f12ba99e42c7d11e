//! The two sides of a surface.

use glam::Vec3;

/// A side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The side of the normal.
    Front,
    /// The opposite side.
    Back,
}

impl Side {
    /// Both sides in storage order.
    pub const BOTH: [Self; 2] = [Self::Front, Self::Back];

    /// The normal of this side, for a surface with this normal.
    pub fn normal(self, of_surface: Vec3) -> Vec3 {
        match self {
            Self::Front => of_surface,
            Self::Back => -of_surface,
        }
    }
}
