//! The menu bar.

use super::{
    keys::{self, Command},
    state::{EditorState, prompt::Prompt},
};
use crate::{
    actions::{Action, BakeAction, ExportAction, FileAction, LadderAction, LookAction},
    lights,
    preferences::{Preferences, Theme},
    viewport::gizmo::Tool,
    workspace::Inspector,
};
use egui::{Button, MenuBar, Ui};
use lapidary_render::ViewMode;
use std::path::Path;

/// Widths of menus in points, so that shortcuts have room.
const WIDTH: f32 = 210.0;

/// Shows the bar. Returns whether one of its menus is open.
pub fn show(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) -> bool {
    let bar = MenuBar::new().ui(ui, |ui| {
        [
            menu(ui, "File", |ui| file(ui, state, actions)),
            menu(ui, "Edit", |ui| edit(ui, state, actions)),
            menu(ui, "View", |ui| view(ui, state, actions)),
            menu(ui, "Bake", |ui| bake(ui, state, actions)),
            menu(ui, "Help", |ui| help(ui, state, actions)),
        ]
    });
    bar.inner.contains(&true)
}

fn menu(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) -> bool {
    let menu = ui.menu_button(title, |ui| {
        ui.set_min_width(WIDTH);
        contents(ui);
    });
    menu.inner.is_some()
}

/// An entry for a command, with its keys.
fn entry(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>, command: Command, enabled: bool) {
    let label = keys::binding(command).label;
    entry_as(ui, state, actions, command, label, enabled);
}

fn entry_as(
    ui: &mut Ui,
    state: &mut EditorState,
    actions: &mut Vec<Action>,
    command: Command,
    label: &str,
    enabled: bool,
) {
    let button = Button::new(label).shortcut_text(keys::text(ui.ctx(), command));
    if ui.add_enabled(enabled, button).clicked() {
        state.command(command, actions);
        ui.close();
    }
}

fn file(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    let is_open = state.work.document.scene.is_some() || state.work.document.dataset.is_some();
    entry(ui, state, actions, Command::Open, true);
    ui.menu_button("Open recent", |ui| recent(ui, state, actions));
    ui.menu_button("Bundled scenes", |ui| bundled(ui, state, actions));
    ui.separator();
    entry(ui, state, actions, Command::Save, is_open);
    entry(ui, state, actions, Command::SaveAs, is_open);
    entry(ui, state, actions, Command::ExportPicture, state.work.scene.rendered().is_some());
    export(ui, state, actions);
    ui.separator();
    entry(ui, state, actions, Command::Quit, true);
}

/// Exports: jobs with a renderer of their own, one at a time, and the materials.
fn export(ui: &mut Ui, state: &EditorState, actions: &mut Vec<Action>) {
    let (shown, running) = (state.work.scene.rendered().is_some(), state.exporting.is_running());
    let entries = [
        ("Export pictures...", Action::Look(LookAction::Describe), shown && !running),
        ("Export layered EXR...", Action::Export(ExportAction::Layers(None)), shown && !running),
        ("Export sequence...", Action::Export(ExportAction::DescribeSequence), shown && !running),
        ("Export materials...", Action::Export(ExportAction::Materials(None)), shown),
        ("Cancel export", Action::Export(ExportAction::Cancel), running),
    ];
    for (label, action, enabled) in entries {
        if ui.add_enabled(enabled, Button::new(label)).clicked() {
            actions.push(action);
            ui.close();
        }
    }
}

fn recent(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    if state.recent.entries().is_empty() {
        ui.weak("No recent files");
        return;
    }
    let mut chosen = None;
    for file in state.recent.entries() {
        let name = file.path.file_name().unwrap_or(file.path.as_os_str()).to_string_lossy().into_owned();
        let label = if file.missing { format!("{name} (missing)") } else { name };
        if ui.button(label).on_hover_text(file.path.display().to_string()).clicked() {
            chosen = Some(file.clone());
            ui.close();
        }
    }
    match chosen {
        Some(file) if file.missing && !file.path.exists() => state.forget_recent(&file.path),
        Some(file) => actions.push(Action::File(FileAction::Open(Some(file.path)))),
        None => {}
    }
    ui.separator();
    if ui.button("Clear list").clicked() {
        if let Err(error) = state.recent.clear() {
            state.work.messages.warning(format!("{error:#}"));
        }
        ui.close();
    }
}

fn bundled(ui: &mut Ui, state: &EditorState, actions: &mut Vec<Action>) {
    if state.bundled.scenes.is_empty() {
        ui.weak("Not found; start with --data");
    }
    for (index, scene) in state.bundled.scenes.iter().enumerate() {
        if ui.button(title(scene)).clicked() {
            actions.push(Action::File(FileAction::OpenBundled(index)));
            ui.close();
        }
    }
}

/// A scene's name in words: `still-life.gltf` is "Still life".
fn title(scene: &Path) -> String {
    let words = scene.file_stem().unwrap_or_default().to_string_lossy().replace('-', " ");
    let mut letters = words.chars();
    letters.next().map(|first| first.to_uppercase().collect::<String>() + letters.as_str()).unwrap_or_default()
}

