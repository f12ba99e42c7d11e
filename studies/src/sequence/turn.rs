//! Turntables: rotation about the vertical through the camera's target.

use clap::ValueEnum;
use glam::{Quat, Vec3};
use lapidary_core::{
    camera::Camera,
    lights::Light,
    scene::{
        Scene,
        pose::{Objects, Similarity},
    },
};
use lapidary_render::Look;

/// What turns, counter-clockwise seen from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Turn {
    /// The whole scene, in front of the camera and under its lights. Visibility was baked for the unturned scene, so camera,
    /// environment and lights turn the other way together, with the same result
    Object,
    /// The camera, about its target
    Camera,
    /// The environment
    Environment,
    /// The local lights, about the camera's target
    Lights,
}

impl Turn {
    /// All turns.
    pub const ALL: [Self; 4] = [Self::Object, Self::Camera, Self::Environment, Self::Lights];

    /// Name in options and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Camera => "camera",
            Self::Environment => "environment",
            Self::Lights => "lights",
        }
    }

    /// Applies a turn by `degrees` to the look.
    pub fn apply(self, look: &mut Look, degrees: f32) {
        let degrees = if self == Self::Object { -degrees } else { degrees };
        let axis = Axis { center: look.view.camera.target, turn: Quat::from_rotation_y(degrees.to_radians()) };
        if matches!(self, Self::Object | Self::Camera) {
            look.view.camera = axis.turned_camera(&look.view.camera);
        }
        if matches!(self, Self::Object | Self::Environment) {
            look.illumination.rotation += degrees.to_radians();
        }
        if matches!(self, Self::Object | Self::Lights) {
            look.lights = look.lights.iter().map(|light| axis.turned_light(light)).collect();
        }
    }
}

/// An object that turns alone, by implicit visibility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// Its index.
    pub object: u32,
    /// The center of its pose, in meters: that of its box as baked.
    pub center: Vec3,
    /// The point through which the vertical goes about which it turns, in meters.
    pub pivot: Vec3,
}

impl Spin {
    /// About its own center in a look.
    pub fn about_center(scene: &Scene, object: u32, look: &Look) -> Self {
        let center = Objects::of(scene).center(object);
        Self { object, center, pivot: center + look.poses.of(object).translate }
    }

    /// Turns the object by `degrees` in the look.
    pub fn apply(self, look: &mut Look, degrees: f32) {
        let rotation = Quat::from_rotation_y(degrees.to_radians());
        let turn = Similarity { rotation, pivot: self.pivot, ..Similarity::IDENTITY };
        look.poses.set(self.object, look.poses.of(self.object).followed_by(&turn, self.center));
    }
}

/// The vertical through a point, and a rotation about it.
struct Axis {
    center: Vec3,
    turn: Quat,
}

impl Axis {
    fn place(&self, place: Vec3) -> Vec3 {
        self.center + self.turn * (place - self.center)
    }

    fn turned_camera(&self, camera: &Camera) -> Camera {
        // The picture's upward direction, which must turn too for a camera that looks straight down.
        let up = camera.world_from_view().y_axis;
        Camera { eye: self.place(camera.eye), target: self.place(camera.target), up: self.turn * up, ..camera.clone() }
    }

