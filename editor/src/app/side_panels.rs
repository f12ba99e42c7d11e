//! The panels at both sides of the picture. Only the user changes their widths; contents and tabs do not. In a narrow window each
//! is a strip of icons, which open it over the picture.

use super::icons::{self, Icon};
use crate::{
    preferences::{INSPECTOR_WIDTHS, SIDE_WIDTHS},
    workspace::{Inspector, Side},
};
use egui::{
    Area, Button, Context, CursorIcon, Frame, Id, Margin, Order, Panel, Rangef, Rect, Sense, Stroke, Ui, UiBuilder,
    vec2,
};

/// Windows narrower than this many points have strips.
const NARROW: f32 = 1100.0;
/// Width of a strip in points, and of its buttons.
const STRIP: f32 = 40.0;
const BUTTON: f32 = 30.0;
/// Least width of the picture between both panels in points.
const LEAST_PICTURE: f32 = 320.0;
/// Points beside an edge where a drag begins: the panel's margin, and little of the picture, which takes clicks too.
const GRIP: [f32; 2] = [7.0, 2.0];

/// A side of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// Scene and library.
    Left,
    /// The inspector.
    Right,
}

impl Edge {
    /// Both of them.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// Least and greatest width of the panel in points.
    fn widths(self) -> Rangef {
        let [min, max] = if self == Self::Left { SIDE_WIDTHS } else { INSPECTOR_WIDTHS };
        Rangef { min, max }
    }

    fn id(self) -> Id {
        Id::unique(self.name())
    }

    fn name(self) -> &'static str {
        match self {
            Self::Left => "side",
            Self::Right => "inspector",
        }
    }

    fn panel(self, width: f32) -> Panel {
        let panel = match self {
            Self::Left => Panel::left(self.name()),
            Self::Right => Panel::right(self.name()),
        };
        panel.resizable(false).exact_size(width)
    }
}

/// State of the panels between frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SidePanels {
    /// Widths in points that the user chose, left and right.
    pub widths: [f32; 2],
    /// Whether an edge is dragged.
    pub is_dragged: bool,
}

impl SidePanels {
    /// With the widths of the last run.
    pub fn new(widths: [f32; 2]) -> Self {
        Self { widths, is_dragged: false }
    }

    /// Widths that fit `room`: the inspector shrinks first, then the left side.
    fn fitted(&self, room: f32) -> [f32; 2] {
        let [left, right] = self.widths;
        let room = room - LEAST_PICTURE;
        let right = right.min((room - left).max(Edge::Right.widths().min));
        [left.min((room - right).max(Edge::Left.widths().min)), right]
    }
}

/// Whether the window is too narrow for panels.
pub fn are_strips(ctx: &Context) -> bool {
    ctx.content_rect().width() < NARROW
}

/// Shows the panel at an edge in a window that has room for it.
pub fn column<R>(ui: &mut Ui, edge: Edge, panels: &SidePanels, room: f32, contents: impl FnOnce(&mut Ui) -> R) -> Rect {
    let width = panels.fitted(room)[edge as usize];
    let fixed = |ui: &mut Ui| {
        // Reporting contents wider than the panel would move its edges.
        let inside = ui.max_rect();
        contents(&mut ui.new_child(UiBuilder::new().max_rect(inside)))
    };
    edge.panel(width).show(ui, fixed).response.rect
}

