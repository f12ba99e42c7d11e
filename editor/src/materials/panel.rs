//! The material inspector: a ball under the environment, the BRDF and its parameters, their maps, and the lobe.
//!
//! The panel works on a copy of the material and asks for one edit per frame if the copy differs.

mod brdf_file;
mod lobe_plot;
mod maps;
mod parameters;
mod patterns;
mod preset_balls;
mod preview_ball;
mod preview_worker;
mod studio;
mod surface;
mod target;
mod thumbnails;
mod transfer;

use crate::{
    actions::{Action, SelectAction},
    document::{Document, Edit},
    widgets::{Edited, Layers, check_row, section},
};
use egui::{Color32, ComboBox, Rect, Sense, Ui, pos2, vec2};
use lapidary_core::{
    material::{Material, map_color_space},
    parts::Part,
    texture::TextureSlot,
};
use lapidary_render::{EnvironmentLight, Post};
use lobe_plot::LobePlot;
use patterns::PatternThumbnails;
use preset_balls::PresetBalls;
use preview_ball::Ball;
use preview_worker::Preview;
use std::{collections::HashSet, sync::Arc};
use target::Target;
use thumbnails::Thumbnails;
use transfer::Copied;

/// Points of the preview's side.
const PREVIEW_SIDE: f32 = 128.0;
/// Gray of the placeholder disc of a ball, between background and text.
const PLACEHOLDER: Color32 = Color32::from_gray(72);

/// Input of the panel.
#[derive(Clone, Copy)]
pub struct MaterialContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// Its selected material, if any.
    pub selected: Option<usize>,
    /// The selected part of the scene, if any.
    pub part: Option<Part>,
    /// All parts that can be assigned other materials.
    pub parts: &'a [Part],
    /// The material of a ground, which no other surface has.
    pub ground: Option<usize>,
    /// Whether vertices have a second set of texture coordinates, and colors.
    pub has_second_uvs: bool,
    pub has_vertex_colors: bool,
    /// The environment's light, if it is in the picture.
    pub lighting: Option<&'a Arc<EnvironmentLight>>,
    /// Changes with the light.
    pub light_revision: u64,
}

/// State of the panel between frames.
#[derive(Default)]
pub struct MaterialPanel {
    copied: Option<Copied>,
    clear_maps: bool,
    /// Maps whose horizontal and vertical scale are edited separately.
    unlinked: HashSet<(usize, &'static str)>,
    thumbnails: Thumbnails,
    layers: Layers,
    patterns: PatternThumbnails,
    preview: Preview,
    presets: PresetBalls,
    plot: LobePlot,
}

impl MaterialPanel {
    /// Another document is open.
    pub fn forget_document(&mut self) {
        self.unlinked.clear();
        self.preview.forget();
    }
}

/// The material as edited in this frame.
struct Changes {
    material: Material,
    label: &'static str,
    ended: bool,
}

impl Changes {
    /// Records a row's edit; `label` is its name in undo.
    fn note(&mut self, label: &'static str, edited: Edited) {
        if edited.changed {
            self.label = label;
        }
        self.ended |= edited.ended;
    }

    /// A change that is complete at once.
    fn replace(&mut self, label: &'static str, material: Material) {
        self.material = material;
        self.note(label, Edited::at_once(true));
    }

