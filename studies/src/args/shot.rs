//! A picture to bake for, as an option.

use crate::values::vector;
use anyhow::Result;
use lapidary_core::{
    bounds::MOST_COORDINATE,
    camera::Camera,
    scene::Scene,
    shot::{DEFAULT_ASPECT, Shot, WIDEST},
};

/// Default vertical field of view in degrees, as for `render` with `--eye` and `--target`.
const DEFAULT_FOV: f32 = 40.0;

/// A requested shot.
#[derive(Clone, Debug, PartialEq)]
pub enum ShotOption {
    /// A camera of the scene by name.
    Camera(String),
    /// A free camera.
    Free(Shot),
}

impl ShotOption {
    /// Parses `X,Y,Z:X,Y,Z[:DEG[:ASPECT]]`, or else a camera name.
    ///
    /// # Errors
    /// The expected form, if the text is not a shot.
    pub fn parse(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(':').collect();
        let (&[eye, target, ref rest @ ..], Ok(_)) = (&parts[..], vector(parts[0])) else {
            return Ok(Self::Camera(text.to_owned()));
        };
        if rest.len() > 2 {
            return Err("give EYE:TARGET:DEGREES:ASPECT; the last two are optional".into());
        }
        let number = |i: usize, default: f32| match rest.get(i) {
            Some(text) => text.trim().parse().map_err(|_| format!("\"{text}\" is not a number")),
            None => Ok(default),
        };
        let camera = Camera::look_at(vector(eye)?, vector(target)?, number(0, DEFAULT_FOV)?);
        let shot = Shot { camera, aspect: number(1, DEFAULT_ASPECT)? };
        if shot.is_valid() {
            Ok(Self::Free(shot))
        } else {
            Err(format!(
                "the camera is invalid; eye and target must differ and lie within {MOST_COORDINATE:e} m of the origin, the field \
                 of view must lie between 0 and 177 degrees, and width over height must be between 1/{WIDEST} and {WIDEST}"
            ))
        }
    }

    /// The shot; named cameras come from `scene`.
    ///
    /// # Errors
    /// No camera has the name.
    pub fn of(&self, scene: &Scene) -> Result<Shot> {
        match self {
            Self::Camera(name) => Ok(Shot { camera: scene.camera(name)?.clone(), aspect: DEFAULT_ASPECT }),
            Self::Free(shot) => Ok(shot.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn places_make_a_shot_and_anything_else_is_a_name() {
        let Ok(ShotOption::Free(shot)) = ShotOption::parse("1,2,3:0,0.5,-1:58.7:2") else { panic!("no shot") };
        assert_eq!((shot.camera.eye, shot.camera.target), (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.0, 0.5, -1.0)));
        assert!((shot.camera.fov_y.to_degrees() - 58.7).abs() < 1e-3 && shot.aspect == 2.0);
        let Ok(ShotOption::Free(short)) = ShotOption::parse("-1,2,3:0,0,0") else { panic!("no shot") };
        assert!((short.camera.fov_y.to_degrees() - 40.0).abs() < 1e-3 && short.aspect == DEFAULT_ASPECT);
        for name in ["hero", "scene:hero"] {
            assert_eq!(ShotOption::parse(name), Ok(ShotOption::Camera(name.into())));
        }
        for bad in
            ["1,2,3:1,2,3", "1,2,3:4,5", "1,2,3:0,0,0:x", "1,2,3:0,0,0:200", "1,2,3:0,0,0:40:0", "1,2,3:0,0,0:40:1:9"]
        {
            assert!(ShotOption::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_name_is_looked_up_and_a_wrong_one_is_told_the_right_ones() {
        let camera = Camera { name: "hero".into(), ..Camera::look_at(Vec3::ONE, Vec3::ZERO, 30.0) };
        let scene = Scene { cameras: vec![camera.clone()], ..Default::default() };
        let named = |name: &str| ShotOption::Camera(name.into()).of(&scene);
        assert_eq!(named("hero").unwrap().camera, camera);
        assert!(named("villain").unwrap_err().to_string().contains("it has hero"));
    }
}
