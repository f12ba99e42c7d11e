//! Reading and writing lights files.

use super::{Light, LightProblem, LightsFile, MAX_LIGHTS};
use crate::{input, output::write_atomically};
use serde_json::Value;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a lights file cannot be used.
#[derive(Debug, Error)]
pub enum LightsError {
    /// The file system reports an error.
    #[error("cannot {action} the lights file: {source}; check the path and the permissions ({})", path.display())]
    Io {
        /// Read or write.
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The file is not JSON of lights.
    #[error("the file cannot be read as lights: {reason} ({})", path.display())]
    Parse {
        /// Path of the file.
        path: PathBuf,
        /// The problem and its remedy.
        reason: String,
    },
    /// A light is unreadable.
    #[error("light {number} cannot be read: {reason} ({})", path.display())]
    Entry {
        /// Path of the file.
        path: PathBuf,
        /// Number of the light, from 1.
        number: usize,
        /// The problem and its remedy.
        reason: String,
    },
    /// A light has invalid values.
    #[error("light {number}{} cannot shine: {source} ({})", quoted(name), path.display())]
    Light {
        /// Path of the file.
        path: PathBuf,
        /// Number of the light, from 1.
        number: usize,
        /// Its name.
        name: String,
        /// The problem.
        source: LightProblem,
    },
    /// More lights than the limit.
    #[error("there are {count} lights, more than the limit of {MAX_LIGHTS}; merge or remove some ({})", path.display())]
    TooMany {
        /// Path of the file.
        path: PathBuf,
        /// Number of lights.
        count: usize,
    },
}

fn quoted(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!(" \"{name}\"") }
}

impl LightsFile {
    /// Reads and checks a lights file.
    ///
    /// # Errors
    /// A file that is unreadable, not a lights file, or holds invalid or too many lights.
    pub fn read(path: &Path) -> Result<Self, LightsError> {
        let text =
            input::read_text(path).map_err(|source| LightsError::Io { action: "read", path: path.into(), source })?;
        Self::parse(&text, path)
    }

    /// Reads and checks the text of a lights file; `path` is for messages.
    ///
    /// # Errors
    /// See [`Self::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, LightsError> {
        let parse_error = |reason: String| LightsError::Parse { path: path.into(), reason };
        let root: Value = serde_json::from_str(text).map_err(|e| parse_error(e.to_string()))?;
        let entries = root["lights"]
            .as_array()
            .ok_or_else(|| parse_error("it has no list of lights; write {\"lights\": [...]}".into()))?;
        check_count(entries.len(), path)?;
        let entry = |(i, value): (usize, &Value)| {
            read_light(value).map_err(|reason| LightsError::Entry { path: path.into(), number: i + 1, reason })
        };
        let file = Self { lights: entries.iter().enumerate().map(entry).collect::<Result<_, _>>()? };
        file.validate(path)?;
        Ok(file)
    }

    /// Writes the file; an old file stays until the new one is complete.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn write(&self, path: &Path) -> Result<(), LightsError> {
        let io = |source| LightsError::Io { action: "write", path: path.into(), source };
        let text = serde_json::to_string_pretty(self).map_err(|e| io(e.into()))?;
        write_atomically(path, text.as_bytes()).map_err(io)
    }

    /// Checks all lights and their number; `path` is for messages.
    ///
    /// # Errors
    /// The first problem found.
    pub fn validate(&self, path: &Path) -> Result<(), LightsError> {
        check_count(self.lights.len(), path)?;
        for (i, light) in self.lights.iter().enumerate() {
            light.validate().map_err(|source| LightsError::Light {
                path: path.into(),
                number: i + 1,
                name: light.name.clone(),
                source,
            })?;
        }
        Ok(())
    }
}

fn check_count(count: usize, path: &Path) -> Result<(), LightsError> {
    if count > MAX_LIGHTS { Err(LightsError::TooMany { path: path.into(), count }) } else { Ok(()) }
}

/// Parses one light. An unknown key is an error: the intended value would silently be the default.
fn read_light(value: &Value) -> Result<Light, String> {
    let light: Light = serde_json::from_value(value.clone()).map_err(|e| explained(value, &e))?;
    let own: Value = serde_json::to_value(&light).map_err(|e| e.to_string())?;
    let unknown = value.as_object().and_then(|given| given.keys().find(|key| own.get(key).is_none()));
    if let Some(key) = unknown {
        let known: Vec<&str> = own.as_object().into_iter().flat_map(|o| o.keys().map(String::as_str)).collect();
        return Err(format!("it has no \"{key}\"; its keys are {}", known.join(", ")));
    }
    if light.emission.is_aimed() && value.get("target").is_none() {
        return Err("it needs a \"target\": [x, y, z] to point at".into());
    }
    Ok(light)
}

