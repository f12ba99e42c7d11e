//! The nodes of a merged cut as a table that can be sorted.

use crate::widgets::units::grouped;
use egui::{Button, FontId, Grid, Label, RichText, Sense, Ui};
use lapidary_core::color::luminance;
use lapidary_render::{ExplainedNode, PixelExplanation};

/// Rows shown; further nodes hardly contribute.
const ROWS: usize = 50;
/// Size of the figures in points: seven columns fit a narrow panel.
const FIGURES: f32 = 10.0;

/// A column, by which rows can be sorted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Column {
    /// Share of the pixel's luminance.
    #[default]
    Share,
    /// Heap index.
    Node,
    /// Depth in the tree.
    Depth,
    /// Steradians.
    SolidAngle,
    /// Interpolated visibility.
    Visibility,
    /// Luminance of the mean radiance.
    Radiance,
    /// Luminance of BRDF times cosine.
    Brdf,
}

impl Column {
    const ALL: [Self; 7] =
        [Self::Share, Self::Node, Self::Depth, Self::SolidAngle, Self::Visibility, Self::Radiance, Self::Brdf];

    /// Heading and tooltip.
    fn heading(self) -> (&'static str, &'static str) {
        match self {
            Self::Share => ("%", "Share of the pixel's luminance"),
            Self::Node => ("node", "Index in the light tree: the root is 1, the children of i are 2i and 2i + 1"),
            Self::Depth => ("d", "Depth in the light tree"),
            Self::SolidAngle => ("sr", "Solid angle in steradians; for surface sources, the visible part"),
            Self::Visibility => ("vis", "Visibility, interpolated between the vertices"),
            Self::Radiance => ("L", "Luminance of the mean radiance"),
            Self::Brdf => ("f cos", "Luminance of BRDF times cosine"),
        }
    }

    fn value(self, node: &ExplainedNode) -> f32 {
        match self {
            Self::Share => luminance(node.contribution),
            Self::Node => node.heap_index as f32,
            Self::Depth => node.depth as f32,
            Self::SolidAngle => node.solid_angle,
            Self::Visibility => node.visibility,
            Self::Radiance => luminance(node.radiance),
            Self::Brdf => luminance(node.brdf_cos),
        }
    }

    fn text(self, node: &ExplainedNode, whole: f32) -> String {
        match self {
            Self::Share => format!("{:.1}", 100.0 * self.value(node) / whole),
            Self::Node => node.heap_index.to_string(),
            Self::Depth => node.depth.to_string(),
            _ => short(self.value(node)),
        }
    }
}

/// Three digits in at most six characters.
fn short(value: f32) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if v < 9.5e-4 => format!("{value:.0e}"),
        v if v < 9.95 => format!("{value:.3}"),
        v if v < 99.5 => format!("{value:.1}"),
        v if v < 9.5e4 => format!("{value:.0}"),
        _ => format!("{value:.1e}"),
    }
}

/// Sorting of the table, and the hovered row.
#[derive(Default)]
pub struct NodeTable {
    column: Column,
    ascending: bool,
    /// Position of a node in the explanation.
    pub hovered: Option<usize>,
}

impl NodeTable {
    /// Shows the first rows.
    pub fn show(&mut self, ui: &mut Ui, explanation: &PixelExplanation) {
        let order = self.sorted(explanation);
        let whole = luminance(explanation.radiance).max(f32::MIN_POSITIVE);
        let mut hovered = None;
        Grid::new("explained nodes")
            .num_columns(Column::ALL.len())
            .min_col_width(0.0)
            .spacing([7.0, 2.0])
            .striped(true)
            .show(ui, |ui| {
                self.headings(ui);
                for &i in order.iter().take(ROWS) {
                    for column in Column::ALL {
                        let text = RichText::new(column.text(&explanation.nodes[i], whole));
                        let text = text.font(FontId::monospace(FIGURES));
                        if ui.add(Label::new(text).selectable(false).sense(Sense::hover())).hovered() {
                            hovered = Some(i);
                        }
                    }
                    ui.end_row();
                }
            });
        if order.len() > ROWS {
            let rest = format!("and {} more", grouped((order.len() - ROWS) as u64));
            ui.label(RichText::new(rest).weak());
        }
        if hovered != self.hovered {
            self.hovered = hovered;
            ui.ctx().request_repaint();
        }
    }

    /// A click sorts by a column, the greatest first; another click reverses the order.
    fn headings(&mut self, ui: &mut Ui) {
        for column in Column::ALL {
            let (name, help) = column.heading();
            let chosen = column == self.column;
            let text = RichText::new(name).size(FIGURES);
            let text = if chosen { text.strong().underline() } else { text.weak() };
            let button = ui.add(Button::new(text).frame(false).small()).on_hover_text(help);
            if button.accessible_name(format!("Sort by {name}")).clicked() {
                (self.ascending, self.column) = (chosen && !self.ascending, column);
            }
        }
        ui.end_row();
    }

    fn sorted(&self, explanation: &PixelExplanation) -> Vec<usize> {
        let value = |i: usize| self.column.value(&explanation.nodes[i]);
        let mut order: Vec<usize> = (0..explanation.nodes.len()).collect();
        order.sort_by(|&a, &b| value(b).total_cmp(&value(a)));
        if self.ascending {
            order.reverse();
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short() {
        let shown = [0.0, 3e-5, 0.0123, 4.5678, 12.34, 1234.5, 3.2e6].map(short);
        assert_eq!(shown, ["0", "3e-5", "0.012", "4.568", "12.3", "1234", "3.2e6"]);
        assert!([1e-9, 0.99999, 99.9, 99_999.0, 1e30].map(short).iter().all(|text| text.len() <= 6));
    }
}
