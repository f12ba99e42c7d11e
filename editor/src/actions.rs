//! Requests of the interface. Panels only read the document; every change that they ask for is an [`Action`].

use crate::{
    document::{Edit, handling::PlacedPivot, lights::LightKind},
    preferences::Preferences,
};
use glam::Vec3;
use lapidary_core::{animation::ClipTime, camera::Camera, dataset::BakeParts, material::Material, parts::Part};
use lapidary_studies::ladder::Cuts;
use std::path::PathBuf;

/// A request, performed after the interface of a frame has run. For a path of `None` a dialog asks.
#[derive(Clone, Debug)]
pub enum Action {
    /// Change the document. Edits of the same label and target during one gesture become one step of undo.
    Edit {
        /// The new value.
        edit: Edit,
        /// Its name in undo, such as "Roughness". For poses it is a verb, such as "Move", to which undo adds the object.
        label: &'static str,
    },
    /// A slider was released or a text field left: the next edit is a new step of undo.
    EndGesture,
    /// Take back the last edit.
    Undo,
    /// Do the last undone edit again.
    Redo,
    /// Change how the window looks, or where its file dialogs begin.
    Preferences(Box<Preferences>),
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
    /// About exports of the picture and the scene.
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
    /// About looks.
    Look(LookAction),
    /// About the selection.
    Select(SelectAction),
    /// About files that are opened and saved.
    File(FileAction),
}

impl Action {
    /// The change to these preferences.
    pub fn prefer(preferences: Preferences) -> Self {
        Self::Preferences(Box::new(preferences))
    }

    /// Its path, if it has one.
    pub fn path(&mut self) -> Option<&mut Option<PathBuf>> {
        match self {
            Self::File(FileAction::Open(path) | FileAction::SaveAs(path) | FileAction::Relink(path))
            | Self::Material(
                MaterialAction::LoadTexture { path, .. }
                | MaterialAction::LoadBrdf { path, .. }
                | MaterialAction::Load { path, .. }
                | MaterialAction::Save { path, .. },
            )
            | Self::Light(LightAction::Load(path) | LightAction::Save(path))
            | Self::Environment(EnvironmentAction::Load(path) | EnvironmentAction::AddToLibrary(path))
            | Self::Camera(CameraAction::Backplate(path))
            | Self::Compare(CompareAction::Reference(path))
            | Self::Export(
                ExportAction::Picture(path)
                | ExportAction::Layers(path)
                | ExportAction::Materials(path)
                | ExportAction::SequenceFolder(path)
                | ExportAction::PicturesFolder(path),
            ) => Some(path),
            _ => None,
        }
    }
}

/// A request about files that are opened and saved.
#[derive(Clone, Debug)]
pub enum FileAction {
    /// Open a scene, a dataset or a session.
    Open(Option<PathBuf>),
    /// Open another scene of the document's scene file, by name; `None` for its default.
    OpenSceneIn(Option<String>),
    /// Open a bundled scene, by its place in the menu.
    OpenBundled(usize),
    /// Write the session.
    Save,
    /// Write the session under another name.
    SaveAs(Option<PathBuf>),
    /// Look for files that moved, in this folder.
    Relink(Option<PathBuf>),
}

/// A request about the camera.
#[derive(Clone, Debug)]
pub enum CameraAction {
    /// Move the camera.
    To(Camera),
    /// Move back so that the selection, or the scene, is in view.
    FrameSelection,
    /// Put a picture behind the scene.
    Backplate(Option<PathBuf>),
    /// Wait for a click on what is to be sharp.
    AskForFocus,
    /// Focus a point, and end the wait; without a point only end it.
    Focus(Option<Vec3>),
    /// Frame the whole scene.
    FrameAll,
    /// Return to the first view of the document.
    Reset,
    /// Put the camera on the clipboard as text.
    Copy,
    /// Take the camera from the clipboard.
    Paste,
}

/// A request about the selection.
#[derive(Clone, Debug)]
pub enum SelectAction {
    /// Select an object alone, or nothing.
    Object(Option<u32>),
    /// Add an object to the selection, or take it away.
    Toggle(u32),
    /// Select a material, or nothing.
    Material(Option<usize>),
    /// Select a part of an object.
    Part(Part),
}

/// A request about looks.
#[derive(Clone, Debug)]
pub enum LookAction {
    /// Put a look in place, by its number.
    Show(usize),
    /// Describe pictures of the looks to write.
    Describe,
}