fn explained(value: &Value, error: &serde_json::Error) -> String {
    if value.get("kind").is_some() {
        error.to_string()
    } else {
        "it has no \"kind\"; write point, spot, directional or rectangle".into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::Emission;
    use glam::Vec3;

    const FOUR: &str = r#"{"lights": [
        {"kind": "point", "position": [0, 1, 0], "intensity": [1, 1, 1]},
        {"kind": "spot", "name": "key", "position": [0, 2, 0], "target": [0, 0, 0], "intensity": [1, 2, 3],
         "cone_degrees": 30, "penumbra_degrees": 5},
        {"kind": "directional", "position": [0, 2, 0], "target": [1, 0, 0], "intensity": [1, 1, 1], "enabled": false},
        {"kind": "rectangle", "position": [0, 2, 0], "target": [0, 0, 0], "intensity": [5, 5, 5], "width": 1, "height": 2}
    ]}"#;

    fn parse(text: &str) -> Result<LightsFile, String> {
        LightsFile::parse(text, Path::new("lamps.json")).map_err(|e| e.to_string())
    }

    #[test]
    fn the_four_kinds_are_read_and_come_back() {
        let file = parse(FOUR).unwrap();
        assert_eq!(file.lights.len(), 4);
        assert_eq!(file.lights[1].emission, Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 });
        assert_eq!((file.lights[1].name.as_str(), file.lights[1].intensity), ("key", Vec3::new(1.0, 2.0, 3.0)));
        assert!(file.lights[0].enabled && !file.lights[2].enabled);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lights.json");
        file.write(&path).unwrap();
        assert_eq!(LightsFile::read(&path).unwrap(), file);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("\u{feff}{text}")).unwrap();
        assert_eq!(LightsFile::read(&path).unwrap(), file, "with a byte order mark");
    }

    #[test]
    fn what_is_wrong_is_told_with_the_light_and_the_file() {
        let one = |inner: &str| parse(&format!(r#"{{"lights": [{{{inner}}}]}}"#)).unwrap_err();
        let at = r#""position": [0, 1, 0], "intensity": [1, 1, 1]"#;
        for (inner, words) in [
            (format!(r#""kind": "sun", {at}"#), "directional"),
            (at.to_owned(), "no \"kind\""),
            (r#""kind": "point", "intensity": [1, 1, 1]"#.into(), "position"),
            (format!(r#""kind": "point", "colour": 1, {at}"#), "colour"),
            (format!(r#""kind": "directional", {at}"#), "\"target\""),
            (format!(r#""kind": "spot", "target": [0, 0, 0], "cone_degrees": 95, {at}"#), "95"),
            (format!(r#""kind": "directional", "target": [0, 1, 0], {at}"#), "its position"),
            (r#""kind": "point", "position": [0, 1e39, 0], "intensity": [1, 1, 1]"#.into(), "finite"),
            (r#""kind": "point", "position": [0, 1, 0], "intensity": [1, -1, 1]"#.into(), "negative"),
            (r#""kind": "point", "position": [0, 1], "intensity": [1, 1, 1]"#.into(), "light 1"),
        ] {
            let message = one(&inner);
            assert!(message.contains(words), "{inner}: {message}");
            assert!(message.starts_with("light 1") && message.ends_with("(lamps.json)"), "{message}");
        }
        assert!(parse("{}").unwrap_err().contains("list of lights"));
        assert!(parse("[1, 2").unwrap_err().contains("line 1"));
        assert!(LightsFile::read(Path::new("/nowhere/lamps.json")).unwrap_err().to_string().contains("lamps.json"));
    }

    #[test]
    fn thousands_of_lights_are_read_and_too_many_refused_with_both_numbers() {
        let many = |count: usize| {
            let one = r#"{"kind": "point", "position": [0, 1, 0], "intensity": [1, 1, 1]}"#;
            parse(&format!(r#"{{"lights": [{}]}}"#, vec![one; count].join(",")))
        };
        assert_eq!(many(MAX_LIGHTS).unwrap().lights.len(), MAX_LIGHTS);
        let message = many(MAX_LIGHTS + 1).unwrap_err();
        assert!(message.contains("4097") && message.contains("4096"), "{message}");
    }
}
