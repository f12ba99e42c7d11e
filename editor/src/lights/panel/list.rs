//! The list of lights: on and off, select, rename, delete, add, load and save.

use super::{LightsContext, LightsPanel, buried::NOTICE};
use crate::{
    actions::{Action, LightAction},
    document::{Edit, EnvironmentSettings, SunChoice, lights::LightKind},
    widgets::{check_box, display_color, eye, outline},
};
use egui::{
    Align2, Button, Key, Layout, Response, RichText, Role, ScrollArea, Sense, StrokeKind, TextEdit, TextStyle, Ui,
    WidgetInfo, vec2,
};
use lapidary_core::lights::Light;

/// Rows before the list scrolls.
const VISIBLE_ROWS: f32 = 8.0;
/// Side of a swatch in points.
const SWATCH: f32 = 11.0;

/// What a click on the eye of a light does that is on, and of one that is off.
const EYE_OF_LIGHTS: [&str; 2] = ["Switch off", "Switch on"];

/// A light's name while it is typed.
pub struct Renaming {
    index: usize,
    /// Its name and the number of lights at the beginning: if these change, another light has its index.
    before: String,
    count: usize,
    name: String,
    focused: bool,
}

impl Renaming {
    /// Begins with the present name.
    pub fn of(index: usize, lights: &[Light]) -> Self {
        let before = lights[index].name.clone();
        Self { index, name: before.clone(), before, count: lights.len(), focused: false }
    }

    /// Whether the light is still the same.
    fn fits(&self, lights: &[Light]) -> bool {
        lights.len() == self.count && lights.get(self.index).is_some_and(|light| light.name == self.before)
    }

    /// Asks for the typed name, if it is new and not empty.
    fn take(&self, light: &Light, actions: &mut Vec<Action>) {
        let name = self.name.trim();
        if !name.is_empty() && name != light.name {
            let light = Box::new(Light { name: name.to_owned(), ..light.clone() });
            ask(actions, Edit::Light { index: self.index, light }, "Rename light");
        }
    }
}

/// Shows the list and its buttons.
pub fn show(ui: &mut Ui, state: &mut LightsPanel, context: &LightsContext, actions: &mut Vec<Action>) {
    let lights = &context.document.lights;
    // Above the list, which grows: below it, an added row would appear under the pointer.
    buttons(ui, context, actions);
    check_box(ui, &mut state.in_viewport, "Show in the viewport")
        .on_hover_text("Draws the lights over the picture, to select and move them");
    suns(ui, context, actions);
    if lights.is_empty() && context.suns.is_empty() {
        ui.weak("No lights yet");
    }
    state.renaming = state.renaming.take().filter(|renaming| renaming.fits(lights));
    let height = ui.spacing().interact_size.y;
    let limit = VISIBLE_ROWS * (height + ui.spacing().item_spacing.y);
    let area = ScrollArea::vertical().id_salt("lights").max_height(limit).auto_shrink([false, true]);
    area.show_rows(ui, height, lights.len(), |ui, rows| {
        // Ends renaming as a click elsewhere does, since a field out of sight cannot end by itself.
        if let Some(hidden) = state.renaming.take_if(|renaming| !rows.contains(&renaming.index)) {
            hidden.take(&lights[hidden.index], actions);
        }
        for index in rows {
            ui.push_id(index, |ui| {
                let layout = Layout::right_to_left(egui::Align::Center);
                ui.allocate_ui_with_layout(vec2(ui.available_width(), height), layout, |ui| {
                    light_row(ui, state, context, index, actions);
                });
            });
        }
    });
}

/// A row for the suns of the environment, which switches all of them.
fn suns(ui: &mut Ui, context: &LightsContext, actions: &mut Vec<Action>) {
    let Some(brightest) = context.suns.first() else { return };
    let settings = &context.document.environment;
    ui.horizontal(|ui| {
        if eye(ui, EYE_OF_LIGHTS, "the sun", settings.sun.enabled).clicked() {
            let sun = SunChoice { enabled: !settings.sun.enabled, ..settings.sun };
            ask(actions, Edit::Environment(EnvironmentSettings { sun, ..settings.clone() }), "Sun");
        }
        swatch(ui, brightest);
        let name = match context.suns.len() {
            1 => "Sun of the environment".to_owned(),
            count => format!("{count} suns of the environment"),
        };
        let text = RichText::new(name);
        let help = "Turns with the environment; edit it in the Environment tab";
        ui.label(if settings.sun.enabled { text } else { text.weak() }).on_hover_text(help);
    });
}