/// A request about animations.
#[derive(Clone, Debug)]
pub enum PoseAction {
    /// Show a time of an animation, or the scene at rest.
    ClipTime(Option<ClipTime>),
    /// Play the animation, or stop.
    Play,
    /// Wait for a click that places the pivot of the selected object.
    AskForPivot,
    /// Place the pivot of the active object, in the world, and end the wait; without a pivot only end it.
    PlacePivot(Option<PlacedPivot>),
    /// Show these objects alone, or end that.
    Isolate(Vec<u32>),
}

/// A request about materials, and parts that have them.
#[derive(Clone, Debug)]
pub enum MaterialAction {
    /// Use a picture as a map of a material.
    LoadTexture {
        /// Which material.
        material: usize,
        /// Which map.
        map: &'static str,
        /// The picture.
        path: Option<PathBuf>,
    },
    /// Use the BRDF of a file for a material.
    LoadBrdf {
        /// Which material.
        material: usize,
        /// The file.
        path: Option<PathBuf>,
    },
    /// Replace a material with one from a file.
    Load {
        /// Which material.
        material: usize,
        /// The material file.
        path: Option<PathBuf>,
    },
    /// Write a material to a file.
    Save {
        /// Which material.
        material: usize,
        /// The material file.
        path: Option<PathBuf>,
    },
    /// Give a part another material of the document.
    Assign {
        /// Which part.
        part: Part,
        /// Which material.
        material: usize,
    },
    /// Give a part a material of its own.
    MakeUnique {
        /// Which part.
        part: Part,
        /// The material; `None` copies the part's present one.
        material: Option<Box<Material>>,
    },
    /// Show a material variant, or the file's default.
    ChooseVariant(Option<usize>),
}

/// A request about local lights.
#[derive(Clone, Debug)]
pub enum LightAction {
    /// Select a local light, or nothing.
    Select(Option<usize>),
    /// Add a local light that lights the camera's target.
    Add(LightKind),
    /// Add a copy of a local light beside it.
    Duplicate(usize),
    /// Remove a local light.
    Delete(usize),
    /// Aim the selected light at a point and end aiming by click; without a point only end it.
    Aim(Option<Vec3>),
    /// Add the lights of a lights file.
    Load(Option<PathBuf>),
    /// Write the lights to a lights file.
    Save(Option<PathBuf>),
}

/// A request about environments and their library.
#[derive(Clone, Debug)]
pub enum EnvironmentAction {
    /// Light the scene by a map.
    Load(Option<PathBuf>),
    /// Add maps to the library of environments.
    AddToLibrary(Option<PathBuf>),
}

/// A request about bakes.
#[derive(Clone, Debug)]
pub enum BakeAction {
    /// Bake the scene with the document's settings; with `resume` from its checkpoint.
    Begin {
        /// Go on from the checkpoint.
        resume: bool,
    },
    /// Stop the bake; its checkpoint stays.
    Cancel,
    /// Choose the parts of the next bake, and show its settings.
    Choose(BakeParts),
    /// Choose the views of the next bake, at the present viewport size; an empty list serves all views equally.
    ForViews(Vec<Camera>),
}

/// A request about the comparison with a reference.
#[derive(Clone, Debug)]
pub enum CompareAction {
    /// Begin or end the comparison with a reference.
    Toggle,
    /// Compare with a picture file.
    Reference(Option<PathBuf>),
    /// Compare with a look, by its number.
    Look(usize),
    /// Pause tracing of the reference, or continue.
    Pause(bool),
}

/// A request about the ladder of cut sizes.
#[derive(Clone, Debug)]
pub enum LadderAction {
    /// Try sizes of the illumination cut on the picture, against a reference.
    Start,
    /// Choose the cuts that pictures merge.
    UseCuts(Cuts),
}

/// A request to export.
#[derive(Clone, Debug)]
pub enum ExportAction {
    /// Write the picture.
    Picture(Option<PathBuf>),
    /// Write the picture with all its layers.
    Layers(Option<PathBuf>),
    /// Write the materials in a format of other programs.
    Materials(Option<PathBuf>),
    /// Describe an image sequence to export.
    DescribeSequence,
    /// Choose the folder of the sequence in the dialog.
    SequenceFolder(Option<PathBuf>),
    /// Choose the folder of the pictures of looks in the dialog.
    PicturesFolder(Option<PathBuf>),
    /// Stop the export; keep complete frames.
    Cancel,
}
