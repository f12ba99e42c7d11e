//! The gate: the viewport takes the shape of the pictures that are delivered, so that it shows all of them and nothing else, and
//! lines where parts of it are safe.

use egui::{Align2, Color32, FontId, Painter, Rect, Stroke, StrokeKind, vec2};

/// Shapes of pictures as width over height, with their names and what they are for.
pub const SHAPES: [(Option<f32>, &str, &str); 10] = [
    (None, "As the window", "The picture fills the viewport"),
    (Some(16.0 / 9.0), "16:9", "Television, computers"),
    (Some(1.85), "1.85", "Cinema, flat"),
    (Some(2.39), "2.39", "Cinema, wide"),
    (Some(3.0 / 2.0), "3:2", "Photographs"),
    (Some(4.0 / 3.0), "4:3", "Tablets"),
    (Some(1.0), "1:1", "Square"),
    (Some(4.0 / 5.0), "4:5", "Portrait"),
    (Some(2.0 / 3.0), "2:3", "Portrait photographs"),
    (Some(9.0 / 16.0), "9:16", "Phones"),
];
/// Parts of the picture in which action and titles are safe, as shares of its sides (EBU R 95).
const SAFE: [(f32, &str); 2] = [(0.93, "Action safe"), (0.9, "Title safe")];

/// The largest rectangle of a shape in the middle of `room`, or all of it.
pub fn gate(room: Rect, aspect: Option<f32>) -> Rect {
    let Some(aspect) = aspect else { return room };
    let width = room.width().min(aspect * room.height());
    Rect::from_center_size(room.center(), vec2(width, width / aspect)).intersect(room)
}

/// Draws the safe parts of the picture.
pub fn paint_safe(painter: &Painter, rect: Rect) {
    for (share, name) in SAFE {
        let safe = Rect::from_center_size(rect.center(), share * rect.size());
        for (stroke, grow) in [
            (Stroke::new(1.0, Color32::from_black_alpha(140)), 1.0),
            (Stroke::new(1.0, Color32::from_white_alpha(170)), 0.0),
        ] {
            painter.rect_stroke(safe.expand(grow), 0.0, stroke, StrokeKind::Middle);
        }
        let font = FontId::proportional(10.0);
        painter.text(
            safe.left_bottom() + vec2(4.0, -2.0),
            Align2::LEFT_BOTTOM,
            name,
            font,
            Color32::from_white_alpha(190),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn a_gate_has_its_shape_and_touches_two_sides() {
        let room = Rect::from_min_size(pos2(100.0, 20.0), vec2(800.0, 600.0));
        assert_eq!(gate(room, None), room);
        for aspect in [2.39, 16.0 / 9.0, 1.0, 9.0 / 16.0] {
            let found = gate(room, Some(aspect));
            assert!(
                (found.aspect_ratio() / aspect - 1.0).abs() < 1e-3 && room.contains_rect(found),
                "{aspect}: {found}"
            );
            assert!(
                found.width() == room.width() || (found.height() - room.height()).abs() < 1e-3,
                "{aspect}: {found}"
            );
            assert_eq!(found.center(), room.center());
        }
    }
}
