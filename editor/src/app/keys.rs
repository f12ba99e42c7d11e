//! The keyboard: one table of commands and keys serves menus, keyboard map and input.

use crate::{navigation::AxisView, viewport::gizmo::Tool};
use egui::{Context, Event, Key, KeyboardShortcut, Modifiers};
use lapidary_render::ViewMode;

/// Commands of menus and keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Open a file.
    Open,
    /// Write the session.
    Save,
    /// Write the session under another name.
    SaveAs,
    /// Write the picture.
    ExportPicture,
    /// Close the window.
    Quit,
    /// Take back the last edit.
    Undo,
    /// Repeat the edit last undone.
    Redo,
    /// Select no object and no light.
    SelectNothing,
    /// Hide the selected objects, or show them if the active one is hidden.
    HideSelection,
    /// Show the selected objects alone, or end that.
    Isolate,
    /// Show all hidden objects.
    ShowAll,
    /// Frame the selection.
    FrameSelection,
    /// Frame the whole scene.
    FrameAll,
    /// Go back to the first view.
    ResetCamera,
    /// View along an axis.
    Along(AxisView),
    /// Put the camera on the clipboard.
    CopyCamera,
    /// Take the camera from the clipboard.
    PasteCamera,
    /// The quantity that the pixels show.
    Mode(ViewMode),
    /// Show a look, by its number from 0.
    Look(usize),
    /// Add a look of what is shown.
    AddLook,
    /// Edges over the picture.
    Wireframe,
    /// The tool of the handles, or no handles.
    Tool(Option<Tool>),
    /// Play the animation, or stop.
    Play,
    /// Hide the panels, or show them.
    TogglePanels,
    /// Larger text and controls.
    LargerInterface,
    /// Smaller text and controls.
    SmallerInterface,
    /// Default size of text and controls.
    DefaultInterface,
    /// Add a copy of the selected light.
    DuplicateLight,
    /// Remove the selected light.
    DeleteLight,
    /// Begin or end the comparison with a reference.
    Compare,
    /// Bake with the current settings.
    Bake,
    /// Show or hide the keyboard map.
    Keys,
}

impl Command {
    /// Whether it repeats while its key is held.
    fn repeats(self) -> bool {
        matches!(self, Self::Undo | Self::Redo | Self::LargerInterface | Self::SmallerInterface)
    }

    /// Whether it opens a dialog or a question, which takes the keys after it.
    fn asks(self) -> bool {
        matches!(self, Self::Open | Self::Save | Self::SaveAs | Self::ExportPicture | Self::Quit | Self::Keys)
    }
}

/// A command, its name and its keys.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Its command.
    pub command: Command,
    /// Its name in menus.
    pub label: &'static str,
    /// Its heading in the keyboard map.
    pub group: &'static str,
    /// Any of these.
    pub keys: &'static [(Modifiers, Key)],
}

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);
const SHIFT: Modifiers = Modifiers::SHIFT;
const ALT: Modifiers = Modifiers::ALT;
const NONE: Modifiers = Modifiers::NONE;

const fn binds(
    group: &'static str,
    command: Command,
    label: &'static str,
    keys: &'static [(Modifiers, Key)],
) -> Binding {
    Binding { command, label, group, keys }
}

const fn tool(tool: Tool, keys: &'static [(Modifiers, Key)]) -> Binding {
    binds("Edit", Command::Tool(Some(tool)), tool.label(), keys)
}

const fn look(look: usize, label: &'static str, keys: &'static [(Modifiers, Key)]) -> Binding {
    binds("Looks", Command::Look(look), label, keys)
}

const fn mode(mode: ViewMode, label: &'static str, keys: &'static [(Modifiers, Key)]) -> Binding {
    binds("View modes", Command::Mode(mode), label, keys)
}

