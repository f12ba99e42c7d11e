//! Requests about the camera.

use lapidary_core::camera::Camera;

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
