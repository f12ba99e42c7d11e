//! The origin of a pixel's radiance: the cuts of its vertices, the merged cut on the map of directions, its nodes as a
//! table, and the picture's error by causes.

mod map;
mod nodes;
mod split;
#[cfg(test)]
mod tests;

use crate::widgets::{copyable, section, units::grouped};
use egui::{Grid, RichText, Ui};
use glam::Vec3;
use lapidary_core::color::luminance;
use lapidary_render::{CutMap, ErrorSplit, PixelExplanation, TreeOf};
use std::sync::Arc;

/// Input of the panel.
#[derive(Clone, Copy, Default)]
pub struct ExplainContext<'a> {
    /// The pixel that was chosen.
    pub explanation: Option<&'a PixelExplanation>,
    /// Its merged cut, compared by address.
    pub map: Option<&'a Arc<CutMap>>,
    /// The last split of the picture's error.
    pub split: Option<&'a ErrorSplit>,
    /// Progress of a running split, 0 to 1.
    pub progress: Option<f32>,
    /// Why there is no explanation, if one was asked for.
    pub message: Option<&'a str>,
    /// Whether the picture has changed since.
    pub outdated: bool,
}

/// State of the panel between frames.
#[derive(Default)]
pub struct ExplainPanel {
    map: map::MapView,
    table: nodes::NodeTable,
}

/// A request of the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExplainRequest {
    /// Split the error of the picture.
    Split,
    /// Stop splitting.
    CancelSplit,
    /// Explain the same pixel of the picture as it is now.
    Again,
}

impl ExplainPanel {
    /// The node under the pointer, by its position among the explanation's nodes: for showing it elsewhere too.
    pub fn hovered_node(&self) -> Option<usize> {
        self.table.hovered
    }
}

/// Shows the panel. Returns its request.
pub fn show(ui: &mut Ui, panel: &mut ExplainPanel, context: &ExplainContext) -> Option<ExplainRequest> {
    let Some(explanation) = context.explanation else {
        panel.table.hovered = None;
        let text = context.message.unwrap_or("Choose a pixel in the picture to see where its light comes from.");
        ui.label(RichText::new(text).weak());
        return causes(ui, context);
    };
    let [x, y] = explanation.pixel;
    ui.label(RichText::new(format!("Pixel {x}, {y}")).strong());
    if let Some(message) = context.message {
        copyable(ui, RichText::new(message).color(ui.visuals().error_fg_color));
    }
    let again = context.outdated && outdated(ui);
    // Above the many nodes, since it answers the first question.
    let asked = causes(ui, context).or(again.then_some(ExplainRequest::Again));
    show_pixel(ui, panel, context, explanation);
    asked
}

/// Whether to explain again.
fn outdated(ui: &mut Ui) -> bool {
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new("The picture has changed since.").color(ui.visuals().warn_fg_color));
        ui.button("Explain again").clicked()
    })
    .inner
}

fn causes(ui: &mut Ui, context: &ExplainContext) -> Option<ExplainRequest> {
    section(ui, "Error by cause", true, |ui| split::show(ui, context.split, context.progress)).flatten()
}

fn show_pixel(ui: &mut Ui, panel: &mut ExplainPanel, context: &ExplainContext, explanation: &PixelExplanation) {
    section(ui, "Cuts", true, |ui| cuts(ui, explanation));
    if let Some(map) = context.map {
        let hovered = panel.table.hovered.and_then(|i| explanation.nodes.get(i));
        section(ui, "Merged cut", true, |ui| panel.map.show(ui, map, hovered));
    }
    section(ui, "Nodes", true, |ui| panel.table.show(ui, explanation));
}

/// Sizes of the merged cuts.
fn cuts(ui: &mut Ui, explanation: &PixelExplanation) {
    let nodes = |count: usize| format!("{} nodes", grouped(count as u64));
    let mut rows: Vec<(String, String)> = Vec::new();
    for vertex in explanation.vertices {
        let lit = vertex.lit_nodes.map_or(String::new(), |count| format!("{} lit of ", grouped(count as u64)));
        let value = format!("{lit}{}, weight {:.2}", nodes(vertex.cut_nodes), vertex.weight);
        rows.push((format!("Vertex {}", vertex.index), value));
    }
    let light = match explanation.tree {
        TreeOf::Environment => "Environment",
        TreeOf::Sources => "Bounced light",
    };
    if explanation.illumination_nodes > 0 {
        rows.push((light.into(), nodes(explanation.illumination_nodes)));
    }
    let dark = grouped(explanation.dark_nodes.len() as u64);
    rows.push(("Merged".into(), format!("{}, {dark} of them unlit", nodes(explanation.merged_nodes as usize))));
    rows.push(("Evaluated".into(), nodes(explanation.nodes.len())));
    let whole = luminance(explanation.radiance).max(f32::MIN_POSITIVE);
    for sun in &explanation.suns {
        rows.push(("Sun".into(), format!("{:.1} %, by rays", 100.0 * luminance(sun.contribution) / whole)));
    }
    if explanation.mirror != Vec3::ZERO {
        let share = 100.0 * luminance(explanation.mirror) / whole;
        rows.push(("Mirror".into(), format!("{share:.1} %, from the map instead of nodes")));
    }
    if explanation.has_rays {
        rows.push(("Mirror".into(), "shows the scene by rays, in place of this light around its direction".into()));
    }
    let [r, g, b] = explanation.radiance.to_array();
    rows.push(("Radiance".into(), format!("{r:.3}, {g:.3}, {b:.3}")));
    Grid::new("explained cuts").num_columns(2).show(ui, |ui| {
        for (name, value) in rows {
            ui.label(RichText::new(name).weak());
            copyable(ui, RichText::new(value).monospace());
            ui.end_row();
        }
    });
}
