//! The outliner: objects with their materials, materials, and cameras.

mod bookmarks;
mod pose;
#[cfg(test)]
mod tests;

use crate::{
    actions::{Action, CameraAction, FileAction, MaterialAction, SelectAction},
    document::Document,
    dragged::Dragged,
    viewport::{
        gizmo::{Pivot, Subject},
        object_menu,
    },
    widgets::{eye, outline, padlock, section},
};
use egui::{
    Button, Color32, ComboBox, Layout, Response, Role, ScrollArea, Sense, StrokeKind, TextEdit, Ui, WidgetInfo, vec2,
};
use lapidary_core::{
    color::codes_from_linear,
    dataset::Dataset,
    material::Material,
    parts::{Part, Variants},
};
use std::collections::BTreeSet;

/// Rows of a list before it scrolls.
const VISIBLE_ROWS: f32 = 9.0;
/// Most materials of an object shown beside its name.
const SWATCHES: usize = 4;
/// Opacity of the highlight of selected objects beside the active one.
const WEAK: f32 = 0.35;
/// Side of a swatch in points.
const SWATCH: f32 = 11.0;

/// Input of the panel.
pub struct SceneContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// Names of the scenes in its file, if there are several, and of the default one.
    pub scenes: (&'a [String], Option<&'a str>),
    /// Its dataset, if one is loaded.
    pub dataset: Option<&'a Dataset>,
    /// The active object: the one selected last.
    pub selected_object: Option<u32>,
    /// The other selected objects.
    pub other_objects: &'a [u32],
    /// The selected objects that can be posed, the active one first.
    pub posable: &'a [Subject],
    /// Whether the next click into the viewport places the pivot of the active object.
    pub placing_pivot: bool,
    /// The selected material.
    pub selected_material: Option<usize>,
}

impl SceneContext<'_> {
    /// The selected objects other than the ground, the active one first.
    fn selected_objects(&self) -> Vec<u32> {
        let ground = self.dataset.and_then(|dataset| dataset.scene.mesh.ground_object());
        let selected = self.selected_object.into_iter().chain(self.other_objects.iter().copied());
        selected.filter(|&object| Some(object) != ground).collect()
    }
}

/// State of the panel between frames.
#[derive(Default)]
pub struct ScenePanel {
    filter: String,
    /// The active object that the list has scrolled to.
    scrolled_to: Option<u32>,
    renaming: Option<bookmarks::Renaming>,
    object_materials: ObjectMaterials,
}

impl ScenePanel {
    /// Another document is open.
    pub fn forget_document(&mut self) {
        (self.filter, self.renaming, self.scrolled_to) = (String::new(), None, None);
    }
}

/// Shows the panel.
pub fn show(
    ui: &mut Ui,
    (state, pivot): (&mut ScenePanel, &mut Pivot),
    context: &SceneContext,
    actions: &mut Vec<Action>,
) {
    let filter = TextEdit::singleline(&mut state.filter).hint_text("Filter").desired_width(f32::INFINITY);
    ui.add(filter).accessible_name("Filter objects and materials");
    scenes(ui, context, actions);
    let wanted = state.filter.trim().to_lowercase();
    if let Some(dataset) = context.dataset {
        state.object_materials.update(dataset);
        let is_new = state.scrolled_to != context.selected_object;
        state.scrolled_to = context.selected_object;
        let scroll_to = context.selected_object.filter(|_| is_new);
        objects(ui, context, dataset, &state.object_materials, (&wanted, scroll_to), actions);
    }
    pose::show(ui, pivot, context, actions);
    materials(ui, context, &wanted, actions);
    context.dataset.into_iter().for_each(|dataset| variants(ui, context.document, &dataset.scene.variants, actions));
    section(ui, "Cameras", true, |ui| bookmarks::show(ui, &mut state.renaming, context, actions));
}

/// The materials of each object's triangles; computed once per dataset, because it takes a pass over all triangles.
#[derive(Default)]
struct ObjectMaterials {
    key: Option<(String, usize)>,
    of_object: Vec<BTreeSet<u32>>,
}

impl ObjectMaterials {
    fn update(&mut self, dataset: &Dataset) {
        let key = (&dataset.scene_hash, dataset.scene.mesh.triangles.len());
        if self.key.as_ref().is_some_and(|(hash, triangles)| (hash, *triangles) == key) {
            return;
        }
        self.key = Some((key.0.clone(), key.1));
        self.of_object = vec![BTreeSet::new(); dataset.scene.objects.len()];
        let mesh = &dataset.scene.mesh;
        for (&object, &material) in mesh.triangle_object.iter().zip(&mesh.triangle_material) {
            self.of_object[object as usize].insert(material);
        }
    }
}

