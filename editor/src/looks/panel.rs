//! The tab of looks: a row for each, with its picture.

use super::{PictureOfDocument, add_look, show_look, step, thumbnails::LookThumbnails};
use crate::{
    actions::{Action, CompareAction, LookAction},
    document::{
        Document, Edit,
        looks::{LookPart, LookState, NamedLook},
    },
    widgets::{note, outline},
};
use egui::{
    Align, Button, Color32, Context, Key, Layout, Popup, Rect, Response, Role, Sense, Stroke, StrokeKind, TextEdit, Ui,
    WidgetInfo, pos2, vec2,
};
use lapidary_core::scene::pose::Poses;
use lapidary_render::{BackendFactory, Baked};
use lapidary_studies::jobs::Wake;

/// Width and height of a picture in points.
const PICTURE: egui::Vec2 = vec2(96.0, 60.0);
/// Number of looks that have a key.
pub const KEYS: usize = 9;

/// Input of the tab.
pub struct LooksContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// Its bake and its poses; `None` without a scene.
    pub shown: Option<(&'a Baked, Poses)>,
    /// Size of the picture in the window.
    pub size: [u32; 2],
    /// Makes renderers for the pictures.
    pub factory: &'a BackendFactory,
    /// Makes the window look for pictures.
    pub wake: &'a Wake,
    /// Whether nothing moves and nobody waits, so that pictures of looks may take the cores.
    pub is_calm: bool,
}

/// State of the tab between frames.
#[derive(Default)]
pub struct LooksPanel {
    thumbnails: LookThumbnails,
    renaming: Option<Renaming>,
}

/// A name while it is typed.
struct Renaming {
    look: usize,
    before: String,
    name: String,
    is_focused: bool,
}

/// Shows the tab.
pub fn show(ui: &mut Ui, panel: &mut LooksPanel, context: &LooksContext, actions: &mut Vec<Action>) {
    let document = context.document;
    panel.ask_for_pictures(context);
    ui.horizontal(|ui| {
        let help = "Keep the materials, the light, the camera and the view as they are now";
        if ui.add_enabled(context.shown.is_some(), Button::new("Add look")).on_hover_text(help).clicked() {
            actions.extend(add_look(document));
        }
        let has_some = context.shown.is_some() && !document.looks.is_empty();
        let help = "Write a picture of each look to a folder";
        if ui.add_enabled(has_some, Button::new("Render looks...")).on_hover_text(help).clicked() {
            actions.push(Action::Look(LookAction::Describe));
        }
    });
    if document.looks.is_empty() {
        note(
            ui,
            "A look keeps materials, light, camera and view. Add one, change something, add another, and switch between them.",
        );
    }
    for look in 0..document.looks.len() {
        ui.push_id(("look", look), |ui| row(ui, panel, document, look, actions));
    }
}

fn row(ui: &mut Ui, panel: &mut LooksPanel, document: &Document, look: usize, actions: &mut Vec<Action>) {
    let named = &document.looks[look];
    ui.add_space(2.0);
    ui.horizontal(|ui| {
        let picture = picture(ui, panel, document, named);
        let problem = panel.thumbnails.of(&named.state).and_then(Result::err);
        if picture.on_hover_text(problem.unwrap_or("Click to show this look")).clicked() {
            actions.extend(show_look(document, look, LookPart::All));
        }
        let size = vec2(ui.available_width(), PICTURE.y);
        ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
            ui.add_space(4.0);
            name(ui, panel, document, look, actions);
            ui.horizontal(|ui| {
                menu(ui, panel, document, look, actions);
                if look < KEYS {
                    ui.weak(format!("Alt+{}", look + 1));
                }
            });
        });
    });
}

/// The picture of a look, in a frame if the document has its materials and its light.
fn picture(ui: &mut Ui, panel: &LooksPanel, document: &Document, named: &NamedLook) -> Response {
    let (rect, response) = ui.allocate_exact_size(PICTURE, Sense::click());
    let is_shown = named.state.has_materials_and_light_of(document);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_shown, format!("Show {}", named.name)));
    match panel.thumbnails.of(&named.state) {
        Some(Ok(texture)) => {
            let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture.id(), rect, all, Color32::WHITE);
        }
        Some(Err(_)) | None => {
            ui.painter().rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        }
    }
    let stroke =
        if is_shown || response.has_focus() { Stroke::new(2.0, ui.visuals().selection.bg_fill) } else { outline(ui) };
    ui.painter().rect_stroke(rect, 2.0, stroke, StrokeKind::Inside);
    response
}