fn light_row(ui: &mut Ui, state: &mut LightsPanel, context: &LightsContext, index: usize, actions: &mut Vec<Action>) {
    let light = &context.document.lights[index];
    let delete = ui.add(Button::new("×").frame(false)).on_hover_text("Delete this light (Delete)");
    if delete.accessible_name(format!("Delete {}", light.name)).clicked() {
        state.renaming = None;
        actions.push(Action::Light(LightAction::Delete(index)));
    }
    if state.buried.contains(context.scene, index, light) {
        warning_sign(ui, &format!("{} is inside an object", light.name)).on_hover_text(NOTICE);
    }
    ui.with_layout(Layout::left_to_right(egui::Align::Center), |ui| {
        if eye(ui, EYE_OF_LIGHTS, &light.name, light.enabled).clicked() {
            let light = Box::new(Light { enabled: !light.enabled, ..light.clone() });
            ask(actions, Edit::Light { index, light }, "Switch light");
        }
        swatch(ui, light);
        if state.renaming.as_ref().is_some_and(|r| r.index == index) {
            return rename(ui, &mut state.renaming, light, actions);
        }
        let text = RichText::new(&light.name);
        let text = if light.enabled { text } else { text.weak() };
        let button = Button::selectable(context.selected == Some(index), "").left_text(text).truncate();
        let name = ui.add(button.min_size(ui.available_size())).accessible_name(&light.name);
        if name.double_clicked() {
            state.renaming = Some(Renaming::of(index, &context.document.lights));
        } else if name.clicked() {
            actions.push(Action::Light(LightAction::Select(Some(index))));
        }
        let kind = LightKind::of(light).label();
        name.on_hover_text(format!("{kind} light. Double-click to rename it"));
    });
}

fn warning_sign(ui: &mut Ui, what: &str) -> Response {
    let (rect, sign) = ui.allocate_exact_size(vec2(SWATCH, ui.spacing().interact_size.y), Sense::hover());
    sign.widget_info(|| WidgetInfo::labeled(Role::Image, ui.is_enabled(), what));
    let font = TextStyle::Heading.resolve(ui.style());
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, "!", font, ui.visuals().warn_fg_color);
    sign
}

fn swatch(ui: &mut Ui, light: &Light) {
    let (rect, _) = ui.allocate_exact_size(vec2(SWATCH, SWATCH), Sense::hover());
    ui.painter().rect(rect, 2.0, display_color(light.intensity), outline(ui), StrokeKind::Inside);
}

/// The name as a text field: Enter or a click elsewhere accepts it, Escape cancels.
fn rename(ui: &mut Ui, renaming: &mut Option<Renaming>, light: &Light, actions: &mut Vec<Action>) {
    let Some(typed) = renaming else { return };
    let field = TextEdit::singleline(&mut typed.name).desired_width(ui.available_width());
    let field = ui.add(field).accessible_name("Light name");
    if !typed.focused {
        field.request_focus();
        typed.focused = true;
        return;
    }
    // It may lack the focus because the list was out of sight.
    if field.has_focus() {
        return;
    }
    if !ui.input(|i| i.key_pressed(Key::Escape)) {
        typed.take(light, actions);
    }
    *renaming = None;
}

fn buttons(ui: &mut Ui, context: &LightsContext, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.menu_button("Add", |ui| add_menu(ui, actions)).response.on_hover_text("Adds a light");
        let is_selected = context.selected.is_some();
        let mut button = |ui: &mut Ui, text: &str, help: &str, enabled: bool, action: Action| {
            if ui.add_enabled(enabled, Button::new(text)).on_hover_text(help).clicked() {
                actions.push(action);
            }
        };
        let copy = Action::Light(LightAction::Duplicate(context.selected.unwrap_or_default()));
        button(ui, "Duplicate", "Adds a copy of the selected light (Ctrl+D)", is_selected, copy);
        button(ui, "Load...", "Adds the lights from a file", true, Action::Light(LightAction::Load(None)));
        let any = !context.document.lights.is_empty();
        let help = "Writes all lights to a file for lapidary render --lights";
        button(ui, "Save...", help, any, Action::Light(LightAction::Save(None)));
    });
}

/// The kinds of light to add.
pub fn add_menu(ui: &mut Ui, actions: &mut Vec<Action>) {
    for kind in LightKind::ALL {
        if ui.button(kind.label()).on_hover_text(kind.meaning()).clicked() {
            actions.push(Action::Light(LightAction::Add(kind)));
            ui.close();
        }
    }
}

fn ask(actions: &mut Vec<Action>, edit: Edit, label: &'static str) {
    actions.extend([Action::Edit { edit, label }, Action::EndGesture]);
}
