//! A click beside an open menu, list or color picker closes it, and does nothing else.

use egui::{Area, Context, DragAndDrop, Id, Order, Popup, Rect, Sense};

/// Covers everything below an open popup. `menus`, the bar of an open menu, stays free, so that the pointer can open the next menu.
/// A drag out of a menu uncovers everything. Must be called after everything was shown.
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