/// All commands.
pub const BINDINGS: [Binding; 56] = [
    binds("File", Command::Open, "Open...", &[(CTRL, Key::O)]),
    binds("File", Command::SaveAs, "Save as...", &[(CTRL_SHIFT, Key::S)]),
    binds("File", Command::Save, "Save", &[(CTRL, Key::S)]),
    binds("File", Command::ExportPicture, "Export picture...", &[(CTRL, Key::E)]),
    binds("File", Command::Quit, "Quit", &[(CTRL, Key::Q)]),
    binds("Edit", Command::Redo, "Redo", &[(CTRL_SHIFT, Key::Z), (CTRL, Key::Y)]),
    binds("Edit", Command::Undo, "Undo", &[(CTRL, Key::Z)]),
    binds("Edit", Command::DuplicateLight, "Duplicate light", &[(CTRL, Key::D)]),
    binds("Edit", Command::DeleteLight, "Delete light", &[(NONE, Key::Delete), (NONE, Key::Backspace)]),
    tool(Tool::Move, &[(NONE, Key::W)]),
    tool(Tool::Turn, &[(NONE, Key::E)]),
    tool(Tool::Scale, &[(NONE, Key::R)]),
    binds("Edit", Command::Tool(None), "Select only", &[(NONE, Key::Q)]),
    binds("Edit", Command::HideSelection, "Hide or show the selection", &[(NONE, Key::H)]),
    binds("Edit", Command::Isolate, "Isolate the selection, or end it", &[(NONE, Key::Slash)]),
    binds("Edit", Command::ShowAll, "Show all objects", &[(SHIFT, Key::H)]),
    binds("Edit", Command::SelectNothing, "Deselect all", &[(NONE, Key::Escape)]),
    binds("View", Command::FrameSelection, "Frame selection", &[(NONE, Key::F)]),
    binds("View", Command::FrameAll, "Frame all", &[(NONE, Key::A)]),
    binds("View", Command::ResetCamera, "Reset camera", &[(NONE, Key::Home)]),
    binds("View", Command::Along(AxisView::Front), "View from the front", &[(CTRL, Key::Num1)]),
    binds("View", Command::Along(AxisView::Right), "View from the right", &[(CTRL, Key::Num3)]),
    binds("View", Command::Along(AxisView::Top), "View from the top", &[(CTRL, Key::Num7)]),
    binds("View", Command::CopyCamera, "Copy camera", &[(CTRL_SHIFT, Key::C)]),
    binds("View", Command::PasteCamera, "Paste camera", &[(CTRL_SHIFT, Key::V)]),
    binds("View", Command::Wireframe, "Wireframe", &[(SHIFT, Key::W)]),
    binds("View", Command::Play, "Play animation", &[(NONE, Key::Space)]),
    binds("View", Command::TogglePanels, "Hide panels", &[(NONE, Key::Tab)]),
    binds("Window", Command::LargerInterface, "Larger interface", &[(NONE, Key::Plus), (NONE, Key::Equals)]),
    binds("Window", Command::SmallerInterface, "Smaller interface", &[(NONE, Key::Minus)]),
    binds("Window", Command::DefaultInterface, "Default interface size", &[(CTRL, Key::Num0)]),
    binds("Window", Command::Keys, "Keyboard map", &[(NONE, Key::F1), (NONE, Key::Questionmark)]),
    binds("View", Command::Compare, "Compare with a reference", &[(NONE, Key::C)]),
    binds("Bake", Command::Bake, "Bake", &[(NONE, Key::B)]),
    mode(ViewMode::Shaded, "Shaded", &[(NONE, Key::Num1)]),
    mode(ViewMode::Normals, "Normals", &[(NONE, Key::Num2)]),
    mode(ViewMode::Albedo, "Albedo", &[(NONE, Key::Num3)]),
    mode(ViewMode::Roughness, "Roughness", &[(NONE, Key::Num4)]),
    mode(ViewMode::VisibilityCut, "Visibility cut size", &[(NONE, Key::Num5)]),
    mode(ViewMode::MergedCut, "Merged cut size", &[(NONE, Key::Num6)]),
    mode(ViewMode::BrdfEvaluations, "BRDF evaluations", &[(NONE, Key::Num7)]),
    mode(ViewMode::BasisLevel, "Basis level", &[(NONE, Key::Num8)]),
    mode(ViewMode::BasisFunction, "Basis function", &[(NONE, Key::Num9)]),
    mode(ViewMode::BasisCoefficients, "Basis coefficients", &[(NONE, Key::Num0)]),
    mode(ViewMode::Gloss, "Light by gloss", &[(NONE, Key::G)]),
    binds("View", Command::AddLook, "Add look", &[(SHIFT, Key::L)]),
    look(0, "Look 1", &[(ALT, Key::Num1)]),
    look(1, "Look 2", &[(ALT, Key::Num2)]),
    look(2, "Look 3", &[(ALT, Key::Num3)]),
    look(3, "Look 4", &[(ALT, Key::Num4)]),
    look(4, "Look 5", &[(ALT, Key::Num5)]),
    look(5, "Look 6", &[(ALT, Key::Num6)]),
    look(6, "Look 7", &[(ALT, Key::Num7)]),
    look(7, "Look 8", &[(ALT, Key::Num8)]),
    look(8, "Look 9", &[(ALT, Key::Num9)]),
    binds("File", Command::Quit, "Quit", &[(ALT, Key::F4)]),
];

