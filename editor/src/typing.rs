//! Whom the keyboard belongs to: text fields, or the commands of the window.

use egui::{Context, Id, text_edit::TextEditState};

/// Whether the keys pressed in this frame are commands: not if a text field had or got the focus in it.
///
/// On a slow frame a click into a field, the text typed there and the Enter that leaves it arrive together, so that
/// asking at one moment is not enough. Must be called once in each frame, after everything was shown.
pub fn keys_are_commands(ctx: &Context) -> bool {
    let id = Id::unique("focus at the end of the last frame");
    let now = ctx.memory(|memory| memory.focused());
    let before: Option<Id> = ctx.data_mut(|data| data.get_temp(id)).flatten();
    ctx.data_mut(|data| data.insert_temp(id, now));
    // A number becomes a text field one frame after it got the focus.
    let has_moved = before != now;
    let is_edited = now.is_some_and(|field| TextEditState::load(ctx, field).is_some());
    !has_moved && !is_edited && ctx.memory(|memory| memory.top_modal_layer().is_none())
}
