//! Decides whether keys are for text fields or for commands of the window.

use egui::{Context, Id, Key, Modifiers, Popup, text_edit::TextEditState};

/// Whether Escape closes a popup or cancels a drag, and is no command. Must be called before anything is shown, while the popup is
/// open.
pub fn escape_is_taken(ctx: &Context) -> bool {
    Popup::is_any_open(ctx) || ctx.input(|i| i.pointer.any_down() || i.pointer.any_released())
}

/// Takes Escape out of the input.
pub fn take_escape(ctx: &Context) -> bool {
    ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape))
}

/// Whether the keys pressed in this frame are commands: not if a text field had or got the focus in the frame.
///
/// On a slow frame a click into a field, the text typed there and the Enter that leaves it arrive together, so that
/// asking at one moment is not enough. Must be called once in each frame, after everything was shown.
pub fn keys_are_commands(ctx: &Context) -> bool {
    let id = Id::unique("focus at the end of the last frame");
    let now = ctx.memory(|memory| memory.focused());
    let before: Option<Id> = ctx.data_mut(|data| data.get_temp(id)).flatten();
    ctx.data_mut(|data| data.insert_temp(id, now));
    // A number becomes a text field one frame after it gets the focus.
    let has_moved = before != now;
    let is_edited = now.is_some_and(|field| TextEditState::load(ctx, field).is_some());
    !has_moved && !is_edited && ctx.memory(|memory| memory.top_modal_layer().is_none())
}