/// The binding of a command.
pub fn binding(command: Command) -> &'static Binding {
    let known = BINDINGS.iter().find(|b| b.command == command);
    known.expect("every command is in the table, which a test holds it to")
}

/// The first keys of a command, as the system writes them.
pub fn text(ctx: &Context, command: Command) -> String {
    binding(command).keys.first().map(|&(modifiers, key)| written(ctx, modifiers, key)).unwrap_or_default()
}

/// The commands of this frame's key presses, in order. Takes the presses out of the input. Call it only if
/// [`keys_are_commands`](crate::typing::keys_are_commands).
pub fn pressed(ctx: &Context) -> Vec<Command> {
    // Keys fly while the right button is down.
    if ctx.input(|i| i.pointer.secondary_down()) {
        return Vec::new();
    }
    let (mut commands, mut has_clicked, mut is_over) = (Vec::new(), false, false);
    ctx.input_mut(|i| {
        i.events.retain(|event| {
            // A click may open a text field in the next frame, which takes the plain keys after it.
            has_clicked |= matches!(event, Event::PointerButton { .. });
            let command = command_of(event).filter(|_| !(is_over || has_clicked && is_plain(event)));
            is_over |= command.is_some_and(Command::asks);
            commands.extend(command);
            command.is_none()
        });
    });
    commands
}

/// The command of a press; [`tab_pressed`] handles Tab.
fn command_of(event: &Event) -> Option<Command> {
    let &Event::Key { key, pressed: true, repeat, modifiers, .. } = event else { return None };
    let is_it = |&(wanted, wanted_key): &(Modifiers, Key)| key == wanted_key && are(modifiers, key, wanted);
    let binding = BINDINGS.iter().find(|b| b.keys.iter().any(is_it))?;
    (key != Key::Tab && (!repeat || binding.command.repeats())).then_some(binding.command)
}

/// Whether a press has the wanted modifiers. Letters and digits need exactly these; signs may need Shift on some keyboards. `held`
/// is from the press itself: on a slow machine the keys may be up when the frame is drawn.
fn are(held: Modifiers, key: Key, wanted: Modifiers) -> bool {
    let is_sign = matches!(key, Key::Plus | Key::Minus | Key::Equals | Key::Questionmark);
    Modifiers { shift: held.shift && !is_sign, ..held }.matches_exact(wanted)
}

fn is_plain(event: &Event) -> bool {
    matches!(event, Event::Key { modifiers, .. } if !modifiers.command && !modifiers.alt)
}

