//! Cameras of the scene and bookmarks: apply, add, rename, delete.

use super::{SceneContext, name_button};
use crate::{
    actions::{Action, CameraAction},
    document::{Document, Edit},
};
use egui::{Button, Key, Layout, TextEdit, Ui, vec2};
use lapidary_core::camera::Camera;

/// A bookmark's name while it is typed.
pub struct Renaming {
    index: usize,
    name: String,
    focused: bool,
}

/// Shows the cameras of the scene, then the bookmarks.
pub fn show(ui: &mut Ui, renaming: &mut Option<Renaming>, context: &SceneContext, actions: &mut Vec<Action>) {
    let document = context.document;
    // Above the list, which grows: below it, an added row would appear under the pointer.
    if ui.button("Add view").on_hover_text("Bookmark the current view").clicked() {
        let camera = Camera { name: free_name(document), ..document.camera.clone() };
        let bookmarks = document.bookmarks.iter().cloned().chain([camera]).collect();
        ask(actions, bookmarks, "Add view");
    }
    let cameras = context.dataset.map_or(&[][..], |d| &d.scene.cameras);
    for (index, camera) in cameras.iter().enumerate().filter(|(_, c)| !document.bookmarks.contains(c)) {
        ui.push_id(("camera", index), |ui| scene_camera(ui, index, camera, actions));
    }
    for index in 0..document.bookmarks.len() {
        ui.push_id(("bookmark", index), |ui| {
            let layout = Layout::right_to_left(egui::Align::Center);
            let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
            ui.allocate_ui_with_layout(size, layout, |ui| bookmark(ui, renaming, document, index, actions));
        });
    }
}

fn scene_camera(ui: &mut Ui, index: usize, camera: &Camera, actions: &mut Vec<Action>) {
    let unnamed = format!("Camera {}", index + 1);
    let name = if camera.name.is_empty() { &unnamed } else { &camera.name };
    let button = Button::selectable(false, "").left_text(name.as_str()).truncate();
    let button = ui.add_sized([ui.available_width(), ui.spacing().interact_size.y], button).accessible_name(name);
    if button.on_hover_text("Camera from the scene file").clicked() {
        actions.push(Action::Camera(CameraAction::To(camera.clone())));
    }
}

fn bookmark(
    ui: &mut Ui,
    renaming: &mut Option<Renaming>,
    document: &Document,
    index: usize,
    actions: &mut Vec<Action>,
) {
    let camera = &document.bookmarks[index];
    let delete = ui.add(Button::new("×").frame(false)).on_hover_text("Delete this view");
    if delete.accessible_name(format!("Delete {}", camera.name)).clicked() {
        *renaming = None;
        let bookmarks = document.bookmarks.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, c)| c.clone());
        return ask(actions, bookmarks.collect(), "Delete view");
    }
    if renaming.as_ref().is_some_and(|r| r.index == index) {
        return rename(ui, renaming, document, actions);
    }
    let name = name_button(ui, false, &camera.name).on_hover_text("Click to go there, double-click to rename");
    if name.double_clicked() {
        *renaming = Some(Renaming { index, name: camera.name.clone(), focused: false });
    } else if name.clicked() {
        actions.push(Action::Camera(CameraAction::To(camera.clone())));
    }
}

/// The name as a text field: Enter or a click elsewhere accepts it, Escape cancels.
fn rename(ui: &mut Ui, renaming: &mut Option<Renaming>, document: &Document, actions: &mut Vec<Action>) {
    let Some(Renaming { index, name, focused }) = renaming else { return };
    let field = ui.add(TextEdit::singleline(name).desired_width(ui.available_width())).accessible_name("View name");
    if !*focused {
        field.request_focus();
        *focused = true;
        return;
    }
    if !field.lost_focus() {
        return;
    }
    let mut bookmarks = document.bookmarks.clone();
    let typed = name.trim().to_owned();
    let taken = !ui.input(|i| i.key_pressed(Key::Escape)) && !typed.is_empty() && typed != bookmarks[*index].name;
    if taken {
        bookmarks[*index].name = typed;
        ask(actions, bookmarks, "Rename view");
    }
    *renaming = None;
}

fn ask(actions: &mut Vec<Action>, bookmarks: Vec<Camera>, label: &'static str) {
    actions.extend([Action::Edit { edit: Edit::Bookmarks(bookmarks), label }, Action::EndGesture]);
}

/// "View" and the least unused number.
fn free_name(document: &Document) -> String {
    let name = |number: usize| format!("View {number}");
    let taken = |name: &String| document.bookmarks.iter().any(|b| b.name == *name);
    (1..).map(name).find(|n| !taken(n)).unwrap_or_default()
}
