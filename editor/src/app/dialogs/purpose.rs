//! The purpose of a file dialog: its title, the files it lists, and how its answer completes the action that asked.

use crate::{
    actions::{Action, CompareAction, EnvironmentAction, ExportAction, FileAction, LightAction, MaterialAction},
    preferences::FileUse,
};
use lapidary_interchange::export::FORMATS;
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Purpose {
    /// Its title.
    pub title: &'static str,
    /// The label of its button.
    pub button: &'static str,
    /// Which dialog.
    pub mode: Mode,
    /// Name of the listed files.
    pub files: &'static str,
    /// Extensions of the files that are listed; empty for all.
    pub extensions: &'static [&'static str],
    /// Their purpose, which decides in which folder the dialog begins.
    pub files_for: FileUse,
}

const PICTURES: &[&str] = &["png", "jpg", "jpeg", "tga", "hdr", "exr"];
const MATERIALS: &[&str] = &["json", "mtlx"];
const BRDFS: &[&str] = lapidary_core::brdf::ContentKind::EXTENSIONS;
const LIGHTS: &[&str] = &["json"];

const SCENES: &[&str] = &["gltf", "glb", "obj", "ply", "cuts", "lapidary"];
const OPEN: Purpose = Purpose::new(
    FileUse::Scene,
    ["Open a scene, a baked scene or a session", "Open", "Scenes, baked scenes, sessions"],
    Mode::Open,
    SCENES,
);
const SAVE_SESSION: Purpose =
    Purpose::new(FileUse::Session, ["Save the session", "Save", "Sessions"], Mode::Save, &["lapidary"]);
const LOOK_FOR_FILES: Purpose =
    Purpose::new(FileUse::Missing, ["Look for the files in a folder", "Look here", "Folders"], Mode::Folder, &[]);
const EXPORT_PICTURE: Purpose =
    Purpose::new(FileUse::Picture, ["Export the picture", "Export", "Pictures"], Mode::Save, &["png", "exr", "hdr"]);
const EXPORT_LAYERS: Purpose =
    Purpose::new(FileUse::Picture, ["Export the picture with layers", "Export", "Pictures"], Mode::Save, &["exr"]);
const EXPORT_MATERIALS: Purpose =
    Purpose::new(FileUse::Material, ["Export the materials", "Export", "MaterialX, MTL, glTF"], Mode::Save, &FORMATS);
const CHOOSE_FRAMES: Purpose =
    Purpose::new(FileUse::Picture, ["Choose the folder of the frames", "Choose", "Folders"], Mode::Folder, &[]);
const LOAD_TEXTURE: Purpose =
    Purpose::new(FileUse::Texture, ["Load a texture", "Load", "Pictures"], Mode::Open, PICTURES);
const LOAD_BRDF: Purpose = Purpose::new(FileUse::Material, ["Load a BRDF", "Load", "BRDFs"], Mode::Open, BRDFS);
const LOAD_MATERIAL: Purpose =
    Purpose::new(FileUse::Material, ["Load a material", "Load", "Materials"], Mode::Open, MATERIALS);
const SAVE_MATERIAL: Purpose =
    Purpose::new(FileUse::Material, ["Save the material", "Save", "Materials"], Mode::Save, MATERIALS);
const LOAD_LIGHTS: Purpose =
    Purpose::new(FileUse::Lights, ["Add the lights of a file", "Load", "Lights"], Mode::Open, LIGHTS);
const SAVE_LIGHTS: Purpose = Purpose::new(FileUse::Lights, ["Save the lights", "Save", "Lights"], Mode::Save, LIGHTS);
const LOAD_ENVIRONMENT: Purpose =
    Purpose::new(FileUse::Environment, ["Load an environment", "Load", "Environments"], Mode::Open, PICTURES);
const ADD_TO_LIBRARY: Purpose = Purpose::new(
    FileUse::Environment,
    ["Add environments to the library", "Add", "Environments"],
    Mode::OpenMany,
    PICTURES,
);
const COMPARE: Purpose =
    Purpose::new(FileUse::Reference, ["Compare with a picture", "Compare", "Pictures"], Mode::Open, PICTURES);

impl Purpose {
    const fn new(
        files_for: FileUse,
        [title, button, files]: [&'static str; 3],
        mode: Mode,
        extensions: &'static [&'static str],
    ) -> Self {
        Self { title, button, mode, files, extensions, files_for }
    }

    /// The purpose of a dialog for an action's path; `None` for actions without one.
    pub fn of(action: &Action) -> Option<Self> {
        Some(match action {
            Action::File(FileAction::Open(_)) => OPEN,
            Action::File(FileAction::SaveAs(_)) => SAVE_SESSION,
            Action::File(FileAction::Relink(_)) => LOOK_FOR_FILES,
            Action::Export(ExportAction::Picture(_)) => EXPORT_PICTURE,
            Action::Export(ExportAction::Layers(_)) => EXPORT_LAYERS,
            Action::Export(ExportAction::Materials(_)) => EXPORT_MATERIALS,
            Action::Export(ExportAction::SequenceFolder(_)) => CHOOSE_FRAMES,
            Action::Material(MaterialAction::LoadTexture { .. }) => LOAD_TEXTURE,
            Action::Material(MaterialAction::LoadBrdf { .. }) => LOAD_BRDF,
            Action::Material(MaterialAction::Load { .. }) => LOAD_MATERIAL,
            Action::Material(MaterialAction::Save { .. }) => SAVE_MATERIAL,
            Action::Light(LightAction::Load(_)) => LOAD_LIGHTS,
            Action::Light(LightAction::Save(_)) => SAVE_LIGHTS,
            Action::Environment(EnvironmentAction::Load(_)) => LOAD_ENVIRONMENT,
            Action::Environment(EnvironmentAction::AddToLibrary(_)) => ADD_TO_LIBRARY,
            Action::Compare(CompareAction::Reference(_)) => COMPARE,
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
