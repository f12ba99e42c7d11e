//! What the last bake did: a table, the sizes of its cuts, and what it remarked.

use crate::panels::units::{bytes, duration, grouped};
use egui::{Grid, RichText, Ui};
use egui_plot::{Bar, BarChart, Plot};
use lapidary_core::dataset::BakeReport;
use lapidary_precompute::Phase;

/// Height of the histogram in points.
const PLOT_HEIGHT: f32 = 110.0;
const PHASES: [Phase; 6] =
    [Phase::Import, Phase::Tessellate, Phase::Pilot, Phase::Tree, Phase::Visibility, Phase::Pack];

/// Shows a report.
pub fn show(ui: &mut Ui, report: &BakeReport) {
    Grid::new("bake report").num_columns(2).striped(true).show(ui, |ui| {
        for (name, value) in rows(report) {
            ui.label(RichText::new(name).weak());
            ui.label(RichText::new(value).monospace());
            ui.end_row();
        }
    });
    if report.cut_size_histogram.iter().any(|count| *count > 0) {
        ui.add_space(4.0);
        ui.label(RichText::new("Nodes of the visibility cuts").weak());
        histogram(ui, &report.cut_size_histogram);
    }
    for warning in &report.warnings {
        ui.label(RichText::new(warning).color(ui.visuals().warn_fg_color));
    }
}

/// The table: names and values with units.
fn rows(report: &BakeReport) -> Vec<(String, String)> {
    let count = |n: usize| grouped(n as u64);
    let rows = vec![
        ("Vertices", format!("{} ({} points)", count(report.vertices), count(report.bake_points))),
        ("Triangles", count(report.triangles)),
        ("Lights", count(report.lights)),
        ("Mean cut", format!("{:.1} nodes", report.mean_cut)),
        ("Largest cut", format!("{} nodes", count(report.max_cut))),
        ("Sigma", report.sigma.to_string()),
        ("Visibility error", format!("{:.4} RMS", report.rms_visibility)),
        ("Cuts", bytes(report.bytes_cuts)),
        ("File", bytes(report.bytes_total)),
        ("Peak memory", bytes(report.peak_memory_bytes)),
        ("Speed", format!("{:.1} M pairs/s", report.samples_per_second / 1e6)),
    ];
    let mut rows: Vec<(String, String)> = rows.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    for phase in PHASES.iter().map(|p| p.name()).chain(["total"]) {
        if let Some(secs) = report.seconds.get(phase) {
            rows.push((format!("Time, {phase}"), duration(*secs)));
        }
    }
    rows
}

/// Bars over the powers of two; the pointer tells the range and the number of bake points.
fn histogram(ui: &mut Ui, counts: &[u64]) {
    let bars = counts.iter().enumerate().map(|(i, &n)| Bar::new(i as f64, n as f64).width(0.9).name(bar_text(i, n)));
    let chart = BarChart::new("Bake points", bars.collect()).element_formatter(Box::new(|bar, _| bar.name.clone()));
    let chart = chart.color(ui.visuals().selection.bg_fill);
    let plot = Plot::new("cut sizes")
        .height(PLOT_HEIGHT)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .allow_axis_zoom_drag(false)
        .show_grid([false, true])
        .show_axes([true, false])
        .x_grid_spacer(|input| {
            let (first, last) = (input.bounds.0.ceil() as i64, input.bounds.1.floor() as i64);
            let mark = |i: i64| egui_plot::GridMark { value: i as f64, step_size: 1.0 };
            (first..=last.min(first + 64)).map(mark).collect()
        })
        .x_axis_formatter(|mark, _| power_of_two(mark.value));
    plot.show(ui, |plot| plot.bar_chart(chart));
}

/// The label under a bar: its smallest cut.
fn power_of_two(exponent: f64) -> String {
    if (0.0..=20.0).contains(&exponent) { format!("{}", 1_u64 << exponent as u32) } else { String::new() }
}

fn bar_text(index: usize, points: u64) -> String {
    let low = 1_u64 << index.min(40);
    let range = if low == 1 { "1 node".into() } else { format!("{low} to {} nodes", 2 * low - 1) };
    format!("{range}: {} points", grouped(points))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_name_their_range() {
        assert_eq!(bar_text(0, 5), "1 node: 5 points");
        assert_eq!(bar_text(4, 12_345), "16 to 31 nodes: 12,345 points");
        assert_eq!([0.0, 7.0, -1.0].map(power_of_two), ["1", "128", ""]);
    }

    #[test]
    fn the_table_has_units_and_only_phases_that_ran() {
        let seconds = [("visibility".to_owned(), 12.0), ("total".to_owned(), 14.0)].into();
        let rows = rows(&BakeReport { mean_cut: 171.26, bytes_cuts: 9_250_000, seconds, ..Default::default() });
        let value = |name: &str| rows.iter().find(|r| r.0 == name).map(|r| r.1.as_str());
        assert_eq!(value("Mean cut"), Some("171.3 nodes"));
        assert_eq!(value("Cuts"), Some("9.2 MB"));
        assert_eq!(value("Time, visibility"), Some("12 s"));
        assert_eq!(value("Time, tree"), None);
    }
}
