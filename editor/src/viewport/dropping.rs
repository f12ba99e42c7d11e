//! A preset or a material is dragged over the picture: the surface that would take it is outlined and named, and takes it
//! where it is let go.

use super::{ViewportContext, outline};
use crate::{
    actions::{Action, MaterialAction, SelectAction},
    bounds::part_bounds,
    document::{Document, Edit},
    dragged::Dragged,
};
use egui::{Align2, Color32, Context, DragAndDrop, Id, LayerId, Order, Rect, Response, TextStyle, Ui, Vec2, vec2};
use lapidary_core::{bounds::Bounds, material::Material, parts::Part};

/// Where the words lie beside the pointer, and the room around them, in points.
const BESIDE: Vec2 = vec2(16.0, 18.0);
const PADDING: Vec2 = vec2(6.0, 3.0);

/// What is dragged over the picture.
#[derive(Default)]
pub(super) struct Dropping {
    /// The surface under it.
    over: Option<Surface>,
    /// What it is and where it would go.
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
    /// Whether it alone takes what is dragged, and not all surfaces of its material.
    alone: bool,
    /// Finding them takes a pass over the mesh, so they are kept while the pointer stays on the surface.
    bounds: Option<Bounds>,
}

/// Follows what is dragged, and drops it where it is let go.
pub(super) fn handle(
    ui: &Ui,
    response: &Response,
    size_px: [u32; 2],
    state: &mut Dropping,
    context: &ViewportContext,
    actions: &mut Vec<Action>,
) {
    // Taken before it is looked at: egui forgets it at the end of the frame in which it is let go.
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

/// One step of undo, and the surface is selected.
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

/// Gives a part what is dragged as a material that other surfaces of its present one do not get.
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

/// Outlines and names the surface that would take what is dragged.
pub(super) fn paint(ui: &Ui, rect: Rect, state: &Dropping, context: &ViewportContext) {
    let bounds = state.over.and_then(|surface| surface.bounds);
    if let Some(bounds) = bounds {
        outline::paint(&ui.painter_at(rect), rect, &context.document.camera, bounds, context.accent);
    }
    if let Some(words) = &state.words {
        write_beside_pointer(ui.ctx(), words);
    }
}

/// What is dragged, and on what.
fn description(dragged: Dragged, over: Option<Surface>, context: &ViewportContext) -> String {
    let document = context.document;
    let name = dragged.name(document);
    match over {
        Some(Surface { part, alone: true, .. }) => format!("{name} on {} alone", document.part_name(part)),
        Some(Surface { part, .. }) => format!("{name} on {}", document.material_name(document.material_of(part))),
        None => name,
    }
}

/// Writes above all else.
fn write_beside_pointer(ctx: &Context, text: &str) {
    let Some(pointer) = ctx.pointer_latest_pos() else { return };
    let painter = ctx.layer_painter(LayerId::new(Order::Tooltip, Id::unique("dragged material")));
    let font = TextStyle::Small.resolve(&ctx.global_style());
    let galley = painter.layout_no_wrap(text.into(), font, Color32::from_gray(235));
    let place = Align2::LEFT_TOP.anchor_size(pointer + BESIDE, galley.size() + 2.0 * PADDING);
    painter.rect_filled(place, 4.0, Color32::from_black_alpha(190));
    painter.galley(place.min + PADDING, galley, Color32::PLACEHOLDER);
}
