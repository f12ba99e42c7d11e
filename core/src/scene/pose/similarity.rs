//! Similarities of the world: several objects move, turn and scale together as one.
//!
//! Each object has a pose about its own center. A similarity after a pose is again a pose about that center.

use super::Pose;
use glam::{Quat, Vec3};

/// Scales and turns the world about a pivot, then moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Fixed point of the scale and turn, in meters.
    pub pivot: Vec3,
    /// Translation in meters.
    pub translate: Vec3,
    /// The rotation.
    pub rotation: Quat,
    /// A factor above 0.
    pub scale: f32,
}

impl Similarity {
    /// The identity.
    pub const IDENTITY: Self = Self { pivot: Vec3::ZERO, translate: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 };

    /// Displacement of a point, in meters. Pure translations move all points by exactly the same vector.
    pub fn displacement(&self, point: Vec3) -> Vec3 {
        let from_pivot = point - self.pivot;
        self.translate + (self.scale * (self.rotation * from_pivot) - from_pivot)
    }
}

impl Pose {
    /// This pose followed by a similarity, for an object with the baked center `center`, in meters. The scale may
    /// exceed the limits of [`Self::validate`].
    pub fn followed_by(self, similarity: &Similarity, center: Vec3) -> Self {
        let turned = match similarity.rotation == Quat::IDENTITY {
            // Keep degrees as typed.
            true => self,
            false => self.with_rotation(similarity.rotation * self.rotation()),
        };
        Self {
            translate: self.translate + similarity.displacement(center + self.translate),
            scale: self.scale * similarity.scale,
            ..turned
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    const CENTER: Vec3 = Vec3::new(1.0, 2.0, 3.0);
    const TILTED: Pose = Pose {
        translate: Vec3::new(0.5, -1.0, 0.0),
        rotate_degrees: Vec3::new(30.0, 50.0, -70.0),
        scale: 2.0,
        ..Pose::AS_BAKED
    };

    #[test]
    fn a_quarter_turn_about_a_pivot_takes_an_object_around_it() {
        let pivot = Vec3::new(1.0, 0.0, 1.0);
        let quarter = Similarity { pivot, rotation: Quat::from_rotation_y(FRAC_PI_2), ..Similarity::IDENTITY };
        let pose = Pose::AS_BAKED.followed_by(&Similarity { scale: 2.0, ..quarter }, CENTER);
        // From the pivot the center is 2 up and 2 along Z; Z becomes X, and both become twice as long.
        assert!((CENTER + pose.translate).distance(pivot + Vec3::new(4.0, 4.0, 0.0)) < 1e-5, "{pose:?}");
        assert!(pose.rotate_degrees.distance(Vec3::Y * 90.0) < 1e-3 && pose.scale == 2.0, "{pose:?}");
    }

    #[test]
    fn a_pose_followed_by_a_similarity_takes_every_point_to_where_both_take_it() {
        let similarity = Similarity {
            pivot: Vec3::new(-3.0, 0.2, 1.0),
            translate: Vec3::new(0.1, 0.7, -2.0),
            rotation: Quat::from_axis_angle(Vec3::new(1.0, 2.0, -2.0) / 3.0, 1.1),
            scale: 0.3,
        };
        let (before, after) = (TILTED.world_from_baked(CENTER), TILTED.followed_by(&similarity, CENTER));
        let off = |pose: Pose, point: Vec3| {
            let place = before.transform_point3(point);
            let expected = place + similarity.displacement(place);
            pose.world_from_baked(CENTER).transform_point3(point).distance(expected)
        };
        let about_itself = TILTED.followed_by(&Similarity { pivot: CENTER + TILTED.translate, ..similarity }, CENTER);
        for point in [Vec3::ZERO, CENTER, Vec3::new(4.0, -1.0, 0.5)] {
            assert!(off(after, point) < 1e-5, "{point}: {}", off(after, point));
            assert!(off(about_itself, point) > 0.5, "negative control: another pivot");
        }
    }

    #[test]
    fn moves_leave_turns_and_scales_as_they_are_to_the_bit() {
        let offset = Vec3::new(0.26, -0.1, 7.0);
        let moved =
            TILTED.followed_by(&Similarity { pivot: CENTER, translate: offset, ..Similarity::IDENTITY }, CENTER);
        assert_eq!(moved, Pose { translate: TILTED.translate + offset, ..TILTED });
        assert_eq!(TILTED.followed_by(&Similarity::IDENTITY, CENTER), TILTED);
    }
}