fn edit(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    let label = |verb: &str, what: &Option<String>| what.as_ref().map_or(verb.into(), |what| format!("{verb} {what}"));
    let (undo, redo) =
        (state.work.history.undo_name(&state.work.document), state.work.history.redo_name(&state.work.document));
    entry_as(ui, state, actions, Command::Undo, &label("Undo", &undo), undo.is_some());
    entry_as(ui, state, actions, Command::Redo, &label("Redo", &redo), redo.is_some());
    ui.separator();
    let has_light = state.work.selected_light().is_some();
    entry(ui, state, actions, Command::DuplicateLight, has_light);
    entry(ui, state, actions, Command::DeleteLight, has_light);
    ui.menu_button("Add light", |ui| lights::add_menu(ui, actions));
    ui.separator();
    tools(ui, state, actions);
    let has_objects = !state.selected_objects().is_empty();
    entry(ui, state, actions, Command::HideSelection, has_objects);
    entry(ui, state, actions, Command::Isolate, has_objects || !state.pose.isolated(&state.work.document).is_empty());
    let has_hidden = state.work.document.poses.has_hidden();
    entry(ui, state, actions, Command::ShowAll, has_hidden);
    entry(ui, state, actions, Command::SelectNothing, has_light || state.work.selection.object.is_some());
    ui.separator();
    entry(ui, state, actions, Command::CopyCamera, true);
    entry(ui, state, actions, Command::PasteCamera, true);
}

/// The tools of the handles.
fn tools(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    for tool in Tool::ALL.map(Some).into_iter().chain([None]) {
        let command = Command::Tool(tool);
        let button = Button::selectable(state.pose.tool == tool, keys::binding(command).label);
        if ui.add(button.shortcut_text(keys::text(ui.ctx(), command))).clicked() {
            state.command(command, actions);
            ui.close();
        }
    }
}

fn view(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    for mode in ViewMode::ALL {
        let chosen = state.work.document.view.mode == mode;
        let button = Button::selectable(chosen, mode.label());
        if ui.add(button.shortcut_text(keys::text(ui.ctx(), Command::Mode(mode)))).clicked() {
            state.command(Command::Mode(mode), actions);
            ui.close();
        }
    }
    ui.separator();
    let wireframe = if state.work.document.view.wireframe { "Hide wireframe" } else { "Wireframe" };
    entry_as(ui, state, actions, Command::Wireframe, wireframe, true);
    let is_shown = state.work.scene.rendered().is_some();
    entry(
        ui,
        state,
        actions,
        Command::FrameSelection,
        is_shown && (state.work.selection.object.is_some() || state.work.selected_light().is_some()),
    );
    entry(ui, state, actions, Command::FrameAll, is_shown);
    entry(ui, state, actions, Command::ResetCamera, is_shown);
    ui.separator();
    let compare = if state.comparison.panel.open { "End comparison" } else { "Compare with a reference" };
    let can_compare = state.comparison.panel.open || state.picture.can_be_compared(&state.work);
    entry_as(ui, state, actions, Command::Compare, compare, can_compare);
    if ui.add_enabled(state.picture.can_be_compared(&state.work), Button::new("Which cut size is enough?")).clicked() {
        actions.push(Action::Ladder(LadderAction::Start));
        ui.close();
    }
    ui.separator();
    let panels = if state.work.tabs.panels_hidden { "Show panels" } else { "Hide panels" };
    entry_as(ui, state, actions, Command::TogglePanels, panels, true);
    entry(ui, state, actions, Command::LargerInterface, true);
    entry(ui, state, actions, Command::SmallerInterface, true);
    entry(ui, state, actions, Command::DefaultInterface, true);
    let (label, theme) = match state.work.preferences.theme {
        Theme::Dark => ("Light theme", Theme::Light),
        Theme::Light => ("Dark theme", Theme::Dark),
    };
    if ui.button(label).clicked() {
        actions.push(Action::prefer(Preferences { theme, ..state.work.preferences.clone() }));
        ui.close();
    }
}

fn bake(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    let running = state.baking.progress().is_some();
    entry(ui, state, actions, Command::Bake, state.work.scene.source.is_some());
    if ui.add_enabled(running, Button::new("Cancel bake")).clicked() {
        actions.push(Action::Bake(BakeAction::Cancel));
        ui.close();
    }
    if ui.button("Bake settings").clicked() {
        state.work.tabs.show_inspector(Inspector::Bake);
        ui.close();
    }
    ui.separator();
    let mut bakes_scenes = state.work.preferences.bakes_scenes;
    let automatic = ui.checkbox(&mut bakes_scenes, "Bake scenes when they open");
    if automatic.on_hover_text("Bakes a draft, then the full bake, at low priority. The cache keeps both.").clicked() {
        actions.push(Action::prefer(Preferences { bakes_scenes, ..state.work.preferences.clone() }));
    }
    let mut follows_edits = state.work.preferences.follows_edits;
    let follows = ui.checkbox(&mut follows_edits, "Bake anew after a move");
    let help = "Bakes shadows and bounced light anew where a moved object or an edited opacity reaches. The rest stays as baked.";
    if follows.on_hover_text(help).clicked() {
        actions.push(Action::prefer(Preferences { follows_edits, ..state.work.preferences.clone() }));
    }
}

fn help(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    entry(ui, state, actions, Command::Keys, true);
    if ui.button("Messages").clicked() {
        state.work.messages.log_open = true;
        ui.close();
    }
    if ui.button("About Lapidary").clicked() {
        state.questions.ask(Prompt::About);
        ui.close();
    }
}