    fn finish(self, index: usize, original: &Material, actions: &mut Vec<Action>) {
        if self.material != *original {
            let edit = Edit::Material { index, material: Box::new(self.material) };
            actions.push(Action::Edit { edit, label: self.label });
        }
        if self.ended {
            actions.push(Action::EndGesture);
        }
    }
}

/// A slot for a picture just loaded: with the usual settings of the map `kind`, and bumps of a millimeter.
pub fn new_slot(kind: &'static str, texture: u32) -> TextureSlot {
    let slot = TextureSlot { texture, color_space: map_color_space(kind), ..TextureSlot::default() };
    if kind == "bump" { TextureSlot { strength: 1e-3, ..slot } } else { slot }
}

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut MaterialPanel, context: &MaterialContext, actions: &mut Vec<Action>) {
    let materials = &context.document.materials;
    choose(ui, context, actions);
    surface::show(ui, context, actions);
    let Some((index, original)) = context.selected.and_then(|i| Some((i, materials.get(i)?))) else {
        ui.weak("Select a material here, or click a surface in the viewport.");
        return;
    };
    let mut changes = Changes { material: original.clone(), label: "Material", ended: false };
    transfer::show(ui, state, context.document, index, &mut changes, actions);
    ball(ui, state, context, index);
    section(ui, "Reflection", true, |ui| {
        if context.has_vertex_colors && changes.material.parameter_for("base_color").is_some() {
            vertex_colors(ui, &mut changes);
        }
        parameters::show(ui, state, context, index, &mut changes, actions);
    });
    section(ui, "Surface detail", true, |ui| {
        for kind in ["normal", "bump"] {
            maps::slot(ui, state, context, Target { index, kind }, &mut changes, actions);
        }
    });
    section(ui, "Lobe", false, |ui| state.plot.show(ui, &changes.material));
    changes.finish(index, original, actions);
}

fn vertex_colors(ui: &mut Ui, changes: &mut Changes) {
    let help = "The colors of the vertices multiply the base color.";
    let edited = check_row(ui, "Vertex colors", help, &mut changes.material.vertex_colors);
    changes.note("Vertex colors", edited);
}

/// Chooses the material.
fn choose(ui: &mut Ui, context: &MaterialContext, actions: &mut Vec<Action>) {
    let materials = &context.document.materials;
    let title = |i: usize| context.document.material_name(i);
    let current = context.selected.filter(|&i| i < materials.len());
    ui.horizontal(|ui| {
        let shown = current.map_or("No material".to_owned(), title);
        let width = ui.available_width() - 112.0;
        let combo = ComboBox::from_id_salt("material").selected_text(shown).width(width).truncate();
        let opened = combo.show_ui(ui, |ui| {
            for i in 0..materials.len() {
                if ui.selectable_label(current == Some(i), title(i)).clicked() {
                    actions.push(Action::Select(SelectAction::Material(Some(i))));
                }
            }
        });
        opened.response.accessible_name("Material");
        let which = current.map_or(String::new(), |i| format!("{} of ", i + 1));
        ui.weak(format!("{which}{}", materials.len()));
        if let Some(index) = current {
            transfer::solo(ui, context.document, index, actions);
        }
    });
}

/// The material on a ball under the environment, or under a studio's light if no environment is in the picture.
fn ball(ui: &mut Ui, state: &mut MaterialPanel, context: &MaterialContext, index: usize) {
    let (rect, place) = ui.allocate_exact_size(vec2(ui.available_width(), PREVIEW_SIDE + 8.0), Sense::hover());
    ui.painter().rect_filled(rect, 4.0, Color32::from_gray(52));
    let post = context.document.view.post;
    let (lighting, post, where_) = match context.lighting {
        Some(lighting) => (Some(lighting.clone()), post, "Under the environment"),
        // The exposure of the view suits other lights.
        None => (
            studio::light(),
            Post { exposure: 0.0, ..post },
            "Under studio light, since no environment is in the picture",
        ),
    };
    place.on_hover_text(where_);
    let Some(lighting) = lighting else { return };
    let textures = context.document.shared_textures();
    let ball = Ball { material: context.document.materials[index].clone(), textures, lighting };
    let size = (PREVIEW_SIDE * ui.pixels_per_point()).round().clamp(64.0, 256.0) as u32;
    match state.preview.picture(ui.ctx(), index, ball, context.light_revision, post, size) {
        Some(picture) => {
            let at = Rect::from_center_size(rect.center(), vec2(PREVIEW_SIDE, PREVIEW_SIDE));
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(picture.id(), at, whole, Color32::WHITE);
        }
        None => {
            ui.painter().circle_filled(rect.center(), 0.5 * PREVIEW_SIDE / preview_ball::MARGIN, PLACEHOLDER);
        }
    }
}

#[cfg(test)]
mod tests;