/// Lets the user drag the edge of a panel that lies in `rect`. Returns whether a drag has ended. Call it after the panel's neighbor
/// is shown.
pub fn drag_edge(ui: &Ui, edge: Edge, panels: &mut SidePanels, rect: Rect) -> bool {
    let x = if edge == Edge::Left { rect.right() } else { rect.left() };
    let [inward, outward] = GRIP;
    let grip = if edge == Edge::Left { x - inward..=x + outward } else { x - outward..=x + inward };
    let grip = Rect::from_x_y_ranges(grip, rect.y_range());
    let grip = ui.interact(grip, edge.id().with("edge"), Sense::drag());
    let grip = grip.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if let Some(pointer) = grip.interact_pointer_pos().filter(|_| grip.dragged()) {
        let width = if edge == Edge::Left { pointer.x - rect.left() } else { rect.right() - pointer.x };
        panels.widths[edge as usize] = edge.widths().clamp(width.round());
        ui.ctx().request_repaint();
    }
    if grip.hovered() || grip.dragged() {
        ui.painter().vline(x, rect.y_range(), Stroke::new(2.0, ui.visuals().selection.bg_fill));
    }
    panels.is_dragged |= grip.dragged();
    grip.drag_stopped()
}

/// Shows the strip of an edge: one button for each tab, which opens the panel there, or closes it if it shows that tab.
pub fn strip<T: Copy + PartialEq>(
    ui: &mut Ui,
    edge: Edge,
    open: &mut bool,
    chosen: &mut T,
    tabs: &[(T, &str, Icon)],
) -> Rect {
    let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(4, 6));
    let strip = edge.panel(STRIP).frame(frame).show(ui, |ui| {
        for &(tab, name, icon) in tabs {
            let is_shown = *open && *chosen == tab;
            let button = Button::selectable(is_shown, "").min_size(vec2(BUTTON, BUTTON));
            let button = ui.add(button).on_hover_text(name).accessible_name(name);
            icons::paint(
                ui.painter(),
                button.rect,
                icon,
                ui.style().interact_selectable(&button, is_shown).text_color(),
            );
            if button.clicked() {
                (*open, *chosen) = (!is_shown, tab);
            }
        }
    });
    strip.response.rect
}

/// Shows a panel over the picture, beside its strip, in the room between `picture`'s edges.
pub fn unfolded(ctx: &Context, edge: Edge, panels: &SidePanels, picture: Rect, contents: impl FnOnce(&mut Ui)) {
    let width = panels.fitted(picture.width())[edge as usize];
    let rect = match edge {
        Edge::Left => picture.with_max_x(picture.left() + width),
        Edge::Right => picture.with_min_x(picture.right() - width),
    };
    let area = Area::new(edge.id().with("unfolded")).order(Order::Middle).fixed_pos(rect.min);
    let area = area.constrain(false).fade_in(false).sense(Sense::click_and_drag()).default_size(rect.size());
    area.show(ctx, |ui| {
        ui.allocate_exact_size(rect.size(), Sense::hover());
        ui.painter().rect(rect, 0.0, ui.visuals().panel_fill, ui.visuals().window_stroke, egui::StrokeKind::Inside);
        let mut inside = ui.new_child(UiBuilder::new().max_rect(rect.shrink2(vec2(8.0, 4.0))));
        inside.shrink_clip_rect(rect);
        contents(&mut inside);
    });
}

/// The icon of a tab of the inspector.
pub fn icon_of(tab: Inspector) -> Icon {
    match tab {
        Inspector::Material => Icon::Material,
        Inspector::Environment => Icon::Environment,
        Inspector::Lights => Icon::Lights,
        Inspector::View => Icon::View,
        Inspector::Bake => Icon::Bake,
    }
}

/// The icon of a tab of the left side.
pub fn icon_of_side(tab: Side) -> Icon {
    match tab {
        Side::Scene => Icon::Scene,
        Side::Looks => Icon::Looks,
        Side::Library => Icon::Library,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_give_way_to_the_picture_and_no_further_than_they_may() {
        let panels = SidePanels::new([480.0, 640.0]);
        assert_eq!(panels.fitted(2000.0), [480.0, 640.0]);
        assert_eq!(panels.fitted(1300.0), [480.0, 500.0]);
        assert_eq!(panels.fitted(1060.0), [460.0, 280.0]);
        assert_eq!(panels.fitted(500.0), [160.0, 280.0]);
        assert_eq!(SidePanels::new([230.0, 340.0]).fitted(NARROW), [230.0, 340.0], "as they come");
    }
}
