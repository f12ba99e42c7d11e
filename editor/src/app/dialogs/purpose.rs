//! The purpose of a file dialog: its title, the files it lists, and how its answer completes the action that asked.

use crate::{
    actions::{
        Action, CameraAction, CompareAction, EnvironmentAction, ExportAction, FileAction, LightAction, MaterialAction,
    },
    preferences::FileUse,
};
use lapidary_core::brdf::ContentKind;
use lapidary_interchange::{
    export,
    formats::{FileFormat, MaterialFormat, PictureFormat, SceneFormat},
};
use std::path::{Path, PathBuf};

/// Kind of dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// One existing file.
    Open,
    /// One or many.
    OpenMany,
    /// A file to write.
    Save,
    /// A folder.
    Folder,
}

/// The purpose of a dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Purpose {
    /// Its title.
    pub title: &'static str,
    /// The label of its button.
    pub button: &'static str,
    /// Which dialog.
    pub mode: Mode,
    /// Name of the listed files.
    pub files: String,
    /// Extensions of the files that are listed; empty for all.
    pub extensions: Vec<&'static str>,
    /// Their purpose, which decides in which folder the dialog begins.
    pub files_for: FileUse,
}

impl Purpose {
    fn new(
        files_for: FileUse,
        [title, button]: [&'static str; 2],
        files: &str,
        mode: Mode,
        extensions: Vec<&'static str>,
    ) -> Self {
        Self { title, button, mode, files: files.into(), extensions, files_for }
    }

    fn load(files_for: FileUse, title: &'static str, files: &str, endings: Vec<&'static str>) -> Self {
        Self::new(files_for, [title, "Load"], files, Mode::Open, endings)
    }

    fn save(files_for: FileUse, title: &'static str, files: &str, endings: Vec<&'static str>) -> Self {
        Self::new(files_for, [title, "Save"], files, Mode::Save, endings)
    }

    fn picture(title: &'static str, endings: Vec<&'static str>) -> Self {
        Self::new(FileUse::Picture, [title, "Export"], "Pictures", Mode::Save, endings)
    }

    fn folder(files_for: FileUse, title: &'static str, button: &'static str) -> Self {
        Self::new(files_for, [title, button], "Folders", Mode::Folder, Vec::new())
    }

    /// The purpose of a dialog for an action's path; `None` for actions without one.
    pub fn of(action: &Action) -> Option<Self> {
        let pictures = || PictureFormat::all_endings(|_| true);
        let materials = || MaterialFormat::all_endings(|format| format.loads);
        Some(match action {
            Action::File(FileAction::Open(_)) => {
                let texts = ["Open a scene, a baked scene or a session", "Open"];
                let endings = [SceneFormat::richest_first(), vec!["cuts", "lapidary"]].concat();
                Self::new(FileUse::Scene, texts, "Scenes, baked scenes, sessions", Mode::Open, endings)
            }
            Action::File(FileAction::SaveAs(_)) => {
                Self::save(FileUse::Session, "Save the session", "Sessions", vec!["lapidary"])
            }
            Action::File(FileAction::Relink(_)) => {
                Self::folder(FileUse::Missing, "Search a folder for the files", "Search here")
            }
            Action::Camera(CameraAction::Backplate(_)) => {
                Self::load(FileUse::Backplate, "Put a picture behind the scene", "Pictures", pictures())
            }
            Action::Export(ExportAction::Picture(_)) => {
                Self::picture("Export the picture", PictureFormat::all_endings(PictureFormat::is_written))
            }
            Action::Export(ExportAction::Layers(_)) => Self::picture("Export the picture with layers", vec!["exr"]),
            Action::Export(ExportAction::Materials(_)) => {
                let files = MaterialFormat::exported().join(", ");
                Self::new(FileUse::Material, ["Export the materials", "Export"], &files, Mode::Save, export::endings())
            }
            Action::Export(ExportAction::SequenceFolder(_)) => {
                Self::folder(FileUse::Picture, "Choose a folder for the frames", "Choose")
            }
            Action::Export(ExportAction::PicturesFolder(_)) => {
                Self::folder(FileUse::Picture, "Choose a folder for the pictures", "Choose")
            }
            Action::Material(MaterialAction::LoadTexture { .. }) => {
                Self::load(FileUse::Texture, "Load a texture", "Pictures", pictures())
            }
            Action::Material(MaterialAction::LoadBrdf { .. }) => {
                Self::load(FileUse::Material, "Load a BRDF", "BRDFs", ContentKind::EXTENSIONS.to_vec())
            }
            Action::Material(MaterialAction::Load { .. }) => {
                Self::load(FileUse::Material, "Load a material", "Materials", materials())
            }
            Action::Material(MaterialAction::Save { .. }) => {
                Self::save(FileUse::Material, "Save the material", "Materials", materials())
            }
            Action::Light(LightAction::Load(_)) => {
                Self::load(FileUse::Lights, "Add the lights of a file", "Lights", vec!["json"])
            }
            Action::Light(LightAction::Save(_)) => {
                Self::save(FileUse::Lights, "Save the lights", "Lights", vec!["json"])
            }
            Action::Environment(EnvironmentAction::Load(_)) => {
                Self::load(FileUse::Environment, "Load an environment", "Environments", pictures())
            }
            Action::Environment(EnvironmentAction::AddToLibrary(_)) => {
                let texts = ["Add environments to the library", "Add"];
                Self::new(FileUse::Environment, texts, "Environments", Mode::OpenMany, pictures())
            }
            Action::Compare(CompareAction::Reference(_)) => {
                let texts = ["Compare with a picture", "Compare"];
                Self::new(FileUse::Reference, texts, "Pictures", Mode::Open, pictures())
            }
            _ => return None,
        })
    }

    /// A path to write gets the first extension if it has none of them, and keeps one where a whole name was typed before
    /// the suggested extension.
    pub fn with_extension(&self, path: PathBuf) -> PathBuf {
        let known = |path: &Path| {
            let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
            self.extensions.contains(&extension.as_str())
        };
        let inner = path.with_extension("");
        match self.extensions.first() {
            Some(_) if self.mode == Mode::Save && known(&path) && known(&inner) => inner,
            Some(first) if self.mode == Mode::Save && !known(&path) => {
                let mut name = path.into_os_string();
                name.push(".");
                name.push(first);
                name.into()
            }
            _ => path,
        }
    }
}

/// The action with its path.
pub fn with_path(action: &Action, chosen: PathBuf) -> Action {
    let mut action = action.clone();
    if let Some(path) = action.path() {
        *path = Some(chosen);
    }
    action
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_completes_the_action() {
        let ask = Action::Material(MaterialAction::LoadTexture { material: 3, map: "bump", path: None });
        let Action::Material(MaterialAction::LoadTexture { material, map, path }) = with_path(&ask, "a.png".into())
        else {
            panic!()
        };
        assert_eq!((material, map, path), (3, "bump", Some("a.png".into())));
        assert!(Purpose::of(&Action::Undo).is_none());
    }

    #[test]
    fn files_to_write_have_an_extension_and_others_stay_as_they_are() {
        let save = Purpose::of(&Action::Export(ExportAction::Picture(None))).unwrap();
        assert_eq!(save.with_extension("a".into()), PathBuf::from("a.png"));
        assert_eq!(save.with_extension("a.b".into()), PathBuf::from("a.b.png"));
        assert_eq!(save.with_extension("a.EXR".into()), PathBuf::from("a.EXR"));
        assert_eq!(save.with_extension("a.exr.png".into()), PathBuf::from("a.exr"), "typed before the suggestion");
        let open = Purpose::of(&Action::File(FileAction::Open(None))).unwrap();
        assert_eq!(open.with_extension("a".into()), PathBuf::from("a"));
    }
}
