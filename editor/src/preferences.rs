//! Looks of the window and folders of file dialogs, kept between runs and apart from sessions.

use crate::document::{folder_of, session::read_leniently, write_setting};
use anyhow::Result;
use lapidary_core::input;
use lapidary_studies::args::MeasuredPath;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::Value;
use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

/// Looks of the window, and folders of its file dialogs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Dark or light.
    pub theme: Theme,
    /// Scale of the interface, 0.5 to 3; 1 is 96 points an inch.
    pub ui_scale: f32,
    /// Width and height of the window in points.
    pub window_size: [f32; 2],
    /// Width of the left side in points.
    pub side_width: f32,
    /// Width of the inspector in points.
    pub inspector_width: f32,
    /// Whether a scene without a bake is baked when it opens.
    pub bakes_scenes: bool,
    /// Whether cuts are baked anew by themselves where a moved object or an edited opacity reaches.
    pub follows_edits: bool,
    /// The path of the graphics adapter that was faster.
    pub gpu_path: Option<MeasuredPath>,
    /// Folders in which file dialogs begin.
    pub folders: LastFolders,
    /// Folders whose scenes and materials may name files elsewhere.
    pub outside: AllowedFolders,
}

/// Purpose of a chosen file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileUse {
    /// Scenes and bakes to open.
    Scene,
    /// Sessions to write.
    Session,
    /// Environments.
    Environment,
    /// Maps of materials.
    Texture,
    /// Materials.
    Material,
    /// Lights files.
    Lights,
    /// Pictures to write.
    Picture,
    /// Pictures to compare with.
    Reference,
    /// Pictures behind the scene.
    Backplate,
    /// Folders to search for missing files.
    Missing,
}

/// The folders in which files were chosen last, by purpose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LastFolders {
    scene: Option<PathBuf>,
    session: Option<PathBuf>,
    environment: Option<PathBuf>,
    texture: Option<PathBuf>,
    material: Option<PathBuf>,
    lights: Option<PathBuf>,
    picture: Option<PathBuf>,
    reference: Option<PathBuf>,
    backplate: Option<PathBuf>,
    missing: Option<PathBuf>,
}

impl LastFolders {
    /// The last folder, if it is still there.
    pub fn of(&self, files: FileUse) -> Option<PathBuf> {
        self.clone().slot(files).take().filter(|folder| folder.is_dir())
    }

    /// Remembers a folder, unless its name is not Unicode and cannot be written to the preferences.
    pub fn remember(&mut self, files: FileUse, folder: &Path) {
        if folder.to_str().is_some() {
            *self.slot(files) = Some(folder.to_owned());
        }
    }

    fn slot(&mut self, files: FileUse) -> &mut Option<PathBuf> {
        match files {
            FileUse::Scene => &mut self.scene,
            FileUse::Session => &mut self.session,
            FileUse::Environment => &mut self.environment,
            FileUse::Texture => &mut self.texture,
            FileUse::Material => &mut self.material,
            FileUse::Lights => &mut self.lights,
            FileUse::Picture => &mut self.picture,
            FileUse::Reference => &mut self.reference,
            FileUse::Backplate => &mut self.backplate,
            FileUse::Missing => &mut self.missing,
        }
    }
}

/// Folders of scenes and materials that may name files outside them; the user was asked for each.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct AllowedFolders(#[serde(serialize_with = "those_of_unicode")] Vec<PathBuf>);

impl AllowedFolders {
    /// Whether a file may refer to files outside its folder.
    pub fn allow(&self, file: &Path) -> bool {
        folder_after_links(file).is_some_and(|folder| self.0.contains(&folder))
    }

    /// Remembers the folder of a file. A folder whose name is not Unicode cannot be written to the preferences, and is forgotten
    /// when the program ends.
    pub fn remember(&mut self, file: &Path) {
        let folder = folder_after_links(file);
        self.0.extend(folder.filter(|folder| !self.0.contains(folder)));
    }
}

fn those_of_unicode<S: Serializer>(folders: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(folders.iter().filter_map(|folder| folder.to_str()))
}

fn folder_after_links(file: &Path) -> Option<PathBuf> {
    folder_of(file).canonicalize().ok()
}

/// Dark or light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Theme {
    /// Light text on dark gray: keeps the eye on the picture.
    #[default]
    Dark,
    /// Dark text on light gray.
    Light,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            theme: Theme::default(),
            ui_scale: 1.0,
            window_size: [1440.0, 900.0],
            side_width: 230.0,
            inspector_width: 340.0,
            bakes_scenes: true,
            follows_edits: true,
            gpu_path: None,
            folders: LastFolders::default(),
            outside: AllowedFolders::default(),
        }
    }
}

/// Least and greatest width of the left side in points.
pub const SIDE_WIDTHS: [f32; 2] = [160.0, 480.0];
/// Least and greatest width of the inspector in points; its rows need the least width.
pub const INSPECTOR_WIDTHS: [f32; 2] = [280.0, 640.0];

/// Name of the file in the configuration folder.
const FILE: &str = "preferences.json";

