//! Turns the amounts of a handle's drag into poses of objects. Independent of the screen.

use glam::{Quat, Vec3};
use lapidary_core::scene::pose::{MOST_SCALE, Pose, Similarity};

/// Steps with Ctrl: of turns in degrees, and of factors.
pub const TURN_STEP_DEGREES: f32 = 15.0;
pub const SCALE_STEP: f32 = 0.1;
/// Least number of move steps in the diagonal of a scene.
const STEPS_ACROSS: f32 = 20.0;

/// An axis to turn about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Axis {
    /// An axis of the world: 0 is X, 1 is Y, 2 is Z.
    World(usize),
    /// A unit direction, of a hinge.
    Hinge(Vec3),
}

impl Axis {
    /// The axes of the world.
    pub const OF_WORLD: [Self; 3] = [Self::World(0), Self::World(1), Self::World(2)];

    /// Its unit direction.
    pub fn direction(self) -> Vec3 {
        match self {
            Self::World(axis) => Vec3::AXES[axis],
            Self::Hinge(direction) => direction,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::World(axis) => ["X", "Y", "Z"][axis],
            Self::Hinge(_) => "the hinge",
        }
    }
}

/// A change of poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// An offset in meters.
    Move(Vec3),
    /// About an axis through a pivot, counter-clockwise seen against it.
    Turn {
        /// The axis.
        axis: Axis,
        /// The angle.
        degrees: f32,
    },
    /// A factor of sizes and of distances from a pivot.
    Scale(f32),
}

impl Change {
    /// The nearest whole number of steps; `move_step` is in meters.
    pub fn snapped(self, move_step: f32) -> Self {
        let snap = |value: f32, step: f32| (value / step).round() * step;
        match self {
            Self::Move(offset) => Self::Move(offset.map(|length| snap(length, move_step))),
            Self::Turn { axis, degrees } => Self::Turn { axis, degrees: snap(degrees, TURN_STEP_DEGREES) },
            Self::Scale(factor) => Self::Scale(snap(factor, SCALE_STEP).max(SCALE_STEP)),
        }
    }

    /// Limits the change for objects of these scales, so that none becomes larger or smaller than allowed.
    pub fn limited(self, scales: impl IntoIterator<Item = f32>) -> Self {
        let Self::Scale(factor) = self else { return self };
        let limit = |factor: f32, scale: f32| factor.max(1.0 / MOST_SCALE / scale).min(MOST_SCALE / scale);
        Self::Scale(scales.into_iter().fold(factor, limit))
    }

    /// The similarity of the world, about the origin.
    pub fn similarity(self) -> Similarity {
        let identity = Similarity::IDENTITY;
        match self {
            Self::Move(translate) => Similarity { translate, ..identity },
            Self::Turn { axis, degrees } => {
                Similarity { rotation: Quat::from_axis_angle(axis.direction(), degrees.to_radians()), ..identity }
            }
            Self::Scale(scale) => Similarity { scale, ..identity },
        }
    }

    /// The text over the picture.
    pub fn words(self) -> String {
        match self {
            Self::Move(Vec3 { x, y, z }) => format!("Move by {x:.3}, {y:.3}, {z:.3} m"),
            Self::Turn { axis, degrees } => format!("Turn about {} by {degrees:.1}°", axis.name()),
            Self::Scale(factor) => format!("Scale by {factor:.2}"),
        }
    }
}

/// The pose of an object with a center in meters after a similarity whose factor was [limited](Change::limited).
pub fn posed(before: Pose, by: &Similarity, center: Vec3) -> Pose {
    let pose = before.followed_by(by, center);
    // Rounding may put the factor beyond the limit.
    Pose { scale: pose.scale.clamp(1.0 / MOST_SCALE, MOST_SCALE), ..pose }
}

