//! Parsers for option values.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::{Vec2, Vec3};
use lapidary_core::{
    bounds::{MOST_COORDINATE, is_within_reach},
    camera::{LEAST_F_NUMBER, MOST_SHIFT, SENSORS_MM},
    environment::MOST_INTENSITY,
};
use lapidary_render::Region;
use serde::{
    Deserialize,
    de::{IntoDeserializer, value},
};

/// Largest width and height of a picture in pixels.
const MAX_SIDE: u32 = 32_768;

/// Most pixels of a picture: as many as can be read back.
const MAX_PIXELS: u64 = 1 << 28;

/// Most stops of exposure, up or down, as in a session.
const MOST_STOPS: f32 = 32.0;

/// A library enum by its name in files; each name has a line of `--help`.
pub fn choice<T>(choices: &'static [(&'static str, &'static str)]) -> impl TypedValueParser<Value = T>
where
    T: for<'de> Deserialize<'de> + Clone + Send + Sync + 'static,
{
    choice_of(choices.iter().copied())
}

/// [`choice`] from a library's list.
pub fn choice_of<T>(choices: impl IntoIterator<Item = (&'static str, &'static str)>) -> impl TypedValueParser<Value = T>
where
    T: for<'de> Deserialize<'de> + Clone + Send + Sync + 'static,
{
    let names = choices.into_iter().map(|(name, help)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(names).try_map(|name| {
        let name: value::StringDeserializer<value::Error> = name.into_deserializer();
        T::deserialize(name)
    })
}

/// Three finite numbers separated by commas.
///
/// # Errors
/// The problem in words.
pub fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text.split(',').map(finite).collect::<Result<_, _>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("three numbers are needed, as in 0.3,0.5,3.5, not {}", numbers.len())),
    }
}

/// A number from 0 to 1.
///
/// # Errors
/// The problem in words.
pub fn share(text: &str) -> Result<f32, String> {
    let number = finite(text)?;
    if (0.0..=1.0).contains(&number) { Ok(number) } else { Err("it must be from 0 to 1".into()) }
}

/// A position in meters: three numbers separated by commas, within the limits of a scene.
///
/// # Errors
/// The problem in words.
pub fn place(text: &str) -> Result<Vec3, String> {
    let place = vector(text)?;
    if is_within_reach(place) {
        Ok(place)
    } else {
        Err(format!("a coordinate is beyond the limit of {MOST_COORDINATE:e} m"))
    }
}

/// Three numbers from 0 to 1 separated by commas, or one for all three.
///
/// # Errors
/// The problem in words.
pub fn color(text: &str) -> Result<Vec3, String> {
    let color = if text.contains(',') { vector(text)? } else { Vec3::splat(finite(text)?) };
    if color.min_element() >= 0.0 && color.max_element() <= 1.0 {
        Ok(color)
    } else {
        Err("a base color lies between 0 and 1".into())
    }
}

/// A width and a height in pixels, as in 640x480.
///
/// # Errors
/// The problem in words.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.trim().parse::<u32>().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
    let [width, height] =
        sides.ok_or_else(|| format!("a size is WIDTHxHEIGHT in pixels, as in 640x480, each 1 to {MAX_SIDE}"))?;
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(format!("{width} x {height} is more than the limit of {MAX_PIXELS} pixels"));
    }
    Ok([width, height])
}

/// A column and a row of a picture, as in 320,240.
///
/// # Errors
/// The problem in words.
pub fn pixel(text: &str) -> Result<[u32; 2], String> {
    whole_numbers(text).ok_or_else(|| format!("a pixel is COLUMN,ROW, as in 320,240, not \"{text}\""))
}

/// A rectangle of pixels by its left column, upper row, width and height, as in 100,80,64,48.
///
/// # Errors
/// The problem in words.
pub fn region(text: &str) -> Result<Region, String> {
    let [x, y, width, height] = whole_numbers(text)
        .ok_or_else(|| format!("a region is COLUMN,ROW,WIDTH,HEIGHT in pixels, as in 100,80,64,48, not \"{text}\""))?;
    Ok(Region { x, y, width, height })
}