/// The name; a double click makes it a text field, in which Enter or a click elsewhere accepts it and Escape cancels.
fn name(ui: &mut Ui, panel: &mut LooksPanel, document: &Document, look: usize, actions: &mut Vec<Action>) {
    let named = &document.looks[look];
    let is_renamed = |renaming: &&mut Renaming| renaming.look == look && renaming.before == named.name;
    let Some(renaming) = panel.renaming.as_mut().filter(is_renamed) else {
        let button = Button::new(named.name.as_str()).frame(false).truncate();
        if ui.add(button).on_hover_text("Double-click to rename").double_clicked() {
            panel.begin_renaming(look, &named.name);
        }
        return;
    };
    let is_taken = document.look(renaming.name.trim()).is_some_and(|other| other.name != renaming.before);
    let color = is_taken.then(|| ui.visuals().error_fg_color);
    let field = TextEdit::singleline(&mut renaming.name).text_color_opt(color).desired_width(ui.available_width());
    let mut field = ui.add(field).accessible_name("Look name");
    if is_taken {
        field = field.on_hover_text("Another look has this name");
    }
    if !renaming.is_focused {
        field.request_focus();
        renaming.is_focused = true;
    } else if field.lost_focus() {
        let typed = renaming.name.trim().to_owned();
        let is_free = document.look(&typed).is_none() && !typed.is_empty();
        if is_free && !ui.input(|input| input.key_pressed(Key::Escape)) {
            actions.extend(changed(document, "Rename look", |looks| looks[look].name = typed));
        }
        panel.renaming = None;
    }
}

fn menu(ui: &mut Ui, panel: &mut LooksPanel, document: &Document, look: usize, actions: &mut Vec<Action>) {
    let named = &document.looks[look];
    let button = ui.button("...").accessible_name(format!("More of {}", named.name));
    Popup::menu(&button).show(|ui| {
        let parts = [(LookPart::Materials, "materials"), (LookPart::Light, "light"), (LookPart::Camera, "camera")];
        for (part, label) in parts {
            if ui.button(format!("Show only its {label}")).clicked() {
                actions.extend(show_look(document, look, part));
            }
        }
        ui.separator();
        if ui.button("Compare with it").clicked() {
            actions.push(Action::Compare(CompareAction::Look(look)));
        }
        ui.separator();
        if ui.button("Replace by what is shown").clicked() {
            let state = LookState::of(document);
            actions.extend(changed(document, "Replace look", |looks| looks[look].state = state));
        }
        if ui.button("Rename").clicked() {
            panel.begin_renaming(look, &named.name);
        }
        if ui.button("Delete").clicked() {
            panel.renaming = None;
            actions.extend(changed(document, "Delete look", |looks| drop(looks.remove(look))));
        }
    });
}

impl LooksPanel {
    /// Whether there is a picture of a look.
    #[cfg(test)]
    pub fn has_picture(&self, look: &LookState) -> bool {
        self.thumbnails.of(look).is_some_and(|picture| picture.is_ok())
    }

    /// Takes pictures that are ready.
    pub fn collect(&mut self, ctx: &Context, document: &Document, baked: Option<&Baked>) {
        self.thumbnails.collect(ctx, &document.looks, baked);
    }

    fn ask_for_pictures(&mut self, context: &LooksContext) {
        let LooksContext { document, size, factory, wake, .. } = *context;
        let Some((baked, poses)) = context.shown.as_ref().filter(|_| context.is_calm) else { return };
        let Some(look) = self.thumbnails.missing(&document.looks, baked, poses) else { return };
        let (shown, baked, poses) = (document.clone(), (*baked).clone(), poses.clone());
        let picture = PictureOfDocument { document: shown, baked, poses, size, aa: None };
        self.thumbnails.ask(look, picture, factory, wake);
    }

    fn begin_renaming(&mut self, look: usize, name: &str) {
        self.renaming = Some(Renaming { look, before: name.into(), name: name.into(), is_focused: false });
    }
}

/// Changes the looks, as one step of undo.
fn changed(document: &Document, label: &'static str, change: impl FnOnce(&mut Vec<NamedLook>)) -> Vec<Action> {
    let mut looks = document.looks.clone();
    change(&mut looks);
    step(Edit::Looks(looks), label)
}