/// The step of moves in a scene of this diagonal, both in meters: a power of ten, 0.1 m in a room.
pub fn move_step(diagonal: f32) -> f32 {
    if diagonal > 0.0 { 10f32.powi((diagonal / STEPS_ACROSS).log10().floor() as i32) } else { 0.1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CENTER: Vec3 = Vec3::new(0.5, 2.0, -1.0);
    const TILTED: Pose =
        Pose { translate: Vec3::X, rotate_degrees: Vec3::new(90.0, 0.0, 0.0), scale: 2.0, ..Pose::AS_BAKED };

    /// A pose about its own center after a change.
    fn changed(before: Pose, change: Change) -> Pose {
        let by = change.limited([before.scale]).similarity();
        posed(before, &Similarity { pivot: CENTER + before.translate, ..by }, CENTER)
    }

    #[test]
    fn moves_add_up_and_scales_multiply_within_what_is_valid() {
        let moved = changed(TILTED, Change::Move(Vec3::new(0.5, -1.0, 0.0)));
        assert_eq!(moved, Pose { translate: Vec3::new(1.5, -1.0, 0.0), ..TILTED });
        assert_eq!(changed(TILTED, Change::Scale(1.5)), Pose { scale: 3.0, ..TILTED });
        for (factor, scale) in [(1e9, MOST_SCALE), (-3.0, 1.0 / MOST_SCALE)] {
            let scaled = changed(TILTED, Change::Scale(factor));
            assert!(scaled.scale == scale && scaled.validate("").is_ok(), "{factor}");
        }
        let least = Pose { scale: 1.0 / MOST_SCALE, ..TILTED };
        assert_eq!(changed(least, Change::Scale(0.5)), least);
    }

    #[test]
    fn turns_are_about_the_axes_of_the_world_after_the_turns_that_were() {
        let turned = changed(TILTED, Change::Turn { axis: Axis::World(1), degrees: 90.0 });
        // The tilt takes Z to -Y, which the turn about Y leaves; it leaves X, which the turn takes to -Z.
        assert!((turned.rotation() * Vec3::Z).distance(Vec3::NEG_Y) < 1e-5);
        assert!((turned.rotation() * Vec3::X).distance(Vec3::NEG_Z) < 1e-5);
        let own = TILTED.rotation() * Quat::from_rotation_y(90f32.to_radians());
        assert!((own * Vec3::X).distance(Vec3::NEG_Z) > 0.5, "negative control: about an axis of the object");
        assert_eq!(changed(TILTED, Change::Turn { axis: Axis::World(2), degrees: 0.0 }), TILTED);
    }

    #[test]
    fn snapped_changes_are_whole_steps() {
        let offset = Change::Move(Vec3::new(0.26, -0.04, 0.0));
        let Change::Move(snapped) = offset.snapped(0.1) else { panic!("{offset:?}") };
        assert!(snapped.distance(Vec3::new(0.3, 0.0, 0.0)) < 1e-6, "{snapped}");
        let turn = |degrees| Change::Turn { axis: Axis::World(0), degrees };
        assert_eq!([turn(22.4), turn(22.6), turn(-8.0)].map(|t| t.snapped(0.1)), [turn(15.0), turn(30.0), turn(-15.0)]);
        for (factor, expected) in [(1.26, 1.3), (0.98, 1.0), (0.01, 0.1)] {
            let Change::Scale(snapped) = Change::Scale(factor).snapped(0.1) else { panic!("{factor}") };
            assert!((snapped - expected).abs() < 1e-6, "{factor}: {snapped}");
        }
        assert_ne!(turn(22.4).snapped(0.1), turn(22.4), "negative control");
    }

    #[test]
    fn steps_fit_the_scene() {
        for (diagonal, step) in [(3.5, 0.1), (19.0, 0.1), (0.3, 0.01), (500.0, 10.0), (0.0, 0.1), (f32::NAN, 0.1)] {
            assert!((move_step(diagonal) / step - 1.0).abs() < 1e-5, "{diagonal}: {}", move_step(diagonal));
        }
    }
}