fn objects(
    ui: &mut Ui,
    context: &SceneContext,
    dataset: &Dataset,
    materials: &ObjectMaterials,
    (wanted, scroll_to): (&str, Option<u32>),
    actions: &mut Vec<Action>,
) {
    let names: Vec<&str> = dataset.scene.objects.iter().map(|o| o.name.as_str()).collect();
    let scroll_to = scroll_to.map(|object| object as usize);
    list(ui, "Objects", &names, (wanted, scroll_to), |ui, index| {
        let right_to_left = Layout::right_to_left(egui::Align::Center);
        ui.with_layout(right_to_left, |ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            let shown = |&material| context.document.material_of(Part { object: index as u32, material });
            let shown: BTreeSet<usize> = materials.of_object[index].iter().map(shown).collect();
            for material in shown.into_iter().take(SWATCHES) {
                object_swatch(ui, context, names[index], material, actions);
            }
            ui.with_layout(Layout::left_to_right(egui::Align::Center), |ui| {
                object_eye(ui, context, index as u32, names[index], actions);
                let is_locked = context.document.handling_of(index as u32).locked;
                if is_locked && padlock(ui, names[index]).clicked() {
                    actions.extend(object_menu::lock(context.document, &[index as u32], false));
                }
                object_name(ui, context, index as u32, names[index], actions);
            });
        });
    });
}

/// The eye that hides an object or shows it; the ground has a setting of its own.
fn object_eye(ui: &mut Ui, context: &SceneContext, object: u32, name: &str, actions: &mut Vec<Action>) {
    let is_ground = context.dataset.is_some_and(|dataset| dataset.scene.mesh.ground_object() == Some(object));
    let is_hidden = context.document.poses.of(object).hidden;
    if !is_ground && eye(ui, ["Hide", "Show"], name, !is_hidden).clicked() {
        actions.extend(hide(context.document, [object], !is_hidden));
    }
}

/// Hides objects or shows them, as one step of undo.
pub fn hide(document: &Document, objects: impl IntoIterator<Item = u32>, hidden: bool) -> [Action; 2] {
    let edit = document.hiding(objects, hidden);
    [Action::Edit { edit, label: if hidden { "Hide" } else { "Show" } }, Action::EndGesture]
}

/// The name of an object: a click selects it alone; with Ctrl it adds or removes it.
fn object_name(ui: &mut Ui, context: &SceneContext, object: u32, name: &str, actions: &mut Vec<Action>) {
    let (is_active, moves_along) = (context.selected_object == Some(object), context.other_objects.contains(&object));
    if moves_along {
        let (fill, color) = (ui.visuals().selection.bg_fill.gamma_multiply(WEAK), ui.visuals().text_color());
        let selection = &mut ui.visuals_mut().selection;
        (selection.bg_fill, selection.stroke.color) = (fill, color);
    }
    if context.document.poses.of(object).hidden {
        ui.visuals_mut().override_text_color = Some(ui.visuals().weak_text_color());
    }
    let name = name_button(ui, is_active || moves_along, name);
    let adds = ui.input(|input| input.modifiers.command);
    if name.clicked() {
        actions.push(if adds {
            Action::Select(SelectAction::Toggle(object))
        } else {
            Action::Select(SelectAction::Object(Some(object)))
        });
    }
    let is_selected = is_active || moves_along;
    if name.secondary_clicked() && !is_selected {
        actions.push(Action::Select(SelectAction::Object(Some(object))));
    }
    name.context_menu(|ui| object_menu::show(ui, context.document, &context.selected_objects(), actions));
    let help = "Ctrl-click to add it to the selection or remove it, double-click to frame it, right-click for more";
    if name.on_hover_text(help).double_clicked() && !adds {
        actions.push(Action::Camera(CameraAction::FrameSelection));
    }
}

/// The color of one of an object's materials; a click selects the material.
fn object_swatch(ui: &mut Ui, context: &SceneContext, object: &str, index: usize, actions: &mut Vec<Action>) {
    let Some(material) = context.document.materials.get(index) else { return };
    let name = context.document.material_name(index);
    let swatch = swatch(ui, material, Sense::click());
    swatch.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("{name} of {object}")));
    if swatch.on_hover_text(name).clicked() {
        actions.push(Action::Select(SelectAction::Material(Some(index))));
    }
}

