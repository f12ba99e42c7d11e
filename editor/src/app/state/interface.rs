//! State of the interface between frames.

use crate::{app::side_panels::SidePanels, preferences::Preferences, scene::ScenePanel, viewport::ViewportState};
use egui::{Context, Rect, Vec2};
use std::time::Duration;

/// Seconds after which a window that was resized counts as having its size.
const WINDOW_REST_SECS: f64 = 0.15;

/// State of the interface between frames.
pub struct Interface {
    /// The keyboard map is shown.
    pub keys_open: bool,
    /// The viewport's rectangle in the last frame.
    pub viewport_rect: Rect,
    /// The next click into the viewport focuses the camera.
    pub focusing: bool,
    /// Frames left in which a clipboard text is taken as a camera.
    pub pasting_camera: u8,
    /// The panels at both sides.
    pub sides: SidePanels,
    /// Size of the window in points, and when it changed last, in seconds.
    window: (Vec2, f64),
    /// Preferences of the present theme.
    pub themed: Option<Preferences>,
    /// Size of the window in points, but not while it fills the screen.
    pub window_size: Option<[f32; 2]>,
    /// State of the viewport.
    pub viewport: ViewportState,
    /// The panel of the scene.
    pub scene: ScenePanel,
}

impl Interface {
    /// Initial state, with panels of these widths in points.
    pub fn new(widths: [f32; 2]) -> Self {
        Self {
            keys_open: false,
            viewport_rect: Rect::NOTHING,
            focusing: false,
            pasting_camera: 0,
            sides: SidePanels::new(widths),
            window: (Vec2::ZERO, f64::NEG_INFINITY),
            themed: None,
            window_size: None,
            viewport: ViewportState::default(),
            scene: ScenePanel::default(),
        }
    }

    /// The picture size in pixels for a viewport of `size`. While the edge of a panel or the window moves, it is `size_before`: the
    /// picture is kept, and rendered again once at the end.
    pub fn settled_size(&mut self, ctx: &Context, size_before: [u32; 2], size: [u32; 2]) -> [u32; 2] {
        let (window, now) = (ctx.content_rect().size(), ctx.input(|i| i.time));
        let (before, changed_at) = self.window;
        if before != window {
            let is_first = before == Vec2::ZERO;
            self.window = (window, if is_first { changed_at } else { now });
        }
        let left = self.window.1 + WINDOW_REST_SECS - now;
        if left > 0.0 {
            ctx.request_repaint_after(Duration::from_secs_f64(left));
        }
        if left > 0.0 || self.sides.is_dragged { size_before } else { size }
    }
}
