//! The row of a texture map: thumbnail, file, placement and encoding.

use super::{Changes, MaterialContext, MaterialPanel, patterns, target::Target};
use crate::{
    actions::Action,
    document::TextureEntry,
    widgets::{
        Edited, Number, check_row, choice_row,
        entries::{GIVEN_SPACES, combo_row},
        group, slider_row, wide_row,
    },
};
use egui::{
    Align, Button, CollapsingHeader, Label, Layout, Rect, Response, RichText, Sense, Stroke, StrokeKind, TextureHandle,
    Ui, vec2,
};
use lapidary_core::{
    brdf::{BrdfModel, Parameter},
    texture::{Channel, ColorSpace, Texels, TextureSlot, UvSet, Wrap},
};
use std::path::PathBuf;

/// Side of a thumbnail in points.
const THUMBNAIL: f32 = 26.0;
/// Side of the empty frame in points: rows without a map take little room.
const EMPTY: f32 = 16.0;

/// Shows the row of a map, and its settings below if there is a picture.
pub fn slot(
    ui: &mut Ui,
    state: &mut MaterialPanel,
    context: &MaterialContext,
    target: Target,
    changes: &mut Changes,
    actions: &mut Vec<Action>,
) {
    let name = target.name();
    group(ui, &name, |ui| {
        let entry = changes.material.maps.get(target.kind);
        let entry = entry.and_then(|slot| context.document.textures.get(slot.image()?));
        let shown = picture_row(ui, state, target, entry, changes, actions);
        if let Some(path) = dropped_on(ui, shown.rect) {
            target.load(Some(path), actions);
        }
        let file = entry.and_then(|entry| context.document.file_of(entry));
        if let Some(path) = file.and_then(|file| state.layers.row(ui, &file)) {
            target.load(Some(path), actions);
        }
        if changes.material.maps.get(target.kind).is_some() {
            settings(ui, state, context, target, changes);
        }
    });
}

/// The picture and the buttons, each in its own place: the button that removes is never where a click has just loaded.
fn picture_row(
    ui: &mut Ui,
    state: &mut MaterialPanel,
    target: Target,
    entry: Option<&TextureEntry>,
    changes: &mut Changes,
    actions: &mut Vec<Action>,
) -> Response {
    let name = target.name();
    let is_there = changes.material.maps.get(target.kind).is_some();
    let pattern = changes.material.maps.get(target.kind).and_then(|slot| slot.procedural);
    let picture = |ui: &mut Ui| {
        let handle = match (&pattern, entry) {
            (Some(pattern), _) => Some(state.patterns.of(ui.ctx(), pattern)),
            (None, Some(entry)) => Some(state.thumbnails.of(ui.ctx(), &entry.texture).clone()),
            (None, None) => None,
        };
        thumbnail(ui, handle);
        let (shown, full) = match &pattern {
            Some(pattern) => (pattern.pattern.label().into(), "A procedural pattern".to_owned()),
            None => caption(&name, entry),
        };
        ui.add(Label::new(shown).truncate()).on_hover_text(full);
    };
    let choose = |ui: &mut Ui| {
        let verb = if is_there { "Swap" } else { "Load" };
        let hint = "Choose a png, jpg, tif, webp, ktx2, tga, hdr or exr file, or drop one on this row.";
        // From the right, so that the button takes the width that the menu leaves.
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            patterns::menu(ui, target, changes, actions);
            let button = Button::new(format!("{verb}…")).small().min_size(vec2(ui.available_width(), 0.0));
            if ui.add(button).on_hover_text(hint).accessible_name(format!("{verb} {name}")).clicked() {
                target.load(None, actions);
            }
        });
    };
    let remove = |ui: &mut Ui| {
        let button = Button::new("×").frame(false);
        is_there && {
            let button = ui.add(button).on_hover_text("Remove this map");
            button.accessible_name(format!("Remove {name}")).clicked()
        }
    };
    let height = if entry.is_some() || pattern.is_some() { THUMBNAIL } else { EMPTY };
    let row = wide_row(ui, height, picture, choose, remove);
    if row.inner {
        changes.material.maps.set(target.kind, None);
        changes.note("Remove map", Edited::at_once(true));
    }
    row.response
}

/// Text beside a thumbnail, and its tooltip.
fn caption(name: &str, entry: Option<&TextureEntry>) -> (RichText, String) {
    let Some(entry) = entry else {
        let hint = format!("No {}: the value above applies everywhere.", lower_first(name));
        return (RichText::new(format!("No {}", lower_first(name))).weak(), hint);
    };
    let [w, h] = entry.texture.size;
    let path = entry.file.as_ref().map_or(entry.texture.name.clone(), |f| f.display().to_string());
    let file = path.rsplit(['/', '\\']).next().unwrap_or(&path).to_owned();
    (RichText::new(file), format!("{w} x {h} texels\n{path}"))
}

/// For the middle of a sentence; an abbreviation stays as it is.
fn lower_first(name: &str) -> String {
    if name.chars().take(2).all(char::is_uppercase) {
        return name.to_owned();
    }
    name.chars().take(1).flat_map(char::to_lowercase).chain(name.chars().skip(1)).collect()
}

