//! A click beside an open menu, list or color picker closes it, and does nothing else.

use egui::{Area, Context, DragAndDrop, Id, Order, Popup, Rect, Sense};

/// Covers all that lies under what has popped up, while something has. Only `menus`, the bar that an open menu belongs to,
/// stays free: there, the pointer goes on to the next menu; and all is free for what is dragged out of a menu. Must be called after everything was shown.
pub fn shield(ctx: &Context, menus: Option<Rect>) {
    if !Popup::is_any_open(ctx) || DragAndDrop::has_any_payload(ctx) {
        return;
    }
    let window = ctx.content_rect();
    let rect = menus.map_or(window, |bar| window.with_min_y(bar.bottom()));
    let area = Area::new(Id::unique("shield")).order(Order::Middle).fixed_pos(rect.min).constrain(false);
    let area = area.fade_in(false).sense(Sense::click_and_drag());
    let shown = area.show(ctx, |ui| drop(ui.allocate_exact_size(rect.size(), Sense::click_and_drag())));
    ctx.move_to_top(shown.response.layer_id);
}
