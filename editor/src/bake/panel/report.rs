//! What the last bake did: a table, the sizes of its cuts, and what it remarked.

use super::progress::described;
use crate::widgets::{
    copyable,
    units::{bytes, duration, grouped},
};
use egui::{Grid, RichText, Ui};
use egui_plot::{Bar, BarChart, Plot};
use lapidary_core::dataset::{BakeAudit, BakeReport, BakeRun, BakeSettings, sigma_text};
use lapidary_precompute::Phase;

/// Height of the histogram in points.
const PLOT_HEIGHT: f32 = 110.0;

/// Shows the report of a bake with these settings.
pub fn show(ui: &mut Ui, report: &BakeReport, settings: &BakeSettings) {
    Grid::new("bake report").num_columns(2).striped(true).show(ui, |ui| {
        for (name, value) in rows(report, settings) {
            ui.label(RichText::new(name).weak());
            copyable(ui, RichText::new(value).monospace());
            ui.end_row();
        }
    });
    if report.mode.environment() && report.cut_size_histogram.iter().any(|count| *count > 0) {
        ui.add_space(4.0);
        ui.label(RichText::new("Nodes of the visibility cuts").weak());
        histogram(ui, &report.cut_size_histogram);
    }
    for warning in &report.warnings {
        copyable(ui, RichText::new(warning).color(ui.visuals().warn_fg_color));
    }
}

/// The table: names and values with units. Only what was baked has rows.
fn rows(report: &BakeReport, settings: &BakeSettings) -> Vec<(String, String)> {
    let mut rows = vec![
        ("Vertices", format!("{} ({} points)", count(report.vertices), count(report.bake_points))),
        ("Triangles", count(report.triangles)),
    ];
    if report.mode.environment() {
        rows.extend(environment_rows(report, settings));
    }
    rows.extend(bounce_rows(report, settings));
    rows.push(("File", bytes(report.bytes_total)));
    if let Some(run) = &report.run {
        rows.push(("Peak memory", bytes(run.peak_memory_bytes)));
        rows.extend(run.estimated_memory_bytes.map(|expected| ("Memory expected", bytes(expected))));
    }
    let mut rows: Vec<(String, String)> = rows.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    let of_phase = |phase: Phase| (phase.name(), described(phase).0.to_lowercase());
    for (key, name) in Phase::ALL.map(of_phase).into_iter().chain([("total", "total".to_owned())]) {
        if let Some(secs) = report.seconds(key).filter(|secs| *secs > 0.0) {
            rows.push((format!("Time, {name}"), duration(secs)));
        }
    }
    rows
}

fn count(n: usize) -> String {
    grouped(n as u64)
}

/// What was baked of distant light.
fn environment_rows(report: &BakeReport, settings: &BakeSettings) -> Vec<(&'static str, String)> {
    let mut rows = vec![
        ("Lights", count(report.lights)),
        ("Mean cut", format!("{:.1} nodes", report.mean_cut)),
        ("Largest cut", format!("{} nodes", count(report.max_cut))),
        ("Sigma", sigma_text(report.sigma, settings.criterion.sigma)),
        ("Visibility error", format!("{:.4} RMS", report.rms_visibility)),
        ("Cuts", bytes(report.bytes_cuts)),
    ];
    if let Some(audit) = &report.audit {
        rows.extend([
            ("Audit, error", format!("{:.4} RMS", audit.rms_error)),
            ("Audit, missed", missed(audit, "lights")),
        ]);
    }
    let speed = |run: &BakeRun| ("Speed", format!("{:.1} M pairs/s", run.samples_per_second / 1e6));
    rows.extend(report.run.as_ref().map(speed));
    rows
}

/// How much of the lights or sources following boundaries has missed.
fn missed(audit: &BakeAudit, leaves: &str) -> String {
    match audit.leaves_per_probe {
        1 => "none, all traced".into(),
        _ => format!("{:.3} % of {leaves}", 100.0 * audit.leaves_wrong),
    }
}