fn thumbnail(ui: &mut Ui, picture: Option<TextureHandle>) {
    let side = if picture.is_some() { THUMBNAIL } else { EMPTY };
    let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    let Some(picture) = picture else {
        let stroke = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.5));
        ui.painter().rect_stroke(rect.shrink(1.0), 2.0, stroke, StrokeKind::Inside);
        return;
    };
    let size = picture.size_vec2() * (THUMBNAIL / picture.size_vec2().max_elem());
    let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    let at = Rect::from_center_size(rect.center(), size);
    ui.painter().image(picture.id(), at, whole, egui::Color32::WHITE);
    let large =
        egui::load::SizedTexture::new(picture.id(), picture.size_vec2() * (160.0 / picture.size_vec2().max_elem()));
    response.on_hover_ui(|ui| {
        ui.image(large);
    });
}

/// The file dropped on `rect`, if any; marks the row while a file hovers.
pub fn dropped_on(ui: &Ui, rect: Rect) -> Option<PathBuf> {
    if !ui.rect_contains_pointer(rect) {
        return None;
    }
    if ui.input(|i| !i.raw.hovered_files.is_empty()) {
        let stroke = Stroke::new(2.0, ui.visuals().selection.bg_fill);
        ui.painter().rect_stroke(rect.expand(2.0), 3.0, stroke, StrokeKind::Outside);
    }
    // Taken, so that the window does not open the picture as a scene.
    let dropped = ui.ctx().input_mut(|i| std::mem::take(&mut i.raw.dropped_files));
    dropped.first().map(|file| file.path().to_path_buf())
}

fn settings(ui: &mut Ui, state: &mut MaterialPanel, context: &MaterialContext, target: Target, changes: &mut Changes) {
    let Some(mut slot) = changes.material.maps.get(target.kind).cloned() else { return };
    let entry = slot.image().and_then(|image| context.document.textures.get(image));
    match target.kind {
        "normal" => normal_strength(ui, &mut slot, changes),
        "bump" => bump_strength(ui, &mut slot, changes),
        _ => {}
    }
    if let Some(pattern) = &mut slot.procedural {
        patterns::controls(ui, target.kind, pattern, changes);
    }
    let title = RichText::new("Placement").small();
    let folded = CollapsingHeader::new(title).id_salt((target.index, target.kind)).show(ui, |ui| {
        placement(ui, state, target, &mut slot, changes);
        if slot.procedural.is_none() {
            wrap(ui, &mut slot, changes);
        }
        if context.has_second_uvs {
            uv_set(ui, &mut slot, changes);
        }
        reading(ui, target.kind, entry, &mut slot, changes);
    });
    folded.header_response.accessible_name(format!("{} placement", target.name()));
    changes.material.maps.set(target.kind, Some(slot));
}

fn normal_strength(ui: &mut Ui, slot: &mut TextureSlot, changes: &mut Changes) {
    let help = "Steepness of the normals, 0 (flat) to 2 (twice as steep); type up to 10.";
    let row = Number::new("Strength", help, 0.0..=2.0, 1.0).entry(-10.0..=10.0);
    changes.note("Normal strength", slider_row(ui, &row, &mut slot.strength));
    let help = "For normal maps made for DirectX, whose green channel points down. If bumps look like dents, try this.";
    changes.note("Flip Y", check_row(ui, "Flip Y (DirectX)", help, &mut slot.flip_y));
}

/// Heights are in millimeters; inverting is a sign, which a height of zero keeps too.
fn bump_strength(ui: &mut Ui, slot: &mut TextureSlot, changes: &mut Changes) {
    let mut inverted = slot.strength.is_sign_negative();
    let mut height = slot.strength.abs() * 1000.0;
    let help = "Height of white above black in millimeters, 0 to 10; type up to 1,000.";
    let row = Number::new("Height", help, 0.0..=10.0, 1.0).unit(" mm", 2).entry(0.0..=1000.0);
    let edited = slider_row(ui, &row, &mut height);
    let help = "White is low and black is high.";
    let turned = check_row(ui, "Invert", help, &mut inverted);
    if edited.changed || turned.changed {
        let sign = if inverted { -1.0 } else { 1.0 };
        slot.strength = sign * height / 1000.0;
    }
    changes.note("Bump height", edited);
    changes.note("Invert bumps", turned);
}

