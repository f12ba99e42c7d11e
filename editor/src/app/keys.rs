//! The keyboard: one table of commands with their keys, from which menus, the keyboard map and the handling are made.

use egui::{Context, Event, Grid, Id, Key, KeyboardShortcut, Modal, Modifiers, RichText, ScrollArea, Ui};
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
    /// Do it again.
    Redo,
    /// Show what is selected.
    FrameSelection,
    /// Show all.
    FrameAll,
    /// Go back to the first view.
    ResetCamera,
    /// Put the camera on the clipboard.
    CopyCamera,
    /// Take it from there.
    PasteCamera,
    /// The quantity that the pixels show.
    Mode(ViewMode),
    /// Edges over the picture.
    Wireframe,
    /// Only the picture.
    TogglePanels,
    /// Larger text and controls.
    LargerInterface,
    /// Smaller ones.
    SmallerInterface,
    /// As they come.
    DefaultInterface,
    /// Add a copy of the selected light.
    DuplicateLight,
    /// Remove the selected light.
    DeleteLight,
    /// Compare with a reference, or end that.
    Compare,
    /// Bake with the current settings.
    Bake,
    /// Show or hide the keyboard map.
    Keys,
}

/// Who acts on a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    /// The window, wherever the pointer is.
    Window,
    /// The viewport: listed here so that it is found.
    Viewport,
}

/// A command, what it is called and its keys.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Its command.
    pub command: Command,
    /// Its name in menus.
    pub label: &'static str,
    group: &'static str,
    keys: &'static [(Modifiers, Key)],
    by: By,
}

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);
const NONE: Modifiers = Modifiers::NONE;

const fn window(
    group: &'static str,
    command: Command,
    label: &'static str,
    keys: &'static [(Modifiers, Key)],
) -> Binding {
    Binding { command, label, group, keys, by: By::Window }
}

const fn viewport(command: Command, label: &'static str, keys: &'static [(Modifiers, Key)]) -> Binding {
    Binding { command, label, group: "View", keys, by: By::Viewport }
}

const fn mode(mode: ViewMode, label: &'static str, keys: &'static [(Modifiers, Key)]) -> Binding {
    window("What the pixels show", Command::Mode(mode), label, keys)
}

/// All commands. A key with more modifiers stands before the same key with fewer.
pub const BINDINGS: [Binding; 30] = [
    window("File", Command::Open, "Open...", &[(CTRL, Key::O)]),
    window("File", Command::SaveAs, "Save as...", &[(CTRL_SHIFT, Key::S)]),
    window("File", Command::Save, "Save", &[(CTRL, Key::S)]),
    window("File", Command::ExportPicture, "Export picture...", &[(CTRL, Key::E)]),
    window("File", Command::Quit, "Quit", &[(CTRL, Key::Q)]),
    window("Edit", Command::Redo, "Redo", &[(CTRL_SHIFT, Key::Z), (CTRL, Key::Y)]),
    window("Edit", Command::Undo, "Undo", &[(CTRL, Key::Z)]),
    window("Edit", Command::DuplicateLight, "Duplicate light", &[(CTRL, Key::D)]),
    window("Edit", Command::DeleteLight, "Delete light", &[(NONE, Key::Delete), (NONE, Key::Backspace)]),
    viewport(Command::FrameSelection, "Frame selection", &[(NONE, Key::F)]),
    viewport(Command::FrameAll, "Frame all", &[(NONE, Key::A)]),
    viewport(Command::ResetCamera, "Reset camera", &[(NONE, Key::Home)]),
    viewport(Command::CopyCamera, "Copy camera", &[(CTRL_SHIFT, Key::C)]),
    viewport(Command::PasteCamera, "Paste camera", &[(CTRL_SHIFT, Key::V)]),
    window("View", Command::Wireframe, "Wireframe", &[(NONE, Key::W)]),
    window("View", Command::TogglePanels, "Hide panels", &[(NONE, Key::Tab)]),
    window("Window", Command::LargerInterface, "Larger interface", &[(NONE, Key::Plus), (NONE, Key::Equals)]),
    window("Window", Command::SmallerInterface, "Smaller interface", &[(NONE, Key::Minus)]),
    window("Window", Command::DefaultInterface, "Default interface size", &[(CTRL, Key::Num0)]),
    window("Window", Command::Keys, "Keyboard map", &[(NONE, Key::F1), (NONE, Key::Questionmark)]),
    window("View", Command::Compare, "Compare with a reference", &[(NONE, Key::C)]),
    window("Bake", Command::Bake, "Bake", &[(NONE, Key::B)]),
    mode(ViewMode::Shaded, "Shaded", &[(NONE, Key::Num1)]),
    mode(ViewMode::Normals, "Normals", &[(NONE, Key::Num2)]),
    mode(ViewMode::Albedo, "Albedo", &[(NONE, Key::Num3)]),
    mode(ViewMode::Roughness, "Roughness", &[(NONE, Key::Num4)]),
    mode(ViewMode::VisibilityCut, "Visibility cut size", &[(NONE, Key::Num5)]),
    mode(ViewMode::MergedCut, "Merged cut size", &[(NONE, Key::Num6)]),
    mode(ViewMode::BrdfEvaluations, "BRDF evaluations", &[(NONE, Key::Num7)]),
    window("File", Command::Quit, "Quit", &[(Modifiers::ALT, Key::F4)]),
];

