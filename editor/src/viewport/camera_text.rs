//! A camera as clipboard text, in the options of `lapidary render`, so that a view of the window can be rendered from a script, and
//! the other way around.
//!
//! The options have no roll: they read with +Y upward. A camera as JSON, as in session files, is read too.

use anyhow::{Context, Result, anyhow, bail, ensure};
use glam::Vec3;
use lapidary_core::{
    bounds::{MOST_COORDINATE, is_within_reach},
    camera::Camera,
};
use lapidary_studies::{args::LensArgs, values};

/// Default vertical field of view in degrees, as on the command line.
const DEFAULT_FOV: f32 = 40.0;

/// The camera as `--eye x,y,z --target x,y,z --fov degrees`; positions are kept to the last bit.
pub fn text(camera: &Camera) -> String {
    let vector = |v: Vec3| format!("{},{},{}", v.x, v.y, v.z);
    // Four decimals hide the rounding between radians and degrees.
    let fov = (f64::from(camera.fov_y).to_degrees() * 1e4).round() / 1e4;
    let lens = LensArgs::text_of(&camera.lens);
    format!("--eye {} --target {} --fov {fov}{lens}", vector(camera.eye), vector(camera.target))
}

/// Parses such a text, a whole command line with these options, or JSON.
///
/// # Errors
/// A text without a camera, or an invalid camera.
pub fn parse(text: &str) -> Result<Camera> {
    let text = text.trim();
    let camera = if text.starts_with('{') { from_json(text)? } else { from_options(text)? };
    ensure!(camera.eye != camera.target, "--eye and --target are the same point; move one of them");
    Ok(camera)
}

fn from_options(text: &str) -> Result<Camera> {
    let vector = |name| -> Result<Option<Vec3>> { read(text, name, values::place) };
    let (Some(eye), Some(target)) = (vector("--eye")?, vector("--target")?) else {
        bail!("this text holds no camera; copy one, or write it as --eye 0,1,3 --target 0,0,0 --fov 40");
    };
    let fov = read(text, "--fov", values::field_of_view)?.unwrap_or(DEFAULT_FOV);
    let lens = LensArgs {
        f_number: read(text, "--f-number", values::f_number)?,
        focus: read(text, "--focus", values::focus)?,
        sensor: read(text, "--sensor", values::sensor)?,
        shift: read(text, "--shift", values::shift)?,
    };
    Ok(lens.applied(Camera::look_at(eye, target, fov)))
}

/// The value of an option, if the text has it.
fn read<T>(text: &str, name: &str, value: fn(&str) -> Result<T, String>) -> Result<Option<T>> {
    let mut words = text.split_whitespace();
    let found = words.find_map(|word| match word.strip_prefix(name)? {
        "" => Some(None),
        rest => Some(Some(rest.strip_prefix('=')?)),
    });
    let Some(inline) = found else { return Ok(None) };
    let word = inline.or_else(|| words.next()).with_context(|| format!("{name} needs a value after it"))?;
    value(word).map(Some).map_err(|reason| anyhow!("{name}: {reason}"))
}

