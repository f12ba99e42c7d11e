//! Environments by name: a map file or a formula.

use crate::image::{self, PictureFormat, file_and_layer};
use glam::Vec3;
use lapidary_core::{
    environment::{Environment, MOST_RADIANCE, constant, orientation, studio, sun_and_sky},
    image::{Image, ImageError},
    texture::ColorSpace,
};
use std::path::Path;
use thiserror::Error;

/// Why an environment cannot be made.
#[derive(Debug, Error)]
pub enum EnvironmentError {
    /// The picture is unreadable.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The text is neither a file nor a formula.
    #[error(
        "{reason}; give the path of an .hdr or .exr file, or constant:R,G,B, sun-sky:ELEVATION (degrees, 0 to 90), \
         studio or orientation ({spec})"
    )]
    Spec {
        /// The given text.
        spec: String,
        /// The problem.
        reason: String,
    },
}

/// Reads an hdr or exr file, a layer of one ([`file_and_layer`]), or, with a warning, a png, jpg or tga, with its colors in this
/// space. Also returns the repairs, in sentences.
///
/// # Errors
/// A file that is unreadable or not a picture.
pub fn read(path: &Path, color_space: ColorSpace) -> Result<(Environment, Vec<String>), EnvironmentError> {
    let (map, mut warnings) = image::read_in(path, color_space)?;
    if !PictureFormat::is_of_light(path) {
        warnings.push(
            "the environment is of low dynamic range, so its lights are too dim; use an .hdr or .exr file".into(),
        );
    }
    let (file, layer) = file_and_layer(path);
    let (environment, repairs) = Environment::repaired(image::name_of(file, layer), map);
    warnings.extend(repairs);
    Ok((environment, warnings))
}

/// Makes an environment from `constant[:R,G,B]`, `sun-sky[:elevation in degrees]`, `studio` or `orientation`, or reads
/// the file at that path, with the colors that the file says to have. Also returns the repairs, in sentences.
///
/// # Errors
/// A formula with invalid arguments, or an unreadable path.
pub fn from_spec(spec: &str) -> Result<(Environment, Vec<String>), EnvironmentError> {
    from_spec_in(spec, ColorSpace::Srgb)
}

/// The same as [`from_spec`] with the colors of a file in this space. Formulas are in Rec. 709.
///
/// # Errors
/// A formula with invalid arguments, or an unreadable path.
pub fn from_spec_in(spec: &str, color_space: ColorSpace) -> Result<(Environment, Vec<String>), EnvironmentError> {
    let (formula, arguments) = match spec.split_once(':') {
        Some((formula, arguments)) => (formula, Some(arguments)),
        None => (spec, None),
    };
    let numbers = || arguments.map(parse_numbers).transpose();
    let map = match (formula, arguments) {
        ("constant", _) => numbers().and_then(|n| constant_from(n.as_deref())),
        ("sun-sky", _) => numbers().and_then(|n| sky_from(n.as_deref())),
        ("studio", None) => Ok(studio()),
        ("orientation", None) => Ok(orientation()),
        ("studio" | "orientation", Some(_)) => Err(format!("{formula} takes no numbers")),
        _ if is_path(Path::new(spec)) => return read(Path::new(spec), color_space),
        _ => Err("there is no such environment".into()),
    };
    let map = map.map_err(|reason| EnvironmentError::Spec { spec: spec.into(), reason })?;
    Ok((Environment::new(spec.into(), map), Vec::new()))
}

fn is_path(spec: &Path) -> bool {
    let (file, _) = file_and_layer(spec);
    file.exists() || file.extension().is_some()
}

fn parse_numbers(text: &str) -> Result<Vec<f32>, String> {
    let number = |word: &str| word.trim().parse().ok().filter(|x: &f32| x.is_finite());
    text.split(',').map(|w| number(w).ok_or_else(|| format!("\"{w}\" is not a number"))).collect()
}