/// Width of the keyboard map in points.
const WIDTH: f32 = 960.0;

/// Pointer gestures, for the keyboard map.
const POINTER: [(&str, &str); 14] = [
    ("Drag", "Orbit (also: middle drag)"),
    ("Shift + drag", "Pan (also: Shift + middle drag)"),
    ("Wheel", "Move closer or away (also: Alt + right drag)"),
    ("Right drag", "Look around; W A S D Q E fly, Shift faster"),
    ("Shift + right drag", "Turn the environment"),
    ("[ ]", "Turn the environment by 5 degrees (Shift: 1)"),
    ("Click", "Select"),
    ("Double click", "Orbit about this point"),
    ("Drag a handle", "Move the selected light (Esc: put it back)"),
    ("Ctrl + 1, 3, 7", "View from the front, the right, the top"),
    ("Shift + slider", "Fine steps"),
    ("Hold R", "See the reference, while comparing"),
    ("Double click label", "Default value"),
    ("Drop a file", "Open it, or use it on what lies under it"),
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

/// Returns the commands whose keys were pressed, and removes them from the input. There are none while text is edited
/// or a question waits. There are none without a modifier while the right button is held, because those keys fly then.
pub fn pressed(ctx: &Context) -> Vec<Command> {
    if was_shut_out(ctx) {
        return Vec::new();
    }
    let flying = ctx.input(|i| i.pointer.secondary_down());
    // On a slow frame a click into a field and the text typed there arrive together.
    let clicked = ctx.input(|i| i.events.iter().any(|e| matches!(e, Event::PointerButton { .. })));
    let mut commands = Vec::new();
    for binding in BINDINGS.iter().filter(|b| b.by == By::Window) {
        for &(modifiers, key) in binding.keys {
            let blocked = ((flying || clicked) && modifiers.is_none()) || key == Key::Tab;
            if !blocked && take(ctx, modifiers, key) {
                commands.push(binding.command);
            }
        }
    }
    commands
}

/// Whether text is edited, or was in the last frame: in a slow frame, typed text and the Enter that leaves the field
/// arrive together.
fn was_shut_out(ctx: &Context) -> bool {
    let (id, now) = (Id::unique("keys were shut out"), is_shut_out(ctx));
    let before: Option<bool> = ctx.data_mut(|data| data.get_temp(id));
    ctx.data_mut(|data| data.insert_temp(id, now));
    now || before == Some(true)
}

/// Whether Tab hides everything but the picture. It steps through the controls unless the pointer is over the picture
/// and no control has the focus. Must be called before any control of the frame, which would take the focus.
pub fn tab_pressed(ctx: &Context, over_viewport: bool) -> bool {
    let is_free = over_viewport && !is_shut_out(ctx) && ctx.memory(|m| m.focused().is_none());
    let pressed = is_free && take(ctx, NONE, Key::Tab);
    if pressed {
        ctx.memory_mut(|m| m.move_focus(egui::FocusDirection::None));
    }
    pressed
}

fn is_shut_out(ctx: &Context) -> bool {
    ctx.text_edit_focused() || ctx.memory(|m| m.top_modal_layer().is_some())
}

/// Takes one press of a key. Letters and digits need exactly these modifiers; signs may need Shift on some keyboards.
/// The modifiers are those of the press: on a slow machine they are released again when the frame is drawn.
fn take(ctx: &Context, wanted: Modifiers, wanted_key: Key) -> bool {
    let sign = matches!(wanted_key, Key::Plus | Key::Minus | Key::Equals | Key::Questionmark);
    let is_it = |event: &Event| match event {
        Event::Key { key, pressed: true, modifiers, .. } => {
            let held = Modifiers { shift: modifiers.shift && !sign, ..*modifiers };
            *key == wanted_key && held.matches_exact(wanted)
        }
        _ => false,
    };
    ctx.input_mut(|i| {
        let place = i.events.iter().position(is_it);
        place.map(|place| i.events.remove(place)).is_some()
    })
}

/// Keys as they are written on them.
fn written(ctx: &Context, modifiers: Modifiers, key: Key) -> String {
    match key {
        Key::Plus => "+".into(),
        Key::Minus => "-".into(),
        Key::Equals => "=".into(),
        Key::Questionmark => "?".into(),
        _ => ctx.format_shortcut(&KeyboardShortcut::new(modifiers, key)),
    }
}

/// Shows the keyboard map. Returns whether it stays open.
pub fn show_map(ctx: &Context) -> bool {
    let room = ctx.content_rect().size() - egui::vec2(80.0, 160.0);
    let modal = Modal::new(egui::Id::unique("keyboard map")).show(ctx, |ui| {
        ui.set_width(room.x.min(WIDTH));
        // An area has room for some twenty lines at first.
        ui.set_max_height(room.y + 80.0);
        ui.heading("Keyboard and pointer");
        ui.add_space(6.0);
        ScrollArea::both().max_height(room.y).show(ui, |ui| {
            ui.horizontal_top(|ui| {
                for groups in [&["File", "Edit", "Bake", "Window"][..], &["View", "What the pixels show"]] {
                    ui.vertical(|ui| groups.iter().for_each(|group| show_group(ui, group)));
                    ui.add_space(20.0);
                }
                ui.vertical(|ui| table(ui, "Viewport", POINTER.map(|(keys, what)| (keys.to_owned(), what))));
            });
        });
        ui.add_space(6.0);
        ui.button("Close").clicked()
    });
    !(modal.inner || modal.should_close())
}

fn show_group(ui: &mut Ui, group: &'static str) {
    let write = |&(modifiers, key): &(Modifiers, Key)| written(ui.ctx(), modifiers, key);
    let bindings = BINDINGS.iter().filter(|b| b.group == group);
    let rows = bindings.map(|b| (b.keys.iter().map(write).collect::<Vec<_>>().join(", "), b.label));
    let rows: Vec<_> = rows.collect();
    table(ui, group, rows);
}

fn table(ui: &mut Ui, title: &str, rows: impl IntoIterator<Item = (String, &'static str)>) {
    ui.label(RichText::new(title).strong());
    Grid::new(title).num_columns(2).spacing([16.0, 3.0]).show(ui, |ui| {
        for (keys, what) in rows {
            ui.label(RichText::new(keys).monospace());
            ui.label(what);
            ui.end_row();
        }
    });
    ui.add_space(8.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui_kittest::{Harness, kittest::Queryable};

    struct State {
        pressed: Vec<Command>,
        text: String,
        tabs: u32,
        over_viewport: bool,
    }

    fn harness() -> Harness<'static, State> {
        let ui = |ui: &mut Ui, state: &mut State| {
            state.tabs += u32::from(tab_pressed(ui.ctx(), state.over_viewport));
            state.pressed.extend(pressed(ui.ctx()));
            ui.text_edit_singleline(&mut state.text).accessible_name("Text");
        };
        Harness::new_ui_state(ui, State { pressed: Vec::new(), text: String::new(), tabs: 0, over_viewport: false })
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
        let press =
            |pressed, modifiers| Event::Key { key: Key::O, physical_key: None, pressed, repeat: false, modifiers };
        harness.input_mut().events.extend([press(true, CTRL), press(false, NONE)]);
        harness.run_steps(2);
        assert_eq!(harness.state().pressed, [Command::Open]);
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
    fn every_mode_has_a_key_and_no_key_stands_twice() {
        for mode in ViewMode::ALL {
            assert_eq!(binding(Command::Mode(mode)).label, mode.label());
        }
        let keys: Vec<_> = BINDINGS.iter().flat_map(|b| b.keys).collect();
        for (i, key) in keys.iter().enumerate() {
            assert!(!keys[..i].contains(key), "{key:?}");
        }
    }

    #[test]
    fn the_map_lists_all_commands() {
        let mut harness = Harness::builder().with_size([1200.0, 800.0]).build_ui(|ui| {
            show_map(ui.ctx());
        });
        harness.run_steps(3);
        for binding in &BINDINGS {
            assert!(harness.query_all_by_label(binding.label).next().is_some(), "{}", binding.label);
        }
    }
}
