//! Drags of a preset or material over the picture: outlines and names the surface under the pointer, which takes it when dropped.

use super::{ViewportContext, outline};
use crate::{
    actions::{Action, MaterialAction, SelectAction},
    bounds::part_bounds,
    document::{Document, Edit},
    dragged::Dragged,
};
use egui::{Align2, Color32, Context, DragAndDrop, Id, LayerId, Order, Rect, Response, TextStyle, Ui, Vec2, vec2};
use lapidary_core::{bounds::Bounds, material::Material, parts::Part};

/// Offset of the text from the pointer, and margin around it, in points.
const BESIDE: Vec2 = vec2(16.0, 18.0);
const PADDING: Vec2 = vec2(6.0, 3.0);

/// A drag over the picture.
#[derive(Default)]
pub(super) struct Dropping {
    /// The surface under it.
    over: Option<Surface>,
    /// Name of the dragged material, and its target.
    words: Option<String>,
}

#[cfg(test)]
impl Dropping {
    pub fn words(&self) -> Option<&str> {
        self.words.as_deref()
    }
}

/// A part of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Surface {
    part: Part,
    /// Whether only this part takes it, not all surfaces of its material.
    alone: bool,
    /// Kept while the pointer stays on the surface, since finding them takes a pass over the mesh.
    bounds: Option<Bounds>,
}

/// Follows the drag, and performs the drop.
pub(super) fn handle(
    ui: &Ui,
    response: &Response,
    size_px: [u32; 2],
    state: &mut Dropping,
    context: &ViewportContext,
    actions: &mut Vec<Action>,
) {
    // Taken first: egui forgets the payload at the end of the frame of the drop.
    let hovering = response.dnd_hover_payload::<Dragged>();
    let is_dropped = response.dnd_release_payload::<Dragged>().is_some();
    let pointer = ui.input(|input| input.pointer.latest_pos()).filter(|_| hovering.is_some());
    let camera = &context.document.camera;
    let picked = pointer.and_then(|at| context.picked(camera, at, response.rect, size_px));
    let alone = ui.input(|input| input.modifiers.shift);
    let over = picked.map(|picked| surface(state.over, context, picked.part(), alone));
    if is_dropped && let Some((dragged, surface)) = hovering.zip(over) {
        drop_on(context, *dragged, surface, actions);
    }
    state.over = over.filter(|_| !is_dropped);
    let dragged = DragAndDrop::payload::<Dragged>(ui.ctx());
    state.words = dragged.map(|dragged| description(*dragged, state.over, context));
}

fn surface(known: Option<Surface>, context: &ViewportContext, part: Part, alone: bool) -> Surface {
    let bounds = || context.mesh.and_then(|mesh| part_bounds(mesh, part));
    let is_ground = context.mesh.is_some_and(|mesh| mesh.ground_object() == Some(part.object));
    let bounds = known.filter(|known| known.part == part).map_or_else(bounds, |known| known.bounds);
    Surface { part, alone: alone && !is_ground, bounds }
}

/// Drops in one step of undo, and selects the surface.
fn drop_on(context: &ViewportContext, dragged: Dragged, surface: Surface, actions: &mut Vec<Action>) {
    let Surface { part, alone, .. } = surface;
    if alone {
        return actions.extend([
            Action::Select(SelectAction::Object(Some(part.object))),
            alone_on(part, dragged, context.document),
        ]);
    }
    let index = context.document.material_of(part);
    let target = context.document.materials.get(index);
    let Some(material) = target.and_then(|target| dragged.applied_to(target, context.document)) else { return };
    actions.push(Action::Select(SelectAction::Object(Some(part.object))));
    let edit = Edit::Material { index, material: Box::new(material) };
    actions.extend([Action::EndGesture, Action::Edit { edit, label: dragged.label() }, Action::EndGesture]);
    actions.extend([Action::Select(SelectAction::Material(Some(index))), Action::Select(SelectAction::Part(part))]);
}

/// Applies the drag to one part, not to other surfaces of its material.
fn alone_on(part: Part, dragged: Dragged, document: &Document) -> Action {
    match dragged {
        Dragged::Preset { .. } => {
            let present = document.materials.get(document.material_of(part));
            let applied = present.and_then(|present| dragged.applied_to(present, document));
            let named = |material| Material { name: dragged.name(document), ..material };
            Action::Material(MaterialAction::MakeUnique {
                part,
                material: applied.map(|material| named(material).into()),
            })
        }
        Dragged::Material(material) => Action::Material(MaterialAction::Assign { part, material }),
    }
}

/// Outlines and names the surface under the drag.
pub(super) fn paint(ui: &Ui, rect: Rect, state: &Dropping, context: &ViewportContext) {
    let bounds = state.over.and_then(|surface| surface.bounds);
    if let Some(bounds) = bounds {
        outline::paint(&ui.painter_at(rect), rect, &context.document.camera, bounds, context.accent);
    }
    if let Some(words) = &state.words {
        write_beside_pointer(ui.ctx(), words);
    }
}

/// The dragged material and its target, in words.
fn description(dragged: Dragged, over: Option<Surface>, context: &ViewportContext) -> String {
    let document = context.document;
    let name = dragged.name(document);
    match over {
        Some(Surface { part, alone: true, .. }) => format!("{name} on {} alone", document.part_name(part)),
        Some(Surface { part, .. }) => format!("{name} on {}", document.material_name(document.material_of(part))),
        None => name,
    }
}

/// Writes above everything else.
fn write_beside_pointer(ctx: &Context, text: &str) {
    let Some(pointer) = ctx.pointer_latest_pos() else { return };
    let painter = ctx.layer_painter(LayerId::new(Order::Tooltip, Id::unique("dragged material")));
    let font = TextStyle::Small.resolve(&ctx.global_style());
    let galley = painter.layout_no_wrap(text.into(), font, Color32::from_gray(235));
    let place = Align2::LEFT_TOP.anchor_size(pointer + BESIDE, galley.size() + 2.0 * PADDING);
    painter.rect_filled(place, 4.0, Color32::from_black_alpha(190));
    painter.galley(place.min + PADDING, galley, Color32::PLACEHOLDER);
}