/// Exactly `N` whole numbers, separated by commas.
fn whole_numbers<const N: usize>(text: &str) -> Option<[u32; N]> {
    let numbers: Vec<u32> = text.split(',').map(|word| word.trim().parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

/// A finite number.
///
/// # Errors
/// The problem in words.
pub fn finite(text: &str) -> Result<f32, String> {
    text.trim().parse().ok().filter(|x: &f32| x.is_finite()).ok_or_else(|| format!("\"{text}\" is not a number"))
}

/// A number from 0 to 1.
///
/// # Errors
/// The problem in words.
pub fn fraction(text: &str) -> Result<f32, String> {
    between(text, 0.0, 1.0)
}

/// A factor on the radiance of an environment.
///
/// # Errors
/// The problem in words.
pub fn intensity(text: &str) -> Result<f32, String> {
    between(text, 0.0, MOST_INTENSITY)
}

/// An exposure in stops.
///
/// # Errors
/// The problem in words.
pub fn exposure(text: &str) -> Result<f32, String> {
    between(text, -MOST_STOPS, MOST_STOPS)
}

/// A number above zero.
///
/// # Errors
/// The problem in words.
pub fn positive(text: &str) -> Result<f32, String> {
    between(text, f32::MIN_POSITIVE, f32::MAX).map_err(|_| format!("\"{text}\" is not a number above zero"))
}

/// A vertical field of view in degrees.
///
/// # Errors
/// The problem in words.
pub fn field_of_view(text: &str) -> Result<f32, String> {
    between(text, 1.0, 170.0)
}

/// An f-number.
///
/// # Errors
/// The problem in words.
pub fn f_number(text: &str) -> Result<f32, String> {
    between(text, LEAST_F_NUMBER, 1000.0)
}

/// A distance in focus, in meters.
///
/// # Errors
/// The problem in words.
pub fn focus(text: &str) -> Result<f32, String> {
    between(text, 1e-6, MOST_COORDINATE)
}

/// The height of a sensor in millimeters.
///
/// # Errors
/// The problem in words.
pub fn sensor(text: &str) -> Result<f32, String> {
    let [least, most] = SENSORS_MM;
    between(text, least, most)
}

/// A shift of the picture to the right and up, in heights of it.
///
/// # Errors
/// The problem in words.
pub fn shift(text: &str) -> Result<Vec2, String> {
    let numbers: Vec<f32> = text.split(',').map(|n| between(n, -MOST_SHIFT, MOST_SHIFT)).collect::<Result<_, _>>()?;
    match numbers[..] {
        [x, y] => Ok(Vec2::new(x, y)),
        _ => Err(format!("two numbers are needed, as in 0,0.2, not {}", numbers.len())),
    }
}

fn between(text: &str, low: f32, high: f32) -> Result<f32, String> {
    let value = finite(text)?;
    match (low..=high).contains(&value) {
        true => Ok(value),
        false if high == f32::MAX => Err(format!("{value} is below {low}")),
        false => Err(format!("{value} is not between {low} and {high}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_values_are_read() {
        assert_eq!(vector("-1, 2.5,3e1"), Ok(Vec3::new(-1.0, 2.5, 30.0)));
        assert_eq!(color("0.2"), Ok(Vec3::splat(0.2)));
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert_eq!(fraction("1"), Ok(1.0));
        assert_eq!(pixel("3, 4"), Ok([3, 4]));
        assert_eq!(region("1,2,3,4"), Ok(Region { x: 1, y: 2, width: 3, height: 4 }));
        assert_eq!(positive("0.1"), Ok(0.1));
        assert_eq!(place("-1e9,0,1e9"), Ok(Vec3::new(-1e9, 0.0, 1e9)));
        assert_eq!((intensity("1e6"), exposure("-32")), (Ok(1e6), Ok(-32.0)));
    }

    #[test]
    fn bad_values_say_what_is_wrong() {
        for bad in ["1,2", "1,2,3,4", "a,b,c", "1,nan,2", ""] {
            assert!(vector(bad).is_err(), "{bad}");
        }
        for bad in ["640", "0x480", "640x-1", "99999x2", "32768x32768", "x", "1x1x1"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        for bad in ["", "3", "3,-4", "3,4.5", "3,4,5", "a,b"] {
            assert!(pixel(bad).unwrap_err().contains("320,240") && region(bad).is_err(), "{bad}");
        }
        assert!(color("0.5,0.5,1.5").is_err() && color("0.5,0.5").is_err());
        assert!(fraction("1.1").is_err() && fraction("nan").is_err());
        assert!(place("0,1.1e9,0").unwrap_err().contains("1e9") && place("0,nan,0").is_err());
        assert!(intensity("1.1e6").is_err() && intensity("-1").is_err() && exposure("33").is_err());
        assert!(positive("0").is_err() && field_of_view("180").is_err());
    }
}