/// What was baked of bounced light.
fn bounce_rows(report: &BakeReport, settings: &BakeSettings) -> Vec<(&'static str, String)> {
    let mut rows = Vec::new();
    if let Some(indirect) = &report.indirect {
        let asked = settings.indirect.criterion;
        rows.extend([
            ("Sources", count(indirect.sources)),
            ("Mean source cut", format!("{:.1} nodes", indirect.mean_cut)),
            ("Source sigma", sigma_text(indirect.criterion(asked).sigma, asked.sigma)),
            ("Bounce error", format!("{:.1} %", 100.0 * indirect.relative_error)),
            ("Source cuts", bytes(indirect.bytes_cuts)),
        ]);
        rows.extend(indirect.audit.iter().map(|audit| ("Sources missed", missed(audit, "sources"))));
    }
    if let Some(meshless) = &report.meshless {
        rows.extend([
            ("Basis", format!("{} functions", count(meshless.functions.iter().sum()))),
            ("Basis links", format!("{} ({})", count(meshless.links), bytes(meshless.bytes_links))),
        ]);
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
    use lapidary_core::dataset::{BakeParts, IndirectReport};
    use lapidary_precompute::Preset;

    #[test]
    fn bars_name_their_range() {
        assert_eq!(bar_text(0, 5), "1 node: 5 points");
        assert_eq!(bar_text(4, 12_345), "16 to 31 nodes: 12,345 points");
        assert_eq!([0.0, 7.0, -1.0].map(power_of_two), ["1", "128", ""]);
    }

    #[test]
    fn the_table_has_units_and_only_phases_that_ran() {
        let seconds = [("visibility".to_owned(), 12.0), ("total".to_owned(), 14.0)].into();
        let estimated_memory_bytes = Some(382_000_000);
        let run = BakeRun { seconds, peak_memory_bytes: 340_000_000, estimated_memory_bytes, ..Default::default() };
        let run = Some(run);
        let report = BakeReport { mean_cut: 171.26, bytes_cuts: 9_250_000, sigma: 3.0, run, ..Default::default() };
        let rows = rows(&report, &Preset::Normal.settings());
        let value = |name: &str| rows.iter().find(|r| r.0 == name).map(|r| r.1.as_str());
        assert_eq!(value("Mean cut"), Some("171.3 nodes"));
        assert_eq!(value("Sigma"), Some("3 (2 asked for)"));
        assert_eq!(value("Cuts"), Some("9.2 MB"));
        assert_eq!((value("Peak memory"), value("Memory expected")), (Some("340.0 MB"), Some("382.0 MB")));
        assert_eq!(value("Audit, missed"), None);
        let audited = |lights_per_probe| {
            let found = BakeAudit {
                leaves_per_probe: lights_per_probe,
                leaves_wrong: 2e-4,
                rms_error: 0.08,
                ..Default::default()
            };
            let rows = self::rows(&BakeReport { audit: Some(found), ..report.clone() }, &Preset::Normal.settings());
            rows.into_iter().filter(|(name, _)| name.starts_with("Audit")).map(|(_, value)| value).collect::<Vec<_>>()
        };
        assert_eq!(audited(16), ["0.0800 RMS", "0.020 % of lights"]);
        assert_eq!(audited(1), ["0.0800 RMS", "none, all traced"]);
        let sources = |audit| {
            let indirect = Some(IndirectReport { audit, ..Default::default() });
            let rows = bounce_rows(&BakeReport { indirect, ..report.clone() }, &Preset::Normal.settings());
            rows.into_iter().find(|(name, _)| *name == "Sources missed").map(|(_, value)| value)
        };
        let found = BakeAudit { leaves_per_probe: 8, leaves_wrong: 2e-3, ..Default::default() };
        assert_eq!((sources(None), sources(Some(found))), (None, Some("0.200 % of sources".into())));
        assert_eq!(value("Time, environment visibility"), Some("12 s"));
        assert_eq!(value("Time, building the light tree"), None);
        let read = self::rows(&BakeReport { run: None, ..report.clone() }, &Preset::Normal.settings());
        let names: Vec<&str> = read.iter().map(|row| row.0.as_str()).collect();
        assert!(
            names.contains(&"Mean cut") && !names.contains(&"Speed") && !names.contains(&"Peak memory"),
            "{names:?}"
        );
    }

    #[test]
    fn bounces_have_rows_of_their_own_and_the_environment_none_without_a_bake_of_it() {
        let indirect = IndirectReport { sources: 4096, mean_cut: 87.5, relative_error: 0.042, ..Default::default() };
        let seconds = [("source-visibility".to_owned(), 6.0)].into();
        let mode = BakeParts::INDIRECT;
        let run = Some(BakeRun { seconds, ..Default::default() });
        let report = BakeReport { mode, indirect: Some(indirect), run, ..Default::default() };
        let rows = rows(&report, &Preset::Normal.settings());
        let value = |name: &str| rows.iter().find(|r| r.0 == name).map(|r| r.1.as_str());
        assert_eq!((value("Sources"), value("Mean source cut")), (Some("4,096"), Some("87.5 nodes")));
        assert_eq!(value("Source sigma"), Some("2"));
        assert_eq!((value("Bounce error"), value("Time, source visibility")), (Some("4.2 %"), Some("6.0 s")));
        assert_eq!([value("Lights"), value("Mean cut"), value("Basis")], [None; 3]);
    }
}
