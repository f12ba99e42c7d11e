//! Differences of both pictures: metrics, and the histogram of errors.

use super::{ComparisonPanel, Tool};
use crate::widgets::copyable;
use egui::{Color32, Rect, RichText, Sense, Ui, pos2, vec2};
use lapidary_render::compare::{Metrics, map::ErrorField};
use lapidary_studies::jobs::{comparison::TestPicture, measure::Measured};

/// Size of the histogram in points, and its bars.
const HISTOGRAM: egui::Vec2 = vec2(150.0, 34.0);
const BINS: usize = 50;
/// Width of the options in points.
const OPTIONS: f32 = 116.0;

/// Shows options, histogram and figures.
pub fn show(ui: &mut Ui, panel: &mut ComparisonPanel, measured: Option<&Measured>) {
    ui.horizontal_wrapped(|ui| {
        ui.vertical(|ui| {
            ui.set_max_width(OPTIONS);
            options(ui, panel);
        });
        if let Some(measured) = measured {
            histogram(ui, &measured.field);
            for (name, value, help) in texts(&measured.metrics, measured.noise).into_iter().chain(costs(&measured.test))
            {
                ui.vertical(|ui| {
                    ui.weak(RichText::new(name).small()).on_hover_text(help);
                    copyable(ui, RichText::new(value).monospace()).on_hover_text(help);
                });
            }
        }
    });
}

/// Names, values and meanings, the most telling first.
fn texts(metrics: &Metrics, noise: Option<f64>) -> Vec<(&'static str, String, &'static str)> {
    let percent = |value: f64| if value.is_finite() { format!("{:.2} %", 100.0 * value) } else { "infinite".into() };
    let mut texts = vec![(
        "Relative RMSE",
        percent(metrics.rel_rmse),
        "Root mean squared error, relative to the root mean square of the reference",
    )];
    if let Some(noise) = noise {
        texts.push((
            "Reference noise",
            percent(noise),
            "Noise of the reference, estimated from its two halves; more paths lower it",
        ));
    }
    let decibels = if metrics.psnr.is_finite() { format!("{:.1} dB", metrics.psnr) } else { "equal".into() };
    texts.extend([
        ("FLIP", format!("{:.4}", metrics.flip), "Mean difference seen when flipping between both pictures, 0 to 1"),
        ("SSIM", format!("{:.4}", metrics.ssim), "Structural similarity, 1 for equal pictures"),
        ("PSNR", decibels, "Peak signal-to-noise ratio of the pictures as displayed"),
        ("RMSE", format!("{:.4}", metrics.rmse), "Root of the mean squared error, scene-linear"),
        (
            "relMSE",
            format!("{:.5}", metrics.rel_mse),
            "Mean over the pixels of the squared error relative to the squared reference",
        ),
        ("Pixels", metrics.pixels.to_string(), "Number of compared pixels"),
    ]);
    texts
}

/// Cost of the picture with cuts, at comparison size.
fn costs(test: &TestPicture) -> [(&'static str, String, &'static str); 2] {
    let nodes = format!("{:.0}", test.stats.mean_merged_nodes);
    [
        ("Picture", format!("{:.0} ms", test.millis), "Render time of the picture with cuts, at comparison size"),
        ("Nodes", nodes, "Nodes of the merged cut per pixel"),
    ]
}

fn options(ui: &mut Ui, panel: &mut ComparisonPanel) {
    ui.checkbox(&mut panel.surfaces_only, "Surfaces only")
        .on_hover_text("Count the background as equal, so that it hides no error");
    ui.horizontal(|ui| {
        let drawing = matches!(panel.tool, Some(Tool::Region(_)));
        let help = "Drag a rectangle in the viewport to trace and measure only that part";
        if ui.selectable_label(drawing, "Region").on_hover_text(help).clicked() {
            panel.tool = if drawing { None } else { Some(Tool::Region(None)) };
        }
        if panel.region.is_some() && ui.button("Whole").on_hover_text("Trace and measure the whole picture").clicked() {
            panel.region = None;
        }
    });
}

/// Bars in the colors of the map, their heights by the logarithm of the counts: single wrong pixels stay visible.
fn histogram(ui: &mut Ui, field: &ErrorField) {
    let (rect, response) = ui.allocate_exact_size(HISTOGRAM, Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let counts = field.histogram(BINS);
    let height = |count: u32| (f64::from(count) + 1.0).ln() as f32;
    let highest = counts.iter().copied().map(height).fold(1e-6, f32::max);
    let width = rect.width() / BINS as f32;
    for (i, &count) in counts.iter().enumerate() {
        let left = rect.left() + i as f32 * width;
        let top = rect.bottom() - rect.height() * height(count) / highest;
        let bar = Rect::from_min_max(pos2(left, top), pos2(left + width - 0.5, rect.bottom()));
        painter.rect_filled(bar, 0.0, bar_color(field, (i as f32 + 0.5) / BINS as f32));
    }
    let ticks = field.ticks(1);
    response.on_hover_text(format!(
        "{} from {} to {}: number of pixels, on a logarithmic scale",
        field.title, ticks[0], ticks[1]
    ));
}

/// The map's color, but never as dark as the panel.
fn bar_color(field: &ErrorField, place: f32) -> Color32 {
    let color = field.kind.color(field.kind.error_at(place)).max(glam::Vec3::splat(0.28));
    let [r, g, b] = (color * 255.0).round().to_array().map(|v| v as u8);
    Color32::from_rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinite_figures_have_words() {
        let metrics = Metrics {
            rmse: 0.0,
            rel_rmse: f64::INFINITY,
            rel_mse: 0.0,
            psnr: f64::INFINITY,
            ssim: 1.0,
            flip: 0.0,
            pixels: 9,
            non_finite_pixels: 0,
        };
        let value = |name| texts(&metrics, Some(0.0123)).into_iter().find(|t| t.0 == name).unwrap().1;
        assert_eq!([value("Relative RMSE"), value("PSNR"), value("Reference noise")], ["infinite", "equal", "1.23 %"]);
        assert!(texts(&metrics, None).iter().all(|t| t.0 != "Reference noise"));
    }
}
