//! The eyedropper: a click anywhere in the window takes the color there, as it is displayed.

use crate::typing::take_escape;
use egui::{Align2, Area, Color32, ColorImage, Context, CursorIcon, FontId, Id, Order, Pos2, Sense, pos2, vec2};
use glam::Vec3;
use lapidary_core::color::linear_from_codes;
use std::sync::{Arc, Mutex, PoisonError};

/// A color on its way from the screen.
type Shot = Arc<Mutex<Option<Vec3>>>;

/// The picker that waits for a color.
#[derive(Clone)]
struct Waiting {
    picker: Id,
    /// The last pass in which its row was shown.
    served: u64,
    /// The color, once the click has asked for it.
    shot: Option<Shot>,
}

fn id() -> Id {
    Id::unique("eyedropper")
}

/// Waits for a click on behalf of a picker.
pub fn begin(ctx: &Context, picker: Id) {
    wait(ctx, Waiting { picker, served: ctx.cumulative_pass_nr(), shot: None });
}

fn wait(ctx: &Context, waiting: Waiting) {
    ctx.data_mut(|data| data.insert_temp(id(), waiting));
}

/// The color that was clicked for this picker; call it in each frame in which the picker is shown.
pub fn picked(ctx: &Context, picker: Id) -> Option<Vec3> {
    let waiting = ctx.data(|data| data.get_temp::<Waiting>(id())).filter(|waiting| waiting.picker == picker)?;
    let now = ctx.cumulative_pass_nr();
    // Its row was gone for a while: nobody waits any more.
    if now > waiting.served + 2 && waiting.shot.is_none() {
        ctx.data_mut(|data| data.remove::<Waiting>(id()));
        return None;
    }
    match waiting.shot {
        Some(shot) => {
            let color = shot.lock().unwrap_or_else(PoisonError::into_inner).take()?;
            ctx.data_mut(|data| data.remove::<Waiting>(id()));
            Some(color)
        }
        None => {
            wait(ctx, Waiting { picker, served: now, shot: None });
            wait_for_click(ctx, picker);
            None
        }
    }
}

/// Takes the pointer for the whole window.
fn wait_for_click(ctx: &Context, picker: Id) {
    let all = ctx.content_rect();
    let area = Area::new(id()).order(Order::Foreground).fixed_pos(all.min);
    let response = area.show(ctx, |ui| ui.allocate_rect(all, Sense::click())).inner;
    let response = response.on_hover_cursor(CursorIcon::Crosshair);
    if take_escape(ctx) {
        ctx.data_mut(|data| data.remove::<Waiting>(id()));
        return;
    }
    let hint = ctx.layer_painter(egui::LayerId::new(Order::Tooltip, id()));
    let at = all.center_top() + vec2(0.0, 60.0);
    let text = "Click a color (Esc: cancel)";
    let galley = hint.layout_no_wrap(text.into(), FontId::proportional(13.0), Color32::WHITE);
    let back = Align2::CENTER_TOP.anchor_size(at, galley.size() + vec2(16.0, 8.0));
    hint.rect_filled(back, 4.0, Color32::from_black_alpha(190));
    hint.galley(back.min + vec2(8.0, 4.0), galley, Color32::WHITE);
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
        let shot = Shot::default();
        wait(ctx, Waiting { picker, served: ctx.cumulative_pass_nr(), shot: Some(shot.clone()) });
        let (scale, wake) = (ctx.pixels_per_point(), ctx.clone());
        ctx.request_screenshot(move |image| {
            *shot.lock().unwrap_or_else(PoisonError::into_inner) = color_at(&image, at, scale);
            wake.request_repaint();
        });
    }
}

/// The scene-linear color at a position in points of a picture of the window.
fn color_at(image: &ColorImage, at: Pos2, pixels_per_point: f32) -> Option<Vec3> {
    let Pos2 { x, y } = pos2(at.x * pixels_per_point, at.y * pixels_per_point);
    let [width, height] = image.size;
    // A float that is negative becomes 0.
    let (x, y) = ((x as usize).min(width.checked_sub(1)?), (y as usize).min(height.checked_sub(1)?));
    let [r, g, b, _] = image.pixels[y * width + x].to_array();
    Some(linear_from_codes([r, g, b]))
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Answers a click as the screen would.
    pub fn answer(ctx: &Context, image: &ColorImage, at: Pos2) {
        let waiting = ctx.data(|data| data.get_temp::<Waiting>(id())).expect("a picker waits");
        let shot = waiting.shot.expect("it was clicked");
        *shot.lock().unwrap() = color_at(image, at, 1.0);
    }

    #[test]
    fn a_color_is_that_of_its_pixel_at_any_scale() {
        let mut image = ColorImage::filled([4, 2], Color32::BLACK);
        image.pixels[4 + 3] = Color32::from_rgb(255, 0, 0);
        assert_eq!(color_at(&image, pos2(1.6, 0.7), 2.0), Some(Vec3::X));
        assert_eq!(color_at(&image, pos2(1.6, 0.2), 2.0), Some(Vec3::ZERO), "negative control");
        assert_eq!(color_at(&image, pos2(90.0, 90.0), 2.0), Some(Vec3::X), "beyond the edge it is the last");
    }
}
