//! The pointer in the comparison: drags of the line between both pictures and of the measured region.

use super::panel::{ComparisonPanel, Tool};
use crate::{
    typing::take_escape,
    viewport::compare::{CompareView, line_at, part_of},
};
use egui::{CursorIcon, Pos2, Rect, Sense, Ui, Vec2};

/// Points around the line where a drag takes hold of it.
const GRIP: f32 = 7.0;
/// Least side of a region in points: a click is none.
const LEAST_REGION: f32 = 6.0;

/// Takes the pointer for the comparison, over the viewport in `rect`. Returns a pixel to explain, in shares of the viewport.
pub fn interact(ui: &mut Ui, rect: Rect, panel: &mut ComparisonPanel) -> Option<[f32; 2]> {
    match (panel.tool, panel.shown_view()) {
        (Some(_), CompareView::SideBySide) => panel.view = CompareView::Swipe,
        (Some(Tool::Region(drawn)), _) => draw_region(ui, rect, panel, drawn),
        (Some(Tool::Why), _) => return asked_pixel(ui, rect, panel),
        (None, CompareView::Swipe) => drag_line(ui, rect, panel),
        // Side by side, a click would select the wrong place.
        (None, CompareView::SideBySide) => drop(ui.interact(rect, ui.scope_id().with("both"), Sense::click())),
        (None, _) => {}
    }
    None
}

/// The pixel that a click asks to explain.
fn asked_pixel(ui: &mut Ui, rect: Rect, panel: &mut ComparisonPanel) -> Option<[f32; 2]> {
    let response = ui.interact(rect, ui.scope_id().with("why"), Sense::click()).on_hover_cursor(CursorIcon::Help);
    if take_escape(ui.ctx()) {
        panel.tool = None;
    }
    let at = response.interact_pointer_pos().filter(|_| response.clicked())?;
    Some(((at - rect.min) / rect.size()).clamp(Vec2::ZERO, Vec2::splat(1.0)).into())
}

fn drag_line(ui: &mut Ui, rect: Rect, panel: &mut ComparisonPanel) {
    let x = line_at(rect, panel.swipe);
    let grip = Rect::from_x_y_ranges(x - GRIP..=x + GRIP, rect.y_range());
    let response = ui.interact(grip, ui.scope_id().with("swipe"), Sense::drag());
    let response = response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if let Some(pointer) = response.interact_pointer_pos() {
        panel.swipe = ((pointer.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
    }
}

fn draw_region(ui: &mut Ui, rect: Rect, panel: &mut ComparisonPanel, drawn: Option<([f32; 2], [f32; 4])>) {
    let response = ui.interact(rect, ui.scope_id().with("region"), Sense::drag());
    let response = response.on_hover_and_drag_cursor(CursorIcon::Crosshair);
    let share = |at: Pos2| -> [f32; 2] { ((at - rect.min) / rect.size()).clamp(Vec2::ZERO, Vec2::splat(1.0)).into() };
    let pointer = response.interact_pointer_pos().map(share);
    if take_escape(ui.ctx()) {
        panel.tool = None;
    } else if response.drag_started() {
        let origin = ui.input(|i| i.pointer.press_origin()).map(share).or(pointer);
        panel.tool = Some(Tool::Region(origin.map(|start| (start, spanned(start, start)))));
    } else if let (Some((start, _)), Some(end)) = (drawn, pointer) {
        let part = spanned(start, end);
        panel.tool = Some(Tool::Region(Some((start, part))));
        if response.drag_stopped() {
            // The region changes once, since each change traces again.
            panel.tool = None;
            panel.region =
                Some(part).filter(|part| part_of(rect, *part).size().min_elem() >= LEAST_REGION).or(panel.region);
        }
    }
}

/// The rectangle between two corners.
fn spanned(a: [f32; 2], b: [f32; 2]) -> [f32; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[0].max(b[0]), a[1].max(b[1])]
}
