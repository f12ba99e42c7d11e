//! Requests of the interface. Panels only read the document; every change that they ask for is an [`Action`].

use crate::document::{Edit, lights::LightKind};
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
    /// Play the animation, or stop.
    Play,
    /// Take back the last edit.
    Undo,
    /// Do the last undone edit again.
    Redo,
    /// Open a scene, a dataset or a session.
    Open(Option<PathBuf>),
    /// Open a bundled scene, by its place in the menu.
    OpenBundled(usize),
    /// Write the session.
    Save,
    /// Write the session under another name.
    SaveAs(Option<PathBuf>),
    /// Write the picture.
    ExportPicture(Option<PathBuf>),
    /// Write the picture with all its layers.
    ExportLayers(Option<PathBuf>),
    /// Write the materials in a format of other programs.
    ExportMaterials(Option<PathBuf>),
    /// Describe an image sequence to export.
    DescribeSequence,
    /// Choose the folder of the sequence that is described.
    SequenceFolder(Option<PathBuf>),
    /// Stop the export; what is complete stays.
    CancelExport,
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
    LoadMaterial {
        /// Which material.
        material: usize,
        /// The material file.
        path: Option<PathBuf>,
    },
    /// Write a material to a file.
    SaveMaterial {
        /// Which material.
        material: usize,
        /// The material file.
        path: Option<PathBuf>,
    },
    /// Light the scene by a map.
    LoadEnvironment(Option<PathBuf>),
    /// Add maps to the library of environments.
    AddToLibrary(Option<PathBuf>),
    /// Bake the scene with the document's settings; with `resume` from its checkpoint.
    Bake {
        /// Go on from the checkpoint.
        resume: bool,
    },
    /// Stop the bake; its checkpoint stays.
    CancelBake,
    /// Show a time of an animation, or the scene at rest.
    ClipTime(Option<ClipTime>),
    /// Move the camera.
    Camera(Camera),
    /// Move back so that the selection, or the scene, is in view.
    FrameSelection,
    /// Frame the whole scene.
    FrameAll,
    /// Go back to where the document was first seen from.
    ResetCamera,
    /// Select an object alone, or nothing.
    SelectObject(Option<u32>),
    /// Add an object to the selection, or take it away.
    ToggleObject(u32),
    /// Select a material, or nothing.
    SelectMaterial(Option<usize>),
    /// Select a part of an object.
    SelectPart(Part),
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
    /// Select a local light, or nothing.
    SelectLight(Option<usize>),
    /// Add a local light that lights what the camera looks at.
    AddLight(LightKind),
    /// Add a copy of a local light beside it.
    DuplicateLight(usize),
    /// Remove a local light.
    DeleteLight(usize),
    /// Aim the selected light at a point, which ends aiming by a click; without a point the light stays as it is.
    AimLight(Option<Vec3>),
    /// Add the lights of a lights file.
    LoadLights(Option<PathBuf>),
    /// Write the lights to a lights file.
    SaveLights(Option<PathBuf>),
    /// Choose what the next bake is of, and show its settings.
    ChooseBake(BakeParts),
    /// Choose the views that the next bake is for, at the size of the viewport now; an empty list serves all views
    /// alike.
    BakeForViews(Vec<Camera>),
    /// Put the camera on the clipboard as text.
    CopyCamera,
    /// Take the camera from the clipboard.
    PasteCamera,
    /// Change how the window looks, or where its file dialogs begin.
    Preferences(crate::preferences::Preferences),
    /// Show or hide the keyboard map.
    ToggleKeys,
    /// Look for files that moved, in this folder.
    Relink(Option<PathBuf>),
    /// Compare with a picture file.
    ChooseReference(Option<PathBuf>),
    /// Hold the tracing of the reference, or go on.
    PauseReference(bool),
    /// Explain a pixel of the live picture, by its column and row.
    ExplainPixel([u32; 2]),
    /// Try sizes of the illumination cut on the picture, against a reference.
    StartLadder,
    /// What pictures merge from now on.
    UseCuts(Cuts),
    /// Begin or end the comparison with a reference.
    ToggleComparison,
    /// Close the window, after asking about unsaved changes.
    Quit,
}
