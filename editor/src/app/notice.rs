//! Text in the viewport without a picture, or with an empty one: the present activity, or the next step.

use super::state::EditorState;
use crate::{
    actions::{Action, BakeAction, FileAction},
    document::Unlit,
    lights::panel::add_menu,
    workspace::{Inspector, Tabs},
};
use egui::{Align, Align2, Frame, Layout, ProgressBar, Rect, RichText, Ui, UiBuilder, vec2};
use lapidary_interchange::formats::SceneFormat;

/// Width of the text in points.
const WIDTH: f32 = 380.0;

/// Shows it in the middle of `rect`.
pub fn show(ui: &mut Ui, rect: Rect, state: &mut EditorState, actions: &mut Vec<Action>) {
    let size = vec2(WIDTH.min(rect.width() - 20.0).max(40.0), 150.0);
    let place = Rect::from_center_size(rect.center(), size);
    let layout = Layout::top_down(Align::Center);
    ui.scope_builder(UiBuilder::new().max_rect(place).layout(layout), |ui| contents(ui, state, actions));
}

/// Explains in the lower part of `rect` why its picture is black, with a button that leads to light.
pub fn show_unlit(ui: &mut Ui, rect: Rect, unlit: Unlit, tabs: &mut Tabs, actions: &mut Vec<Action>) {
    below(ui, rect, 90.0, |ui| match unlit {
        Unlit::NoLights => {
            ui.label(RichText::new("Nothing gives light").strong());
            ui.label("The bake has no environment light, and the scene has no lights.");
            ui.menu_button("Add a light", |ui| add_menu(ui, actions));
        }
        Unlit::SwitchedOff => {
            ui.label(RichText::new("All light is switched off").strong());
            ui.label("The Lights tab switches each light and each part of the light.");
            if ui.button("Open the Lights tab").clicked() {
                tabs.show_inspector(Inspector::Lights);
            }
        }
    });
}

/// Explains in the lower part of `rect` why its picture has no shadows, with a button to bake.
pub fn show_below(ui: &mut Ui, rect: Rect, state: &mut EditorState, actions: &mut Vec<Action>) {
    below(ui, rect, 130.0, |ui| contents(ui, state, actions));
}

fn below(ui: &mut Ui, rect: Rect, height: f32, contents: impl FnOnce(&mut Ui)) {
    let size = vec2(WIDTH.min(rect.width() - 20.0).max(40.0), height);
    let place = Align2::CENTER_BOTTOM.align_size_within_rect(size, rect.shrink2(vec2(0.0, 40.0)));
    let layout = Layout::top_down(Align::Center);
    ui.scope_builder(UiBuilder::new().max_rect(place).layout(layout), |ui| {
        Frame::popup(ui.style()).show(ui, contents);
    });
}

fn contents(ui: &mut Ui, state: &mut EditorState, actions: &mut Vec<Action>) {
    let title = state.work.title();
    if let Some(opening) = &state.opening {
        heading(ui, &format!("Opening {}", opening.what));
        ui.spinner();
    } else if let Some(line) = state.baking.line() {
        baking(ui, &title, &line, state.baking.progress().and_then(|p| p.fraction()), actions);
    } else if state.work.scene.is_stale() {
        stale(ui, &title, state, actions);
    } else if state.work.scene.source.is_some() {
        not_baked(ui, &title, actions);
    } else {
        nothing(ui, actions);
    }
}

fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).heading());
    ui.add_space(4.0);
}

fn baking(ui: &mut Ui, title: &str, line: &str, fraction: Option<f32>, actions: &mut Vec<Action>) {
    heading(ui, title);
    ui.label("Visibility is traced once; light and materials can then be edited freely.");
    ui.add_space(6.0);
    ui.add(ProgressBar::new(fraction.unwrap_or(0.0)).desired_width(WIDTH - 60.0).desired_height(6.0));
    // The kind of bake, and its phase.
    line.split(": ").for_each(|part| drop(ui.weak(part)));
    ui.add_space(6.0);
    // Not in the middle, where a double click on the button that began the bake would hit it.
    ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
        if ui.button("Cancel").clicked() {
            actions.push(Action::Bake(BakeAction::Cancel));
        }
    });
}

fn stale(ui: &mut Ui, title: &str, state: &mut EditorState, actions: &mut Vec<Action>) {
    heading(ui, &format!("{title} has changed"));
    ui.label("Its bake is of another version of the scene, so shadows and reflections are wrong.");
    ui.add_space(6.0);
    if ui.button(RichText::new("Bake again").strong()).clicked() {
        actions.push(Action::Bake(BakeAction::Begin { resume: false }));
    }
    if ui.button("Show anyway").clicked() {
        state.work.scene.show_stale = true;
    }
}

fn not_baked(ui: &mut Ui, title: &str, actions: &mut Vec<Action>) {
    heading(ui, &format!("{title} is not baked yet"));
    ui.label("A bake traces which light reaches each point. The Bake tab has presets, from seconds to minutes.");
    ui.add_space(6.0);
    if ui.button(RichText::new("Bake now").strong()).clicked() {
        actions.push(Action::Bake(BakeAction::Begin { resume: false }));
    }
}

fn nothing(ui: &mut Ui, actions: &mut Vec<Action>) {
    heading(ui, "Nothing is open");
    let scenes = SceneFormat::names_richest_first();
    ui.label(format!("Drop a scene here ({scenes}), a baked scene (.cuts) or a session (.lapidary)."));
    ui.add_space(6.0);
    if ui.button("Open...").clicked() {
        actions.push(Action::File(FileAction::Open(None)));
    }
    if ui.button("Open the bundled scene").clicked() {
        actions.push(Action::File(FileAction::OpenBundled(0)));
    }
}