fn from_json(text: &str) -> Result<Camera> {
    let camera: Camera = serde_json::from_str(text)
        .map_err(|error| anyhow!("this JSON is no camera ({error}); copy a camera or a session's \"camera\" again"))?;
    let numbers = [camera.eye, camera.target, camera.up];
    ensure!(
        numbers.into_iter().all(is_within_reach),
        "the camera's eye, target and up must be finite numbers within {MOST_COORDINATE:e} m of the origin"
    );
    ensure!(camera.up != Vec3::ZERO, "the camera's up must point somewhere, as 0,1,0 does");
    let degrees = camera.fov_y.to_degrees();
    ensure!((1.0..=170.0).contains(&degrees), "the camera's fov_y is {degrees} degrees and not between 1 and 170");
    ensure!(camera.lens.is_valid(), "the camera's lens has an f_number, a focus, a sensor_mm or a shift out of range");
    Ok(camera)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use lapidary_core::camera::Lens;

    #[test]
    fn text_round_trips() {
        for (eye, target, fov) in [
            (Vec3::new(0.1, -2.5, 1e-7), Vec3::new(-3.0, 0.0, 1.0 / 3.0), 40.0),
            (Vec3::new(123_456.79, 0.0, -1.0), Vec3::ZERO, 1.0),
            (Vec3::X, Vec3::NEG_Y, 169.5),
        ] {
            let camera = Camera::look_at(eye, target, fov);
            let read = parse(&text(&camera)).unwrap();
            assert_eq!((read.eye, read.target, read.up), (eye, target, Vec3::Y));
            assert!((read.fov_y - camera.fov_y).abs() < 1e-6, "{}", text(&camera));
            let lens = Lens { f_number: Some(1.8), focus: Some(0.25), sensor_mm: 13.0, shift: Vec2::new(-0.5, 0.1) };
            let opened = Camera { lens, ..camera.clone() };
            assert_eq!(parse(&text(&opened)).unwrap().lens, lens, "{}", text(&opened));
            let json = serde_json::to_string(&camera).unwrap();
            assert_eq!(parse(&json).unwrap(), camera);
        }
    }

    #[test]
    fn text_is_what_the_command_line_takes() {
        let camera = Camera::look_at(Vec3::new(-1.0, 2.0, 3.5), Vec3::ZERO, 40.0);
        assert_eq!(text(&camera), "--eye -1,2,3.5 --target 0,0,0 --fov 40");
        let pasted =
            parse("lapidary render a.cuts --env studio --fov=40 --target 0,0,0 --eye=-1,2,3.5 -o a.png").unwrap();
        assert_eq!(pasted, camera);
        assert_eq!(parse("\n --eye -1,2,3.5  --target 0,0,0\n").unwrap(), camera, "40 degrees without --fov");
    }

    #[test]
    fn nonsense_is_refused_with_what_is_wrong() {
        for (bad, reason) in [
            ("", "no camera"),
            ("hello", "no camera"),
            ("--eyes 0,0,0 --target 1,1,1", "no camera"),
            ("--eye 0,0,0", "no camera"),
            ("--target 0,0,0 --eye", "--eye needs a value"),
            ("--eye 0,0 --target 1,1,1", "--eye: three numbers"),
            ("--eye 0,0,nan --target 1,1,1", "--eye: \"nan\" is not a number"),
            ("--eye 1,1,1 --target 1,1,1", "same point"),
            ("--eye 1,1,1 --target 0,0,0 --fov 180", "--fov: 180 is not between"),
            ("--eye 1,1,1 --target 0,0,0 --f-number 0", "--f-number: 0 is not between"),
            ("--eye 1,1,1 --target 0,0,0 --shift 1", "--shift: two numbers"),
            ("{\"eye\":[0,0,1],\"target\":[0,0,0],\"up\":[0,1,0],\"fov_y\":1,\"lens\":{\"focus\":-1}}", "lens"),
            ("{}", "JSON is no camera"),
            ("{\"eye\":[0,0,1],\"target\":[0,0,0],\"up\":[0,1,0],\"fov_y\":0}", "fov_y is 0"),
            ("{\"eye\":[0,0,1],\"target\":[0,0,0],\"up\":[0,0,0],\"fov_y\":1}", "up must point"),
            ("{\"eye\":[0,0,1],\"target\":[0,0,1],\"up\":[0,1,0],\"fov_y\":1}", "same point"),
            ("{\"eye\":[0,0,1e39],\"target\":[0,0,1],\"up\":[0,1,0],\"fov_y\":1}", "camera"),
        ] {
            let message = parse(bad).unwrap_err().to_string();
            assert!(message.contains(reason), "{bad}: {message}");
        }
    }
}