fn materials(ui: &mut Ui, context: &SceneContext, wanted: &str, actions: &mut Vec<Action>) {
    let materials = &context.document.materials;
    let names: Vec<String> = (0..materials.len()).map(|i| context.document.material_name(i)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    list(ui, "Materials", &names, (wanted, None), |ui, index| {
        swatch(ui, &materials[index], Sense::hover());
        let name = name_button(ui, context.selected_material == Some(index), names[index]).interact(Sense::drag());
        name.dnd_set_drag_payload(Dragged::Material(index));
        if name.on_hover_text("Drag it onto a surface to apply its values").clicked() {
            actions.push(Action::Select(SelectAction::Material(Some(index))));
        }
    });
}

/// The list of scenes in a glTF file. Another one is opened in place of this.
fn scenes(ui: &mut Ui, context: &SceneContext, actions: &mut Vec<Action>) {
    let (names, default) = context.scenes;
    if names.is_empty() {
        return;
    }
    let shown = context.document.scene_in_file.as_deref().or(default);
    ui.horizontal(|ui| {
        let label =
            ui.label("Scene").on_hover_text("Scenes of the glTF file. Another one is opened and baked for itself.");
        let combo = ComboBox::from_id_salt("scene of the file").selected_text(shown.unwrap_or("All nodes"));
        let opened = combo.width(ui.available_width()).truncate().show_ui(ui, |ui| {
            for name in names {
                if ui.selectable_label(shown == Some(name), name).clicked() && shown != Some(name) {
                    let chosen = (default != Some(name)).then(|| name.clone());
                    actions.push(Action::File(FileAction::OpenSceneIn(chosen)));
                }
            }
        });
        opened.response.labelled_by(label.id);
    });
}

/// The list of variants in a glTF file.
fn variants(ui: &mut Ui, document: &Document, variants: &Variants, actions: &mut Vec<Action>) {
    if variants.is_empty() {
        return;
    }
    const PLAIN: &str = "As in the file";
    let name = |variant: Option<usize>| variant.map_or(PLAIN, |variant| variants.names[variant].as_str());
    let shown = document.shown_variant(variants);
    ui.horizontal(|ui| {
        let label = ui.label("Variant").on_hover_text("Material variants of the glTF file. No bake is needed.");
        let combo = ComboBox::from_id_salt("variant").selected_text(shown.map_or("Mixed", name));
        let opened = combo.width(ui.available_width()).truncate().show_ui(ui, |ui| {
            for variant in [None].into_iter().chain((0..variants.names.len()).map(Some)) {
                if ui.selectable_label(shown == Some(variant), name(variant)).clicked() {
                    actions.push(Action::Material(MaterialAction::ChooseVariant(variant)));
                }
            }
        });
        opened.response.labelled_by(label.id);
    });
}

/// A folding list of the names that contain `wanted`; only visible rows are laid out, since there may be thousands. It scrolls to a
/// row that is out of sight.
fn list(
    ui: &mut Ui,
    title: &str,
    names: &[&str],
    (wanted, scroll_to): (&str, Option<usize>),
    mut add_row: impl FnMut(&mut Ui, usize),
) {
    let shown: Vec<usize> =
        (0..names.len()).filter(|&i| wanted.is_empty() || names[i].to_lowercase().contains(wanted)).collect();
    section(ui, title, true, |ui| {
        if shown.is_empty() {
            ui.weak(if names.is_empty() { "None yet" } else { "No match" });
            return;
        }
        let height = ui.spacing().interact_size.y;
        let row_height = height + ui.spacing().item_spacing.y;
        let mut area = ScrollArea::vertical().id_salt(title).max_height(VISIBLE_ROWS * row_height);
        let row = scroll_to.and_then(|wanted| shown.iter().position(|&index| index == wanted));
        if let Some(row) = row {
            let before = ui.data(|data| data.get_temp(ui.scope_id().with(title))).unwrap_or(0.0);
            area = area.vertical_scroll_offset(offset_with(row, before / row_height) * row_height);
        }
        area = area.auto_shrink([false, true]);
        let scrolled = area.show_rows(ui, height, shown.len(), |ui, rows| {
            for &index in &shown[rows] {
                ui.push_id(index, |ui| {
                    let layout = Layout::left_to_right(egui::Align::Center);
                    let size = vec2(ui.available_width(), height);
                    ui.allocate_ui_with_layout(size, layout, |ui| add_row(ui, index));
                });
            }
        });
        let id = ui.scope_id().with(title);
        ui.data_mut(|data| data.insert_temp(id, scrolled.state.clamped_offset().y));
    });
}

/// The offset of a list in rows at which a row is in sight, near the offset before.
fn offset_with(row: usize, before: f32) -> f32 {
    let row = row as f32;
    if row < before || row + 1.0 > before + VISIBLE_ROWS { (row - 0.5 * VISIBLE_ROWS).max(0.0) } else { before }
}

/// A name that takes the rest of the row.
fn name_button(ui: &mut Ui, selected: bool, name: &str) -> Response {
    let button = Button::selectable(selected, "").left_text(name).truncate();
    ui.add(button.min_size(ui.available_size())).accessible_name(name)
}

fn swatch(ui: &mut Ui, material: &Material, sense: Sense) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(SWATCH, SWATCH), sense);
    let [r, g, b] = codes_from_linear(material.parameters.color("base_color"));
    let color = Color32::from_rgb(r, g, b);
    ui.painter().rect(rect, 2.0, color, outline(ui), StrokeKind::Inside);
    response
}
