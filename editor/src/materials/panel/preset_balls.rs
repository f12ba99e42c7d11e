//! The menu of presets: a ball of each under studio light, by group. The balls are made once, on a thread of their own, when the
//! menu is first opened.

use super::{
    Changes,
    preview_ball::{Ball, MARGIN},
    preview_worker::displayed,
    studio,
};
use crate::{dragged::Dragged, widgets::check_box};
use egui::{
    Color32, ColorImage, Context, Rect, Response, Role, Sense, TextureHandle, TextureOptions, Ui, WidgetInfo, pos2,
    vec2,
};
use lapidary_core::material::{PRESETS, Preset};
use lapidary_render::Post;
use std::{
    sync::mpsc::{Receiver, channel},
    thread,
};

/// Points of a ball's side, and pixels of its picture.
const SIDE: f32 = 44.0;
const PIXELS: u32 = 88;
/// Points of an entry's width, and of the menu's.
const WIDTH: f32 = 70.0;
const COLUMNS: usize = 5;

/// The balls made so far.
#[derive(Default)]
pub struct PresetBalls {
    pictures: Vec<Option<TextureHandle>>,
    made: Option<Receiver<(usize, ColorImage)>>,
}

impl PresetBalls {
    fn update(&mut self, context: &Context) {
        let made = self.made.get_or_insert_with(|| {
            let (outgoing, made) = channel();
            let context = context.clone();
            thread::spawn(move || {
                for (index, preset) in PRESETS.iter().enumerate() {
                    let Some(image) = picture(preset) else { return };
                    if outgoing.send((index, image)).is_err() {
                        return;
                    }
                    context.request_repaint();
                }
            });
            made
        });
        self.pictures.resize(PRESETS.len(), None);
        for (index, image) in made.try_iter() {
            let name = format!("preset {}", PRESETS[index].name);
            self.pictures[index] = Some(context.load_texture(name, image, TextureOptions::LINEAR));
        }
    }

    /// Shows the menu.
    pub fn show(&mut self, ui: &mut Ui, clear_maps: &mut bool, changes: &mut Changes) {
        self.update(ui.ctx());
        check_box(ui, clear_maps, "Clear maps")
            .on_hover_text("Remove maps, which otherwise modulate the preset's values");
        egui::ScrollArea::vertical().min_scrolled_height(600.0).max_height(640.0).show(ui, |ui| {
            let mut index = 0;
            for group in PRESETS.chunk_by(|a, b| a.group == b.group) {
                ui.add_space(4.0);
                ui.weak(group[0].group);
                for line in group.chunks(COLUMNS) {
                    ui.horizontal(|ui| {
                        for preset in line {
                            let entry = self.entry(ui, index, preset);
                            entry.dnd_set_drag_payload(Dragged::Preset { index, clear_maps: *clear_maps });
                            if entry.clicked() {
                                changes.replace("Preset", preset.applied_to(&changes.material, *clear_maps));
                            }
                            if entry.clicked() || entry.drag_stopped() {
                                ui.close();
                            }
                            index += 1;
                        }
                    });
                }
            }
        });
    }

    /// A ball with its name below, to click or drag.
    fn entry(&self, ui: &mut Ui, index: usize, preset: &Preset) -> Response {
        let (rect, response) = ui.allocate_exact_size(vec2(WIDTH, SIDE + 32.0), Sense::click_and_drag());
        let response = response.on_hover_text(preset.source);
        response.widget_info(|| WidgetInfo::labeled(Role::Button, true, preset.name));
        let visuals = ui.style().interact(&response);
        if response.hovered() || response.has_focus() {
            ui.painter().rect_filled(rect, 4.0, visuals.bg_fill);
        }
        let ball = Rect::from_center_size(pos2(rect.center().x, rect.top() + 0.5 * SIDE + 2.0), vec2(SIDE, SIDE));
        match &self.pictures[index] {
            Some(picture) => {
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter().image(picture.id(), ball, whole, Color32::WHITE);
            }
            None => {
                ui.painter().circle_filled(ball.center(), 0.5 * SIDE / MARGIN, super::PLACEHOLDER);
            }
        }
        let font = egui::TextStyle::Small.resolve(ui.style());
        let text = ui.painter().layout(preset.name.to_owned(), font, visuals.text_color(), WIDTH - 4.0);
        let left = rect.center().x - 0.5 * text.size().x;
        ui.painter().galley(pos2(left, ball.bottom() + 2.0), text, visuals.text_color());
        response
    }
}

fn picture(preset: &Preset) -> Option<ColorImage> {
    let ball = Ball { material: preset.material(), textures: Vec::new(), lighting: studio::light()? };
    Some(displayed(&ball.render(PIXELS), &Post::default(), PIXELS))
}
