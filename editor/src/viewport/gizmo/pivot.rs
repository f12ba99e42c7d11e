//! Placing of a pivot by a click: on an edge, which becomes a hinge, or on a surface.

use super::{View, edges::edge_at};
use crate::{document::handling::PlacedPivot, viewport::pick::Picked};
use egui::{Color32, Painter, Pos2, Shape, Stroke};
use glam::Vec3;
use lapidary_core::scene::Mesh;

/// Half the length of the line of a hinge, in points.
const HINGE_LINE: f32 = 160.0;

/// The place for a pivot under the pointer, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PivotPlace {
    /// The pivot.
    pub pivot: PlacedPivot,
    /// The edge under the pointer.
    edge: Option<[Vec3; 2]>,
}

impl PivotPlace {
    /// The place under the pointer; `None` over the background.
    pub fn at(view: &View, pointer: Pos2) -> Option<Self> {
        let (mesh, picked) = (view.context.mesh?, view.picked(pointer));
        match edge_under(view, mesh, pointer, picked) {
            Some(edge @ [a, b]) => {
                let pivot = PlacedPivot { point: on_edge(view, edge, pointer), hinge: (b - a).try_normalize() };
                Some(Self { pivot, edge: Some(edge) })
            }
            None => Some(Self { pivot: PlacedPivot { point: picked?.position, hinge: None }, edge: None }),
        }
    }

    /// Draws the place, the edge under it, and the line of the hinge beyond its ends.
    pub fn paint(&self, painter: &Painter, view: &View, accent: Color32) {
        let PlacedPivot { point, hinge } = self.pivot;
        let reach = HINGE_LINE * view.projection.metres_per_point(point).unwrap_or(0.0);
        let line = hinge.and_then(|hinge| view.projection.segment(point - reach * hinge, point + reach * hinge));
        if let Some(line) = line {
            painter.extend(Shape::dashed_line(&line, Stroke::new(1.5, accent), 6.0, 4.0));
        }
        for stroke in [Stroke::new(5.0, Color32::from_black_alpha(140)), Stroke::new(2.5, accent)] {
            let edge = self.edge.and_then(|[a, b]| view.projection.segment(a, b));
            edge.into_iter().for_each(|edge| _ = painter.line_segment(edge, stroke));
        }
        if let Some(at) = view.projection.point(self.pivot.point) {
            painter.circle(at, 5.0, accent, Stroke::new(1.5, Color32::from_black_alpha(200)));
        }
    }
}

fn edge_under(view: &View, mesh: &Mesh, pointer: Pos2, picked: Option<Picked>) -> Option<[Vec3; 2]> {
    let depth = picked.map(|picked| view.projection.depth(picked.position));
    let hidden: Vec<u32> = view.context.document.poses.hidden().collect();
    let is_shown =
        |triangle: usize| !mesh.is_ground(triangle as u32) && !hidden.contains(&mesh.triangle_object[triangle]);
    edge_at(mesh, &view.projection, pointer, depth, is_shown)
}

/// The point of an edge that is nearest to the ray through the pointer.
fn on_edge(view: &View, [a, b]: [Vec3; 2], pointer: Pos2) -> Vec3 {
    let along = (b - a).normalize_or(Vec3::X);
    let met = super::Constraint::Line(along).meet(a, view.projection.eye(), view.projection.direction(pointer));
    let length = met.map_or(0.0, |met| (met - a).dot(along));
    a + along * length.clamp(0.0, a.distance(b))
}
