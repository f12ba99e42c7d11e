//! Requests of the interface. Panels only read the document; every change that they ask for is an [`Action`].

use crate::{
    document::{Edit, lights::LightKind},
    preferences::Preferences,
};
use glam::Vec3;
use lapidary_core::{animation::ClipTime, camera::Camera, dataset::BakeParts, material::Material, parts::Part};
use lapidary_studies::ladder::Cuts;
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
            Self::File(FileAction::Open(path) | FileAction::SaveAs(path) | FileAction::Relink(path))
            | Self::Material(
                MaterialAction::LoadTexture { path, .. }
                | MaterialAction::LoadBrdf { path, .. }
                | MaterialAction::Load { path, .. }
                | MaterialAction::Save { path, .. },
            )
            | Self::Light(LightAction::Load(path) | LightAction::Save(path))
            | Self::Environment(EnvironmentAction::Load(path) | EnvironmentAction::AddToLibrary(path))
            | Self::Compare(CompareAction::Reference(path))
            | Self::Export(
                ExportAction::Picture(path)
                | ExportAction::Layers(path)
                | ExportAction::Materials(path)
                | ExportAction::SequenceFolder(path),
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
    /// Frame the whole scene.
    FrameAll,
    /// Go back to where the document was first seen from.
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

/// A request about animations.
#[derive(Clone, Debug)]
pub enum PoseAction {
    /// Show a time of an animation, or the scene at rest.
    ClipTime(Option<ClipTime>),
    /// Play the animation, or stop.
    Play,
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
    /// Replace a material by that of a file.
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
        /// The material; a copy of what the part has if there is none.
        material: Option<Box<Material>>,
    },
    /// Show a variant of the materials, or what the file shows first.
    ChooseVariant(Option<usize>),
}

/// A request about local lights.
#[derive(Clone, Debug)]
pub enum LightAction {
    /// Select a local light, or nothing.
    Select(Option<usize>),
    /// Add a local light that lights what the camera looks at.
    Add(LightKind),
    /// Add a copy of a local light beside it.
    Duplicate(usize),
    /// Remove a local light.
    Delete(usize),
    /// Aim the selected light at a point, which ends aiming by a click; without a point the light stays as it is.
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
    /// Choose what the next bake is of, and show its settings.
    Choose(BakeParts),
    /// Choose the views that the next bake is for, at the size of the viewport now; an empty list serves all views
    /// alike.
    ForViews(Vec<Camera>),
}

/// A request about the comparison with a reference.
#[derive(Clone, Debug)]
pub enum CompareAction {
    /// Begin or end the comparison with a reference.
    Toggle,
    /// Compare with a picture file.
    Reference(Option<PathBuf>),
    /// Hold the tracing of the reference, or go on.
    Pause(bool),
}

/// A request about the ladder of cut sizes.
#[derive(Clone, Debug)]
pub enum LadderAction {
    /// Try sizes of the illumination cut on the picture, against a reference.
    Start,
    /// What pictures merge from now on.
    UseCuts(Cuts),
}

/// A request about what is written of the picture and the scene.
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
    /// Choose the folder of the sequence that is described.
    SequenceFolder(Option<PathBuf>),
    /// Stop the export; what is complete stays.
    Cancel,
}
