//! The toolbar.

use super::{
    keys::{self, Command},
    state::EditorState,
};
use crate::{
    actions::Action,
    document::{Edit, ViewSettings},
    viewport::gizmo::Tool,
    widgets::{Typing, typed},
};
use egui::{Button, ComboBox, DragValue, TextStyle, Ui};
use lapidary_render::{ToneMap, ViewMode};

/// Shows the toolbar.
pub fn show(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    ui.add_space(1.0);
    ui.horizontal(|ui| {
        let (undo, redo) =
            (state.work.history.undo_name(&state.work.document), state.work.history.redo_name(&state.work.document));
        tool(ui, state, actions, Command::Undo, "Undo", undo.is_some());
        tool(ui, state, actions, Command::Redo, "Redo", redo.is_some());
        ui.separator();
        let shown = state.work.scene.rendered().is_some();
        tool(ui, state, actions, Command::FrameSelection, "Frame", shown);
        ui.separator();
        pose_tools(ui, state, actions);
        ui.separator();
        let can_compare = state.comparison.panel.open || state.picture.can_be_compared(&state.work);
        tool(ui, state, actions, Command::Compare, "Compare", can_compare);
        ui.separator();
        view_tools(ui, &state.work.document.view, actions);
    });
    ui.add_space(1.0);
}

fn tool(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>, command: Command, label: &str, enabled: bool) {
    let help = format!("{} ({})", keys::binding(command).label, keys::text(ui.ctx(), command));
    if ui.add_enabled(enabled, Button::new(label)).on_hover_text(help).clicked() {
        state.command(command, actions);
    }
}

/// The tools of the handles.
fn pose_tools(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    let tools =
        [(None, "Select"), (Some(Tool::Move), "Move"), (Some(Tool::Turn), "Turn"), (Some(Tool::Scale), "Scale")];
    for (tool, label) in tools {
        let command = Command::Tool(tool);
        let help = format!("{} ({})", keys::binding(command).label, keys::text(ui.ctx(), command));
        let response = ui.selectable_label(state.pose.tool == tool, label).on_hover_text(help);
        if response.accessible_name(format!("{label} tool")).clicked() {
            state.command(command, actions);
        }
    }
}

fn view_tools(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let mut new = view.clone();
    combo(ui, "View mode", view.mode.label(), &mut new.mode, &ViewMode::ALL.map(|m| (m, m.label())));
    push(actions, view, &new, "View mode", true);

    let mut new = view.clone();
    let help = format!("Wireframe ({})", keys::text(ui.ctx(), Command::Wireframe));
    ui.toggle_value(&mut new.wireframe, "Wireframe").on_hover_text(help);
    push(actions, view, &new, "Wireframe", true);
    ui.separator();

    ui.label("Exposure");
    let mut new = view.clone();
    ui.style_mut().drag_value_text_style = TextStyle::Monospace;
    let exposure =
        DragValue::new(&mut new.post.exposure).range(-30.0..=30.0).speed(0.02).fixed_decimals(2).suffix(" EV");
    let response = typed(ui, exposure, &Typing { unit: " EV", range: Some(-30.0..=30.0), size: None })
        .accessible_name("Exposure tool")
        .on_hover_text("Exposure in stops. Drag, or click and type");
    push(actions, view, &new, "Exposure", response.drag_stopped() || response.lost_focus());

    let mut new = view.clone();
    let maps = ToneMap::ALL.map(|t| (t, t.label()));
    combo(ui, "Tone map", view.post.tone_map.label(), &mut new.post.tone_map, &maps);
    push(actions, view, &new, "Tone map", true);
}

fn combo<T: Copy + PartialEq>(ui: &mut Ui, name: &str, shown: &str, value: &mut T, choices: &[(T, &str)]) {
    let combo = ComboBox::from_id_salt(name).selected_text(shown).show_ui(ui, |ui| {
        for &(choice, label) in choices {
            ui.selectable_value(value, choice, label);
        }
    });
    combo.response.on_hover_text(name).accessible_name(format!("{name} tool"));
}

/// Asks for the new settings if they differ; `ended` closes the step of undo.
fn push(actions: &mut Vec<Action>, old: &ViewSettings, new: &ViewSettings, label: &'static str, ended: bool) {
    let changed = old != new;
    if changed {
        actions.push(Action::Edit { edit: Edit::View(new.clone()), label });
    }
    if ended && (changed || label == "Exposure") {
        actions.push(Action::EndGesture);
    }
}
