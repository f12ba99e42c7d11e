//! State of the interface between frames.

use crate::{
    panels::{
        comparison::ComparisonPanel, environment::EnvironmentPanel, lights::LightsPanel, material::MaterialPanel,
        scene::ScenePanel,
    },
    viewport::ViewportState,
};
use egui::Rect;

/// The tab of the inspector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Inspector {
    /// The selected material.
    #[default]
    Material,
    /// The light from all around.
    Environment,
    /// Local lights, and which light is in the picture.
    Lights,
    /// How the picture is made and shown.
    View,
    /// Visibility.
    Bake,
}

impl Inspector {
    pub(in crate::app) const ALL: [Self; 5] = [Self::Material, Self::Environment, Self::Lights, Self::View, Self::Bake];

    pub(in crate::app) fn label(self) -> &'static str {
        match self {
            Self::Material => "Material",
            Self::Environment => "Environment",
            Self::Lights => "Lights",
            Self::View => "View",
            Self::Bake => "Bake",
        }
    }
}

/// The tab of the left side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Objects, materials and cameras.
    #[default]
    Scene,
    /// Environments to choose from.
    Library,
}

/// State of the interface between frames.
pub struct Interface {
    /// The tab of the inspector.
    pub inspector: Inspector,
    /// The tab of the left side.
    pub side: Side,
    /// Only the picture is shown.
    pub panels_hidden: bool,
    /// The keyboard map is shown.
    pub keys_open: bool,
    /// Width and height of the viewport in pixels.
    pub viewport_size: [u32; 2],
    /// Where the viewport was in the last frame.
    pub viewport_rect: Rect,
    /// Frames in which a text from the clipboard is a camera.
    pub pasting_camera: u8,
    /// Widths of the left side and of the inspector, once they were shown.
    pub panel_widths: Option<[f32; 2]>,
    /// The panel of local lights.
    pub lights: LightsPanel,
    /// The panel of materials.
    pub material: MaterialPanel,
    /// The strip under the viewport.
    pub comparison: ComparisonPanel,
    pub(in crate::app) viewport: ViewportState,
    pub(in crate::app) environment: EnvironmentPanel,
    pub(in crate::app) scene: ScenePanel,
}

impl Default for Interface {
    fn default() -> Self {
        Self {
            inspector: Inspector::default(),
            side: Side::default(),
            panels_hidden: false,
            keys_open: false,
            viewport_size: [1, 1],
            viewport_rect: Rect::NOTHING,
            pasting_camera: 0,
            panel_widths: None,
            lights: LightsPanel::default(),
            material: MaterialPanel::default(),
            comparison: ComparisonPanel::default(),
            viewport: ViewportState::default(),
            environment: EnvironmentPanel::default(),
            scene: ScenePanel::default(),
        }
    }
}