fn constant_from(numbers: Option<&[f32]>) -> Result<Image, String> {
    let radiance = match numbers {
        None => Vec3::ONE,
        Some(&[gray]) => Vec3::splat(gray),
        Some(&[r, g, b]) => Vec3::new(r, g, b),
        Some(other) => return Err(format!("constant takes three numbers and not {}", other.len())),
    };
    if radiance.min_element() < 0.0 {
        Err("radiance cannot be negative".into())
    } else if radiance.max_element() > MOST_RADIANCE {
        Err(format!("a radiance of {} is above the limit of {MOST_RADIANCE}", radiance.max_element()))
    } else {
        Ok(constant(radiance))
    }
}

fn sky_from(numbers: Option<&[f32]>) -> Result<Image, String> {
    match numbers {
        None => Ok(sun_and_sky(45f32.to_radians())),
        Some(&[elevation]) if (0.0..=90.0).contains(&elevation) => Ok(sun_and_sky(elevation.to_radians())),
        Some(_) => Err("sun-sky takes the elevation of the sun, 0 to 90 degrees".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::output::write_atomically;

    fn written(image: &Image, name: &str) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        image::write(image, &path).unwrap();
        (folder, path)
    }

    #[test]
    fn black_low_range_and_oddly_shaped_maps_are_reported() {
        let (_folder, path) = written(&Image::filled([5, 5], Vec3::ZERO), "black.png");
        let warnings = read(&path, ColorSpace::Srgb).unwrap().1.join("\n");
        for part in ["low dynamic range", "black", "5 x 5"] {
            assert!(warnings.contains(part), "{warnings}");
        }
    }

    #[test]
    fn the_colors_of_a_map_that_says_nothing_are_in_the_space_that_is_asked_for() {
        let (_folder, path) = written(&Image::filled([8, 4], Vec3::new(0.2, 0.6, 0.1)), "plain.hdr");
        let spec = path.display().to_string();
        let first = |space| from_spec_in(&spec, space).unwrap().0.map.pixels[0];
        // Computed apart with the matrices of ACES TB-2014-004 and Bradford; negative radiance is removed.
        let right = Vec3::new(0.0, 0.6574, 0.0331);
        let found = first(ColorSpace::AcesCg);
        assert!((found - right).abs().max_element() < 5e-3, "{found}");
        for plain in [first(ColorSpace::Srgb), first(ColorSpace::Linear), from_spec(&spec).unwrap().0.map.pixels[0]] {
            assert!((plain - right).abs().max_element() > 0.05, "negative control: {plain}");
        }
        let gray = |space| from_spec_in("constant:0.5", space).unwrap().0.map.pixels[0];
        assert_eq!(gray(ColorSpace::AcesCg), gray(ColorSpace::Srgb), "formulas are in Rec. 709");
    }

    #[test]
    fn damaged_and_foreign_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let whole = {
            let (_folder, path) = written(&Image::filled([64, 32], Vec3::ONE), "a.hdr");
            std::fs::read(path).unwrap()
        };
        for (name, bytes) in
            [("cut.hdr", &whole[..whole.len() / 2]), ("foreign.exr", b"solid cube"), ("empty.exr", b"")]
        {
            let path = folder.path().join(name);
            write_atomically(&path, bytes).unwrap();
            let message = read(&path, ColorSpace::Srgb).unwrap_err().to_string();
            assert!(message.ends_with(&format!("({})", path.display())), "{message}");
        }
    }

    #[test]
    fn specifications_are_checked() {
        for good in ["constant", "constant:0.5", "constant:1,2,3", "sun-sky", "sun-sky:10", "studio", "orientation"] {
            let (environment, warnings) = from_spec(good).unwrap();
            assert!(
                warnings.is_empty() && environment.map.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0)
            );
        }
        for bad in ["constant:1,2", "constant:-1", "constant:x", "sun-sky:91", "sun-sky:nan", "studio:3", "sunsky", ""]
        {
            let error = from_spec(bad).unwrap_err();
            assert!(matches!(error, EnvironmentError::Spec { .. }), "{bad}: {error}");
        }
        assert!(matches!(from_spec("nowhere.hdr"), Err(EnvironmentError::Image(_))));
        assert!(from_spec(&format!("constant:{MOST_RADIANCE}")).is_ok());
        let glaring = from_spec("constant:0,1e38,0").unwrap_err().to_string();
        assert!(
            glaring.contains("above the limit of 1000000000000") && glaring.ends_with("(constant:0,1e38,0)"),
            "{glaring}"
        );
    }
}
