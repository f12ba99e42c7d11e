//! The keys of the viewport. They work wherever the pointer is, but not while text is edited or a dialog is open.

use super::{Pass, pressed};
use crate::{
    actions::Action,
    viewport::navigation::{self, AxisView},
};
use egui::{Event, InputState, Key, Modifiers};
use glam::Vec3;

/// Degrees that a bracket key turns the environment by, and with Shift.
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

/// Where the keys that are held fly to; opposite ones cancel.
pub(super) fn flight_direction(input: &InputState) -> Vec3 {
    FLIGHT.iter().filter(|(key, _)| input.key_down(*key)).map(|(_, direction)| *direction).sum()
}

pub(super) fn handle(pass: &mut Pass) {
    let ui = pass.ui;
    let shut_out = !ui.is_enabled() || !ui.memory(|memory| memory.allows_interaction(ui.layer_id()));
    if shut_out || ui.text_edit_focused() {
        return;
    }
    if pass.state.is_flying() {
        // Used up, so that they mean nothing else meanwhile.
        ui.input_mut(|input| input.events.retain(|event| !is_flight_key(event)));
    }
    for (modifiers, keys, action) in [
        (Modifiers::NONE, &[Key::F][..], Action::FrameSelection),
        (Modifiers::NONE, &[Key::A], Action::FrameAll),
        (Modifiers::NONE, &[Key::Home], Action::ResetCamera),
        (Modifiers::COMMAND | Modifiers::SHIFT, &[Key::C], Action::CopyCamera),
        (Modifiers::COMMAND | Modifiers::SHIFT, &[Key::V], Action::PasteCamera),
    ] {
        if ui.input_mut(|input| pressed(input, modifiers, keys)) {
            pass.actions.push(action);
        }
    }
    axis_views(pass);
    brackets(pass);
}

/// With Ctrl, since the toolkit cannot tell the keypad's digits from those that choose a view mode.
fn axis_views(pass: &mut Pass) {
    for (key, view) in [(Key::Num1, AxisView::Front), (Key::Num3, AxisView::Right), (Key::Num7, AxisView::Top)] {
        if pass.ui.input_mut(|input| pressed(input, Modifiers::COMMAND, &[key])) {
            pass.camera = navigation::axis_view(&pass.camera, view);
        }
    }
}

/// `[` turns what is seen to the left, `]` to the right. Holding one is a single gesture.
fn brackets(pass: &mut Pass) {
    let (mut degrees, mut released) = (0.0, false);
    pass.ui.input_mut(|input| {
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
        pass.turn_environment(degrees);
    }
    if released {
        pass.actions.push(Action::EndGesture);
    }
}

/// Direction of a bracket key; Shift makes a brace of it.
fn bracket(key: Key) -> Option<f32> {
    match key {
        Key::OpenBracket | Key::OpenCurlyBracket => Some(1.0),
        Key::CloseBracket | Key::CloseCurlyBracket => Some(-1.0),
        _ => None,
    }
}

fn is_flight_key(event: &Event) -> bool {
    matches!(event, Event::Key { key, pressed: true, .. } if FLIGHT.iter().any(|(flight, _)| flight == key))
}