    fn turned_light(&self, light: &Light) -> Light {
        Light { position: self.place(light.position), target: self.place(light.target), ..light.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::scene::pose::Pose;
    use lapidary_render::test_looks::look;

    fn turned(turn: Turn, degrees: f32) -> Look {
        let mut look = look();
        turn.apply(&mut look, degrees);
        look
    }

    /// A world direction in the picture and in the map.
    fn seen(look: &Look, direction: Vec3) -> (Vec3, Vec3) {
        let view = look.view.camera.world_from_view().transpose() * direction;
        (view, Quat::from_rotation_y(-look.illumination.rotation) * direction)
    }

    #[test]
    fn an_object_spins_alone_about_its_own_center_and_keeps_its_pose() {
        let (scene, mut look) = (lapidary_core::test_scenes::cubes(3), look());
        let before = Pose { translate: Vec3::X, rotate_degrees: Vec3::new(0.0, 20.0, 0.0), ..Pose::AS_BAKED };
        look.poses.set(1, before);
        let spin = Spin::about_center(&scene, 1, &look);
        let camera = look.view.camera.clone();
        spin.apply(&mut look, 90.0);
        let after = look.poses.of(1);
        assert!(after.translate.distance(before.translate) < 1e-5, "{after:?}");
        assert!((after.rotation() * Vec3::X).distance(Quat::from_rotation_y(110_f32.to_radians()) * Vec3::X) < 1e-4);
        assert!(look.poses.is_as_baked(0) && look.view.camera == camera, "nothing else turns");
        let aside = Spin { pivot: spin.pivot + Vec3::X, ..spin };
        aside.apply(&mut look, 90.0);
        assert!(look.poses.of(1).translate.distance(before.translate) > 0.5, "negative control: about another point");
    }

    #[test]
    fn an_object_that_turns_leaves_light_and_background_where_they_are_in_the_picture() {
        let (before, after) = (look(), turned(Turn::Object, 40.0));
        // Map direction seen at a position of the picture.
        let map_at = |look: &Look, view: Vec3| seen(look, look.view.camera.world_from_view() * view).1;
        for view in [Vec3::X, Vec3::Y, Vec3::NEG_Z] {
            assert!((map_at(&before, view) - map_at(&after, view)).length() < 1e-5);
            let camera = turned(Turn::Camera, 40.0);
            assert!(
                view == Vec3::Y || (map_at(&before, view) - map_at(&camera, view)).length() > 0.1,
                "negative control"
            );
        }
        let light = |look: &Look| {
            let camera = &look.view.camera;
            camera.world_from_view().transpose() * (look.lights[0].position - camera.eye)
        };
        assert!((light(&before) - light(&after)).length() < 1e-5);
        assert!((light(&before) - light(&turned(Turn::Camera, 40.0))).length() > 0.1, "negative control");
    }

    #[test]
    fn an_object_turns_counter_clockwise_seen_from_above() {
        // A scene point toward the camera moves to its right.
        let (before, after) = (look(), turned(Turn::Object, 20.0));
        let camera = &before.view.camera;
        let point = camera.target + 0.5 * (camera.eye - camera.target).with_y(0.0);
        let right = |look: &Look| {
            let camera = &look.view.camera;
            (camera.world_from_view().transpose() * (point - camera.eye)).x
        };
        assert!(right(&before).abs() < 1e-5 && right(&after) > 0.1, "{}", right(&after));
        // Turning the camera counter-clockwise shows it on the left.
        assert!(right(&turned(Turn::Camera, 20.0)) < -0.1);
    }

    #[test]
    fn each_turn_moves_its_own_and_a_full_one_comes_back() {
        let before = look();
        let parts = |look: &Look| (look.view.camera.eye, look.illumination.rotation, look.lights[0].position);
        let moved = |turn| {
            let (eye, rotation, light) = parts(&turned(turn, 90.0));
            let (eye0, rotation0, light0) = parts(&before);
            [eye != eye0, rotation != rotation0, light != light0]
        };
        assert_eq!(moved(Turn::Object), [true, true, true]);
        assert_eq!(moved(Turn::Camera), [true, false, false]);
        assert_eq!(moved(Turn::Environment), [false, true, false]);
        assert_eq!(moved(Turn::Lights), [false, false, true]);
        let after = turned(Turn::Object, 360.0);
        assert!((after.view.camera.eye - before.view.camera.eye).length() < 1e-4);
        let half = turned(Turn::Camera, 180.0).view.camera;
        let camera = &before.view.camera;
        assert!(
            ((half.eye - camera.target) + (camera.eye - camera.target).with_y(-half.eye.y + camera.target.y)).length()
                < 1e-4
        );
        assert_eq!(half.target, camera.target);
    }

    #[test]
    fn a_camera_that_looks_straight_down_turns_as_well() {
        let mut look = look();
        look.view.camera = Camera::look_at(Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, 40.0);
        let before = look.view.camera.world_from_view();
        Turn::Camera.apply(&mut look, 90.0);
        let after = look.view.camera.world_from_view();
        assert!((after.x_axis - Quat::from_rotation_y(90f32.to_radians()) * before.x_axis).length() < 1e-5);
    }
}
