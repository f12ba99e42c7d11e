//! The camera of a document's first view, to which *Reset camera* returns.

use crate::{document::Document, navigation};
use lapidary_core::{bounds::Bounds, camera::Camera};

/// Aspect (width by height) for which cameras of scene files are assumed to be set up.
const SHAPE: f32 = 1.5;

/// The camera of a document's first view.
#[derive(Clone, Debug)]
pub struct FirstView {
    camera: Camera,
    fit: Fit,
}

/// How the camera is fitted to the viewport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fit {
    /// Unchanged: from a session or recovered work.
    Kept,
    /// From a scene file: a narrower viewport keeps the width of its view.
    Width,
    /// For a scene without cameras: frames all of it.
    All,
}

impl FirstView {
    /// The first view of a newly opened document, `kept` from a session or an autosave, or from a scene.
    pub fn of(document: &Document, kept: bool) -> Self {
        let fit = match (kept, document.bookmarks.is_empty()) {
            (true, _) => Fit::Kept,
            (false, false) => Fit::Width,
            (false, true) => Fit::All,
        };
        Self { camera: document.camera.clone(), fit }
    }

    /// The camera for a viewport of `aspect` (width by height) on a scene of these bounds.
    pub fn fitted(&self, bounds: Option<Bounds>, aspect: f32) -> Camera {
        match (self.fit, bounds) {
            (Fit::All, Some(bounds)) => navigation::framed(&self.camera, bounds, aspect),
            (Fit::Width, _) if (0.2..SHAPE).contains(&aspect) => {
                let tan = self.camera.tan_half_fov() * SHAPE / aspect;
                navigation::with_field_of_view(&self.camera, 2.0 * tan.atan(), false)
            }
            _ => self.camera.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn bounds() -> Bounds {
        Bounds { min: Vec3::ZERO, max: Vec3::splat(8.0) }
    }

    #[test]
    fn a_narrow_viewport_sees_as_much_in_width_of_a_scene_and_a_session_is_as_it_was() {
        let mut document = Document::empty();
        document.bookmarks.push(document.camera.clone());
        let half_width = |camera: &Camera, aspect: f32| camera.tan_half_fov() * aspect;
        let of_scene = FirstView::of(&document, false);
        let narrow = of_scene.fitted(Some(bounds()), 0.75);
        assert!((half_width(&narrow, 0.75) - half_width(&document.camera, SHAPE)).abs() < 1e-5);
        assert_eq!(narrow.eye, document.camera.eye);
        assert_eq!(of_scene.fitted(Some(bounds()), 2.0), document.camera);
        assert_eq!(FirstView::of(&document, true).fitted(Some(bounds()), 0.75), document.camera);
    }

    #[test]
    fn a_scene_without_cameras_is_framed() {
        let document = Document::empty();
        let view = FirstView::of(&document, false);
        assert_eq!(view.fitted(Some(bounds()), 1.5).target, Vec3::splat(4.0));
        assert_eq!(view.fitted(None, 1.5), document.camera);
    }
}