/// Scale, offset and rotation.
fn placement(ui: &mut Ui, state: &mut MaterialPanel, target: Target, slot: &mut TextureSlot, changes: &mut Changes) {
    let key = (target.index, target.kind);
    let mut linked = slot.scale.x == slot.scale.y && !state.unlinked.contains(&key);
    let scale = |label| {
        let help = "Repetitions of the picture across the unit square of texture coordinates; negative mirrors it.";
        Number::new(label, help, 0.1..=20.0, 1.0).entry(-1000.0..=1000.0)
    };
    if linked {
        let edited = slider_row(ui, &scale("Scale"), &mut slot.scale.x);
        if edited.changed {
            slot.scale.y = slot.scale.x;
        }
        changes.note("Map scale", edited);
    } else {
        changes.note("Map scale", slider_row(ui, &scale("Scale X"), &mut slot.scale.x));
        changes.note("Map scale", slider_row(ui, &scale("Scale Y"), &mut slot.scale.y));
    }
    if check_row(ui, "Link X and Y", "Scale both directions equally.", &mut linked).changed {
        if linked {
            state.unlinked.remove(&key);
            slot.scale.y = slot.scale.x;
            changes.note("Map scale", Edited::at_once(true));
        } else {
            state.unlinked.insert(key);
        }
    }
    let help = "Shift of the coordinates in repetitions, -1 to 1; type for more.";
    let offset = |label| Number::new(label, help, -1.0..=1.0, 0.0).unit("", 3).entry(-100.0..=100.0);
    changes.note("Map offset", slider_row(ui, &offset("Offset X"), &mut slot.offset.x));
    changes.note("Map offset", slider_row(ui, &offset("Offset Y"), &mut slot.offset.y));
    rotation(ui, slot, changes);
}

fn rotation(ui: &mut Ui, slot: &mut TextureSlot, changes: &mut Changes) {
    let mut degrees = slot.rotation.to_degrees();
    let help = "Counter-clockwise turn of the coordinates in degrees, before the offset; -180 to 180.";
    let row = Number::new("Rotation", help, -180.0..=180.0, 0.0).unit("°", 1).entry(-360.0..=360.0);
    let edited = slider_row(ui, &row, &mut degrees);
    if edited.changed {
        slot.rotation = degrees.to_radians();
    }
    changes.note("Map rotation", edited);
}

/// What coordinates outside 0 to 1 show.
fn wrap(ui: &mut Ui, slot: &mut TextureSlot, changes: &mut Changes) {
    let choices = [
        (Wrap::Repeat, Wrap::Repeat.label(), "The picture again."),
        (Wrap::Mirror, Wrap::Mirror.label(), "The picture again, every other one mirrored."),
        (Wrap::Clamp, Wrap::Clamp.label(), "The color at its edge."),
    ];
    for (label, wrap) in ["Wrap X", "Wrap Y"].into_iter().zip(&mut slot.wrap) {
        let help = "What is shown beyond the edges of the picture.";
        changes.note("Map wrap", choice_row(ui, label, help, wrap, &choices));
    }
}

fn uv_set(ui: &mut Ui, slot: &mut TextureSlot, changes: &mut Changes) {
    let choices = [
        (UvSet::First, "First", "TEXCOORD_0 of glTF."),
        (
            UvSet::Second,
            "Second",
            "TEXCOORD_1 of glTF. A normal map is turned with the set that the file names for it.",
        ),
    ];
    let help = "The texture coordinates of the surface that place the picture.";
    changes.note("Map UV set", choice_row(ui, "UV set", help, &mut slot.uv_set, &choices));
}

/// Channel and color space, if the map has a choice.
fn reading(
    ui: &mut Ui,
    kind: &'static str,
    entry: Option<&TextureEntry>,
    slot: &mut TextureSlot,
    changes: &mut Changes,
) {
    if !BrdfModel::declared(kind).is_some_and(Parameter::is_color) && kind != "normal" {
        let channels = [
            (Channel::R, "R", "Red. Gray pictures have their value here."),
            (Channel::G, "G", "Green: the roughness in packed glTF pictures."),
            (Channel::B, "B", "Blue: the metalness in packed glTF pictures."),
            (Channel::A, "A", "Alpha."),
        ];
        let help = "Picture channel to read.";
        changes.note("Map channel", choice_row(ui, "Channel", help, &mut slot.channel, &channels));
    }
    if matches!(kind, "normal" | "bump") || slot.procedural.is_some() {
        return;
    }
    let help = "How texels are read: sRGB for colors, linear for values such as roughness.";
    let mut spaces = spaces_of_file(entry.map(|entry| &entry.texture.texels), slot.color_space);
    // A file of materials may give one to a map of values too.
    let is_color = BrdfModel::declared(kind).is_some_and(Parameter::is_color);
    spaces.extend(GIVEN_SPACES.into_iter().filter(|(space, ..)| is_color || *space == slot.color_space));
    changes.note("Map color space", combo_row(ui, "Color space", help, &mut slot.color_space, &spaces));
}

/// What the texels can be by what their file says.
fn spaces_of_file(texels: Option<&Texels>, now: ColorSpace) -> Vec<(ColorSpace, &'static str, &'static str)> {
    let linear = (ColorSpace::Linear, "Linear", "Texels are the values: roughness, metalness.");
    match texels {
        // Both are the same.
        Some(Texels::F32(_)) => {
            let plain = if now == ColorSpace::Srgb { ColorSpace::Srgb } else { ColorSpace::Linear };
            vec![(plain, "Linear", "Texels are the values; colors are in Rec. 709.")]
        }
        Some(Texels::Wide { .. }) => {
            vec![(ColorSpace::Srgb, "Color", "Colors, converted from the primaries that the picture names."), linear]
        }
        _ => vec![(ColorSpace::Srgb, "sRGB", "Texels are sRGB encoded: colors."), linear],
    }
}