/// Whether Tab hides everything but the picture. It steps through the controls unless the pointer is over the picture
/// and no control has the focus. Must be called before any control of the frame, which would take the focus.
pub fn tab_pressed(ctx: &Context, over_viewport: bool) -> bool {
    let is_free = ctx.memory(|m| m.focused().is_none() && m.top_modal_layer().is_none());
    let is_tab = |event: &Event| matches!(event, Event::Key { key: Key::Tab, pressed: true, repeat: false, modifiers, .. } if modifiers.is_none());
    if !over_viewport || !is_free || !ctx.input(|i| i.events.iter().any(is_tab)) {
        return false;
    }
    let presses = ctx.input_mut(|i| i.events.extract_if(.., |event| is_tab(event)).count());
    ctx.memory_mut(|m| m.move_focus(egui::FocusDirection::None));
    presses % 2 == 1
}

/// Keys as keyboards label them.
pub fn written(ctx: &Context, modifiers: Modifiers, key: Key) -> String {
    match key {
        Key::Plus => "+".into(),
        Key::Minus => "-".into(),
        Key::Equals => "=".into(),
        Key::Questionmark => "?".into(),
        _ => ctx.format_shortcut(&KeyboardShortcut::new(modifiers, key)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::typing::keys_are_commands;
    use egui::Ui;
    use egui_kittest::{Harness, kittest::Queryable};

    #[derive(Default)]
    struct State {
        pressed: Vec<Command>,
        text: String,
        number: f32,
        tabs: u32,
        over_viewport: bool,
    }

    fn harness() -> Harness<'static, State> {
        let ui = |ui: &mut Ui, state: &mut State| {
            state.tabs += u32::from(tab_pressed(ui.ctx(), state.over_viewport));
            ui.text_edit_singleline(&mut state.text).accessible_name("Text");
            ui.add(egui::DragValue::new(&mut state.number)).accessible_name("Number");
            if keys_are_commands(ui.ctx()) {
                state.pressed.extend(pressed(ui.ctx()));
            }
        };
        Harness::new_ui_state(ui, State::default())
    }

    fn after(modifiers: Modifiers, key: Key) -> Vec<Command> {
        let mut harness = harness();
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(2);
        harness.state().pressed.clone()
    }

    #[test]
    fn each_key_does_one_thing() {
        assert_eq!(after(CTRL, Key::Z), [Command::Undo]);
        assert_eq!(after(CTRL_SHIFT, Key::Z), [Command::Redo]);
        assert_eq!(after(CTRL, Key::Y), [Command::Redo]);
        assert_eq!(after(NONE, Key::Num2), [Command::Mode(ViewMode::Normals)]);
        assert_eq!(after(Modifiers::SHIFT, Key::Questionmark), [Command::Keys]);
        assert_eq!(after(Modifiers::SHIFT, Key::Plus), [Command::LargerInterface]);
        assert_eq!(after(CTRL, Key::B), [], "Ctrl+B is not B");
        assert_eq!(after(NONE, Key::Tab), [], "Tab steps through the controls");
    }

    #[test]
    fn tab_hides_panels_over_the_picture_and_steps_through_controls_elsewhere() {
        let mut harness = harness();
        harness.state_mut().over_viewport = true;
        harness.key_press(Key::Tab);
        harness.run_steps(3);
        assert!(harness.state().tabs == 1 && !harness.get_by_label("Text").is_focused());
        harness.state_mut().over_viewport = false;
        harness.key_press(Key::Tab);
        harness.run_steps(3);
        assert!(harness.state().tabs == 1 && harness.get_by_label("Text").is_focused());
    }

    #[test]
    fn modifiers_that_are_up_again_count_as_they_were() {
        let mut harness = harness();
        let up = Event::Key { key: Key::O, physical_key: None, pressed: false, repeat: false, modifiers: NONE };
        harness.input_mut().events.extend([press(CTRL, Key::O), up]);
        harness.run_steps(2);
        assert_eq!(harness.state().pressed, [Command::Open]);
    }

    fn press(modifiers: Modifiers, key: Key) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
    }

    fn click(position: egui::Pos2) -> [Event; 3] {
        let button = |pressed| Event::PointerButton {
            pos: position,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: NONE,
        };
        [Event::PointerMoved(position), button(true), button(false)]
    }

    #[test]
    fn typing_does_nothing_else() {
        let mut harness = harness();
        harness.get_by_label("Text").focus();
        harness.run_steps(2);
        harness.key_press(Key::B);
        harness.key_press_modifiers(CTRL, Key::Z);
        harness.run_steps(2);
        assert_eq!(harness.state().pressed, []);
    }

    #[test]
    fn fast_typing_does_nothing_else_however_it_falls_into_frames() {
        let typed = || [Key::F, Key::A, Key::B, Key::Num3].map(|key| press(NONE, key));
        for field in ["Text", "Number"] {
            for leave in [Key::Enter, Key::Tab, Key::Escape] {
                let mut harness = harness();
                let at = harness.get_by_label(field).rect().center();
                // A click with the first keys, keys, and keys around the one that leaves the field: a frame each.
                harness.input_mut().events.extend(click(at).into_iter().chain(typed()));
                harness.step();
                harness.input_mut().events.extend(typed());
                harness.step();
                assert!(harness.get_by_label(field).is_focused());
                harness.input_mut().events.extend(typed().into_iter().chain([press(NONE, leave)]).chain(typed()));
                harness.step();
                assert_eq!(harness.state().pressed, [], "{field}, left by {leave:?}");
            }
        }
        let mut harness = harness();
        harness.input_mut().events.extend(typed());
        harness.step();
        assert_eq!(harness.state().pressed.len(), 4, "negative control: no field has the focus");
    }

    #[test]
    fn each_press_counts_and_a_held_key_repeats_only_what_may_be_repeated() {
        let mut harness = harness();
        let undo = press(CTRL, Key::Z);
        harness.input_mut().events.extend(vec![undo; 10]);
        harness.step();
        assert_eq!(harness.state().pressed, [Command::Undo; 10]);
        let mut held = |modifiers, key| {
            harness.state_mut().pressed.clear();
            let repeat = Event::Key { key, physical_key: None, pressed: true, repeat: true, modifiers };
            harness.input_mut().events.extend([press(modifiers, key), repeat]);
            harness.step();
            harness.state().pressed.len()
        };
        assert_eq!([held(CTRL, Key::Y), held(NONE, Key::Delete), held(NONE, Key::W)], [2, 1, 1]);
    }

    #[test]
    fn keys_after_one_that_opens_a_dialog_are_for_the_dialog() {
        let mut harness = harness();
        harness.input_mut().events.extend([press(NONE, Key::W), press(CTRL, Key::O), press(NONE, Key::B)]);
        harness.step();
        assert_eq!(harness.state().pressed, [Command::Tool(Some(Tool::Move)), Command::Open]);
    }

    #[test]
    fn the_keys_of_flight_are_no_commands() {
        let mut harness = harness();
        let secondary = |pressed| Event::PointerButton {
            pos: egui::pos2(300.0, 300.0),
            button: egui::PointerButton::Secondary,
            pressed,
            modifiers: NONE,
        };
        for (is_down, commands) in [(true, 0), (false, 1)] {
            harness.event(secondary(is_down));
            harness.step();
            harness.key_press(Key::W);
            harness.step();
            assert_eq!(harness.state().pressed.len(), commands);
        }
    }

    #[test]
    fn every_mode_has_a_key_and_no_key_stands_twice() {
        for mode in ViewMode::ALL {
            assert_eq!(binding(Command::Mode(mode)).label, mode.label());
        }
        let keys: Vec<_> = BINDINGS.iter().flat_map(|b| b.keys).collect();
        for (i, key) in keys.iter().enumerate() {
            assert!(!keys[..i].contains(key), "{key:?}");
        }
    }
}
