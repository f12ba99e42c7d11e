//! The library of environments as two grids: formulas, then maps.

use super::{EnvironmentContext, thumbnail};
use crate::{
    actions::{Action, EnvironmentAction, FileAction},
    document::{Edit, EnvironmentSettings},
};
use egui::{
    Align2, Color32, ColorImage, Rect, Response, RichText, Role, Sense, Stroke, StrokeKind, TextStyle, TextureHandle,
    TextureId, TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use lapidary_interchange::environment;
use std::sync::mpsc::{Receiver, channel};

/// Least width of a cell in points.
const CELL_WIDTH: f32 = 88.0;
/// Height of the name under a thumbnail in points.
const NAME_HEIGHT: f32 = 16.0;
/// Pixels of the formulas' thumbnails.
const THUMBNAIL: [usize; 2] = [128, 64];
/// Names and specifications of the environments that need no file.
const FORMULAS: [(&str, &str); 4] = [
    ("Studio", "studio"),
    ("Sun and sky", "sun-sky:45"),
    ("Constant", "constant:1,1,1"),
    ("Orientation", "orientation"),
];

/// A map of the library.
#[derive(Clone)]
pub struct LibraryEntry {
    /// Displayed name.
    pub name: String,
    /// Specification for `environment::from_spec`.
    pub spec: String,
    /// Whether its file is missing.
    pub missing: bool,
    /// A thumbnail twice as wide as high, once it is made.
    pub thumbnail: Option<TextureHandle>,
}

/// Thumbnails of the formulas, made on a thread when they are first shown.
#[derive(Default)]
pub struct FormulaThumbnails {
    made: Option<Receiver<ColorImage>>,
    textures: Vec<TextureHandle>,
}

impl FormulaThumbnails {
    fn receive(&mut self, ui: &Ui) {
        let made = self.made.get_or_insert_with(|| {
            let (sender, made) = channel();
            let context = ui.ctx().clone();
            std::thread::spawn(move || {
                let maps = FORMULAS.iter().filter_map(|(_, spec)| environment::from_spec(spec).ok());
                for (map, _) in maps {
                    // Fails only if the window was closed meanwhile.
                    if sender.send(thumbnail(&map, THUMBNAIL)).is_ok() {
                        context.request_repaint();
                    }
                }
            });
            made
        });
        for image in made.try_iter() {
            self.textures.push(ui.ctx().load_texture("formula", image, TextureOptions::LINEAR));
        }
    }
}

/// Shows the grids, and the buttons that add to them.
pub fn show(ui: &mut Ui, formulas: &mut FormulaThumbnails, context: &EnvironmentContext, actions: &mut Vec<Action>) {
    formulas.receive(ui);
    let light = &context.document.environment;
    let formula_cells = FORMULAS.iter().enumerate().map(|(i, (name, spec))| Cell {
        name,
        spec,
        selected: formula_of(spec) == formula_of(&light.spec),
        missing: false,
        thumbnail: formulas.textures.get(i).map(TextureHandle::id),
    });
    let library_cells = context.library.iter().map(|entry| Cell {
        name: &entry.name,
        spec: &entry.spec,
        selected: entry.spec == light.spec,
        missing: entry.missing,
        thumbnail: entry.thumbnail.as_ref().map(TextureHandle::id),
    });
    ui.label(RichText::new("Formulas").weak()).on_hover_text("Built-in environments that need no file");
    grid(ui, &formula_cells.collect::<Vec<_>>(), light, actions);
    ui.add_space(4.0);
    ui.label(RichText::new("Maps").weak()).on_hover_text("Bundled map files, then your own");
    grid(ui, &library_cells.collect::<Vec<_>>(), light, actions);
    ui.horizontal(|ui| {
        if ui.button("Load...").on_hover_text("Light the scene with an .hdr or .exr file").clicked() {
            actions.push(Action::Environment(EnvironmentAction::Load(None)));
        }
        if ui.button("Add to library...").on_hover_text("Keep maps here for all scenes").clicked() {
            actions.push(Action::Environment(EnvironmentAction::AddToLibrary(None)));
        }
    });
}

/// The name before the numbers.
fn formula_of(spec: &str) -> &str {
    spec.split_once(':').map_or(spec, |(formula, _)| formula)
}

struct Cell<'a> {
    name: &'a str,
    spec: &'a str,
    selected: bool,
    missing: bool,
    thumbnail: Option<TextureId>,
}

fn grid(ui: &mut Ui, cells: &[Cell], light: &EnvironmentSettings, actions: &mut Vec<Action>) {
    let gap = ui.spacing().item_spacing.x;
    let columns = ((ui.available_width() + gap) / (CELL_WIDTH + gap)).floor().max(1.0);
    let width = (ui.available_width() + gap) / columns - gap;
    for row in cells.chunks(columns as usize) {
        ui.horizontal(|ui| {
            for cell in row {
                if show_cell(ui, cell, width).clicked() {
                    actions.extend(chosen(cell, light));
                }
            }
        });
    }
}

/// The actions of a click on a cell.
fn chosen(cell: &Cell, light: &EnvironmentSettings) -> Vec<Action> {
    if cell.missing {
        return vec![Action::File(FileAction::Relink(None))];
    }
    if cell.selected {
        return Vec::new();
    }
    let edit = Edit::Environment(light.with_map(cell.spec));
    vec![Action::Edit { edit, label: "Environment" }, Action::EndGesture]
}

fn show_cell(ui: &mut Ui, cell: &Cell, width: f32) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(width, 0.5 * width + NAME_HEIGHT), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, cell.selected, cell.name));
    if ui.is_rect_visible(rect) {
        paint_cell(ui, cell, rect, response.hovered());
    }
    if cell.missing {
        return response.on_hover_text(format!("File not found; click to locate it ({})", cell.spec));
    }
    response.on_hover_text(cell.spec)
}

fn paint_cell(ui: &Ui, cell: &Cell, rect: Rect, hovered: bool) {
    let painter = ui.painter_at(rect);
    let (picture, name) = rect.split_top_bottom_at_y(rect.bottom() - NAME_HEIGHT);
    painter.rect_filled(picture, 2.0, ui.visuals().extreme_bg_color);
    let tint = if cell.missing { Color32::from_gray(80) } else { Color32::WHITE };
    if let Some(texture) = cell.thumbnail {
        painter.image(texture, picture, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), tint);
    }
    let weak = ui.visuals().weak_text_color();
    if cell.missing {
        painter.text(picture.center(), Align2::CENTER_CENTER, "missing", TextStyle::Small.resolve(ui.style()), weak);
    }
    let stroke = match (cell.selected, hovered) {
        (true, _) => Stroke::new(2.0, ui.visuals().selection.bg_fill),
        (false, true) => ui.visuals().widgets.hovered.bg_stroke,
        (false, false) => Stroke::NONE,
    };
    painter.rect_stroke(picture, 2.0, stroke, StrokeKind::Inside);
    let color = if cell.selected { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
    let font = TextStyle::Small.resolve(ui.style());
    let mut text = egui::text::LayoutJob::simple_singleline(cell.name.into(), font, color);
    text.wrap = egui::text::TextWrapping::truncate_at_width(name.width());
    painter.galley(name.min + vec2(0.0, 2.0), ui.fonts_mut(|f| f.layout_job(text)), color);
}