impl Preferences {
    /// Reads the preferences. Unreadable ones have their defaults, with a message for the user. A missing file gives no message.
    pub fn load(config: &Path) -> (Self, Option<String>) {
        let file = config.join(FILE);
        let parsed = match input::read_text(&file) {
            Ok(text) => serde_json::from_str(&text).map_err(|e| e.to_string()),
            Err(error) if error.kind() == ErrorKind::NotFound => return Default::default(),
            Err(error) => Err(error.to_string()),
        };
        let mut problems = Vec::new();
        let preferences = match parsed {
            Ok(given) => read_leniently::<Self>(&given, Self::default(), "", &mut problems).0,
            Err(reason) => {
                problems.push(reason);
                Self::default()
            }
        };
        let message = format!(
            "some preferences cannot be read: {}; they have their defaults, set them again ({})",
            problems.join("; "),
            file.display()
        );
        (preferences.clamped(), (!problems.is_empty()).then_some(message))
    }

    /// Keeps the preferences for the next start.
    ///
    /// # Errors
    /// Errors of the file system, with the remedy.
    pub fn save(&self, config: &Path) -> Result<()> {
        let value: Value = serde_json::to_value(self.clone().clamped())?;
        write_setting(&config.join(FILE), &format!("{value:#}\n"))
    }

    /// Limits scale and sizes to a usable range.
    pub fn clamped(self) -> Self {
        let usual = Self::default();
        let clamp = |x: f32, [low, high]: [f32; 2], default: f32| if x.is_nan() { default } else { x.clamp(low, high) };
        let [width, height] = self.window_size;
        Self {
            theme: self.theme,
            ui_scale: clamp(self.ui_scale, [0.5, 3.0], usual.ui_scale),
            window_size: [
                clamp(width, [800.0, 16_384.0], usual.window_size[0]),
                clamp(height, [500.0, 16_384.0], usual.window_size[1]),
            ],
            side_width: clamp(self.side_width, SIDE_WIDTHS, usual.side_width),
            inspector_width: clamp(self.inspector_width, INSPECTOR_WIDTHS, usual.inspector_width),
            bakes_scenes: self.bakes_scenes,
            follows_edits: self.follows_edits,
            gpu_path: self.gpu_path,
            folders: self.folders,
            outside: self.outside,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_render::gpu::GpuPath;

    #[test]
    fn preferences_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("not/there/yet");
        assert_eq!(Preferences::load(&config), (Preferences::default(), None));
        let mut folders = LastFolders::default();
        folders.remember(FileUse::Texture, folder.path());
        let mut outside = AllowedFolders::default();
        outside.remember(&folder.path().join("scene.gltf"));
        assert!(outside.allow(&folder.path().join("other.json")) && !outside.allow(&folder.path().join("not/a.gltf")));
        let preferences = Preferences {
            theme: Theme::Light,
            ui_scale: 1.25,
            side_width: 300.0,
            bakes_scenes: false,
            follows_edits: false,
            gpu_path: Some(MeasuredPath { adapter: "a card".into(), path: GpuPath::Compute }),
            folders,
            outside,
            ..Default::default()
        };
        preferences.save(&config).unwrap();
        assert_eq!(Preferences::load(&config), (preferences, None));
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_cannot_be_written_down_is_allowed_until_the_end() {
        use std::os::unix::ffi::OsStrExt;
        let folder = tempfile::tempdir().unwrap();
        let odd = folder.path().join(std::ffi::OsStr::from_bytes(b"\xff"));
        // Some file systems reject such names.
        if std::fs::create_dir(&odd).is_err() {
            return;
        }
        let mut preferences = Preferences::default();
        preferences.outside.remember(&odd.join("a.gltf"));
        preferences.outside.remember(&folder.path().join("a.gltf"));
        assert!(preferences.outside.allow(&odd.join("a.gltf")));
        preferences.save(folder.path()).unwrap();
        let (later, message) = Preferences::load(folder.path());
        assert_eq!(message, None);
        assert!(!later.outside.allow(&odd.join("a.gltf")) && later.outside.allow(&folder.path().join("a.gltf")));
    }

    #[test]
    fn damage_gives_defaults_and_a_message_and_costs_no_more_than_it_must() {
        let folder = tempfile::tempdir().unwrap();
        for (text, expected, complains) in [
            ("{\"theme\": \"light\"", Preferences::default(), true),
            ("[]", Preferences::default(), true),
            (
                "{\"theme\": \"light\", \"ui_scale\": \"big\"}",
                Preferences { theme: Theme::Light, ..Default::default() },
                true,
            ),
            ("{\"ui_scale\": 99, \"later\": 1}", Preferences { ui_scale: 3.0, ..Default::default() }, false),
        ] {
            std::fs::write(folder.path().join(FILE), text).unwrap();
            let (preferences, message) = Preferences::load(folder.path());
            assert_eq!((preferences, message.is_some()), (expected, complains), "{text}");
        }
        std::fs::write(folder.path().join(FILE), r#"{"folders": {"scene": 7, "texture": "/"}}"#).unwrap();
        let (preferences, message) = Preferences::load(folder.path());
        let folders = [FileUse::Scene, FileUse::Texture].map(|files| preferences.folders.of(files));
        assert_eq!((folders, message.is_some()), ([None, Some(PathBuf::from("/"))], true));
        assert_eq!(Preferences { ui_scale: f32::NAN, ..Default::default() }.clamped().ui_scale, 1.0);
        assert_eq!(Preferences { ui_scale: 0.0, ..Default::default() }.clamped().ui_scale, 0.5);
    }
}
