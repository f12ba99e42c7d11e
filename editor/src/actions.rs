//! Requests of the interface. Panels only read the document; every change that they ask for is an [`Action`].

mod bake;
mod camera;
mod compare;
mod environment;
mod export;
mod file;
mod ladder;
mod lights;
mod materials;
mod pose;
mod select;

pub use bake::BakeAction;
pub use camera::CameraAction;
pub use compare::CompareAction;
pub use environment::EnvironmentAction;
pub use export::ExportAction;
pub use file::FileAction;
pub use ladder::LadderAction;
pub use lights::LightAction;
pub use materials::MaterialAction;
pub use pose::PoseAction;
pub use select::SelectAction;

use crate::{document::Edit, preferences::Preferences};
use std::path::PathBuf;

/// A request that is performed after the interface of a frame has run. For a path of `None` a dialog asks.
#[derive(Clone, Debug)]
pub enum Action {
    /// Change the document. Edits of the same label and target during one gesture become one step of undo.
    Edit {
        /// The new value.
        edit: Edit,
        /// Its name in undo, such as "Roughness". Of poses it is what is done, such as "Move", and undo adds to what.
        label: &'static str,
    },
    /// A slider was let go or a text field left: the next edit is a new step of undo.
    EndGesture,
    /// Take back the last edit.
    Undo,
    /// Do the last undone edit again.
    Redo,
    /// Change how the window looks, or where its file dialogs begin.
    Preferences(Preferences),
    /// Show or hide the keyboard map.
    ToggleKeys,
    /// Explain a pixel of the live picture, by its column and row.
    ExplainPixel([u32; 2]),
    /// Close the window, after asking about unsaved changes.
    Quit,
    /// About bakes.
    Bake(BakeAction),
    /// About the comparison with a reference.
    Compare(CompareAction),
    /// About the ladder of cut sizes.
    Ladder(LadderAction),
    /// About what is written of the picture and the scene.
    Export(ExportAction),
    /// About local lights.
    Light(LightAction),
    /// About materials, and parts that have them.
    Material(MaterialAction),
    /// About environments and their library.
    Environment(EnvironmentAction),
    /// About animations.
    Pose(PoseAction),
    /// About the camera.
    Camera(CameraAction),
    /// About the selection.
    Select(SelectAction),
    /// About files that are opened and saved.
    File(FileAction),
}

impl Action {
    /// Its path, if it has one.
    pub fn path(&mut self) -> Option<&mut Option<PathBuf>> {
        match self {
            Self::File(action) => action.path(),
            Self::Export(action) => action.path(),
            Self::Compare(action) => action.path(),
            Self::Light(action) => action.path(),
            Self::Material(action) => action.path(),
            Self::Environment(action) => action.path(),
            _ => None,
        }
    }
}
