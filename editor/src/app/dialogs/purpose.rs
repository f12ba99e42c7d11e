//! The purpose of a file dialog: its title, the files it lists, and how its answer completes the action that asked.

use crate::{actions::Action, preferences::FileUse};
use lapidary_core::brdf::ContentKind;
use lapidary_interchange::{
    export,
    formats::{FileFormat, MaterialFormat, PictureFormat, SceneFormat},
};
use std::path::{Path, PathBuf};

/// Which dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// One file that is there.
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
    /// The purpose of a dialog for an action's path; `None` for actions without one.
    pub fn of(action: &Action) -> Option<Self> {
        let pictures = &PictureFormat::all_endings(|_| true)[..];
        let materials = &MaterialFormat::all_endings(|format| format.loads)[..];
        let purpose = |files_for, title, button, mode, files: &str, extensions: &[&'static str]| Self {
            title,
            button,
            mode,
            files: files.into(),
            extensions: extensions.to_vec(),
            files_for,
        };
        Some(match action {
            Action::Open(_) => purpose(
                FileUse::Scene,
                "Open a scene, a baked scene or a session",
                "Open",
                Mode::Open,
                "Scenes, baked scenes, sessions",
                &[&SceneFormat::richest_first()[..], &["cuts", "lapidary"]].concat(),
            ),
            Action::SaveAs(_) => {
                purpose(FileUse::Session, "Save the session", "Save", Mode::Save, "Sessions", &["lapidary"])
            }
            Action::ExportPicture(_) => {
                let extensions = PictureFormat::all_endings(PictureFormat::is_written);
                purpose(FileUse::Picture, "Export the picture", "Export", Mode::Save, "Pictures", &extensions)
            }
            Action::ExportLayers(_) => {
                purpose(FileUse::Picture, "Export the picture with layers", "Export", Mode::Save, "Pictures", &["exr"])
            }
            Action::ExportMaterials(_) => {
                let (title, files) = ("Export the materials", MaterialFormat::exported().join(", "));
                purpose(FileUse::Material, title, "Export", Mode::Save, &files, &export::endings())
            }
            Action::SequenceFolder(_) => {
                purpose(FileUse::Picture, "Choose the folder of the frames", "Choose", Mode::Folder, "Folders", &[])
            }
            Action::LoadTexture { .. } => {
                purpose(FileUse::Texture, "Load a texture", "Load", Mode::Open, "Pictures", pictures)
            }
            Action::LoadBrdf { .. } => {
                purpose(FileUse::Material, "Load a BRDF", "Load", Mode::Open, "BRDFs", ContentKind::EXTENSIONS)
            }
            Action::LoadMaterial { .. } => {
                purpose(FileUse::Material, "Load a material", "Load", Mode::Open, "Materials", materials)
            }
            Action::SaveMaterial { .. } => {
                purpose(FileUse::Material, "Save the material", "Save", Mode::Save, "Materials", materials)
            }
            Action::LoadLights(_) => {
                purpose(FileUse::Lights, "Add the lights of a file", "Load", Mode::Open, "Lights", &["json"])
            }
            Action::SaveLights(_) => {
                purpose(FileUse::Lights, "Save the lights", "Save", Mode::Save, "Lights", &["json"])
            }
            Action::LoadEnvironment(_) => {
                purpose(FileUse::Environment, "Load an environment", "Load", Mode::Open, "Environments", pictures)
            }
            Action::AddToLibrary(_) => {
                let title = "Add environments to the library";
                purpose(FileUse::Environment, title, "Add", Mode::OpenMany, "Environments", pictures)
            }
            Action::ChooseReference(_) => {
                purpose(FileUse::Reference, "Compare with a picture", "Compare", Mode::Open, "Pictures", pictures)
            }
            Action::Relink(_) => {
                purpose(FileUse::Missing, "Look for the files in a folder", "Look here", Mode::Folder, "Folders", &[])
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
    match &mut action {
        Action::Open(path)
        | Action::ChooseReference(path)
        | Action::SaveAs(path)
        | Action::ExportPicture(path)
        | Action::ExportLayers(path)
        | Action::SequenceFolder(path)
        | Action::LoadTexture { path, .. }
        | Action::LoadBrdf { path, .. }
        | Action::LoadMaterial { path, .. }
        | Action::SaveMaterial { path, .. }
        | Action::LoadLights(path)
        | Action::SaveLights(path)
        | Action::LoadEnvironment(path)
        | Action::AddToLibrary(path)
        | Action::Relink(path) => *path = Some(chosen),
        _ => {}
    }
    action
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_completes_the_action() {
        let ask = Action::LoadTexture { material: 3, map: "bump", path: None };
        let Action::LoadTexture { material, map, path } = with_path(&ask, "a.png".into()) else { panic!() };
        assert_eq!((material, map, path), (3, "bump", Some("a.png".into())));
        assert!(Purpose::of(&Action::Undo).is_none());
    }

    #[test]
    fn files_to_write_have_an_extension_and_others_stay_as_they_are() {
        let save = Purpose::of(&Action::ExportPicture(None)).unwrap();
        assert_eq!(save.with_extension("a".into()), PathBuf::from("a.png"));
        assert_eq!(save.with_extension("a.b".into()), PathBuf::from("a.b.png"));
        assert_eq!(save.with_extension("a.EXR".into()), PathBuf::from("a.EXR"));
        assert_eq!(save.with_extension("a.exr.png".into()), PathBuf::from("a.exr"), "typed before the suggestion");
        let open = Purpose::of(&Action::Open(None)).unwrap();
        assert_eq!(open.with_extension("a".into()), PathBuf::from("a"));
    }
}
