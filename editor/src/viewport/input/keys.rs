//! Keys held to move the camera or turn the environment. Single presses are commands of the window.

use super::turn;
use crate::{actions::Action, document::Document};
use egui::{Context, Event, InputState, Key};
use glam::Vec3;

/// Degrees of a turn by a bracket key, without and with Shift.
const TURN_DEGREES: f32 = 5.0;
const FINE_TURN_DEGREES: f32 = 1.0;

/// Keys of flight and their directions: to the right, up, ahead.
const FLIGHT: [(Key, Vec3); 6] = [
    (Key::D, Vec3::X),
    (Key::A, Vec3::NEG_X),
    (Key::E, Vec3::Y),
    (Key::Q, Vec3::NEG_Y),
    (Key::W, Vec3::Z),
    (Key::S, Vec3::NEG_Z),
];

/// Direction of flight of the held keys; opposite ones cancel.
pub(super) fn flight_direction(input: &InputState) -> Vec3 {
    FLIGHT.iter().filter(|(key, _)| input.key_down(*key)).map(|(_, direction)| *direction).sum()
}

/// Turns the environment by pressed brackets: `[` to the left in the picture, `]` to the right. Holding one is a single gesture.
pub fn turn_environment(ctx: &Context, document: &Document, actions: &mut Vec<Action>) {
    let (mut degrees, mut released) = (0.0, false);
    ctx.input_mut(|input| {
        input.events.retain(|event| {
            let Event::Key { key, pressed, modifiers, .. } = event else { return true };
            let Some(sign) = bracket(*key) else { return true };
            let step = if modifiers.shift { FINE_TURN_DEGREES } else { TURN_DEGREES };
            degrees += if *pressed { sign * step } else { 0.0 };
            released |= !pressed;
            false
        });
    });
    if degrees != 0.0 {
        actions.push(turn(&document.environment, degrees));
    }
    if released {
        actions.push(Action::EndGesture);
    }
}

/// Direction of a bracket key, or a brace with Shift.
fn bracket(key: Key) -> Option<f32> {
    match key {
        Key::OpenBracket | Key::OpenCurlyBracket => Some(1.0),
        Key::CloseBracket | Key::CloseCurlyBracket => Some(-1.0),
        _ => None,
    }
}
