//! Report of the last bake: a table, the sizes of its cuts, and its remarks.

use super::progress::described;
use crate::{
    bake::parts::{self, count},
    widgets::{
        copyable,
        units::{bytes, duration},
    },
};
use egui::{Grid, RichText, Ui};
use lapidary_core::dataset::{BakeReport, BakeSettings};
use lapidary_precompute::Phase;

/// Shows the report of a bake with these settings.
pub fn show(ui: &mut Ui, report: &BakeReport, settings: &BakeSettings) {
    Grid::new("bake report").num_columns(2).striped(true).show(ui, |ui| {
        for (name, value) in rows(report, settings) {
            ui.label(RichText::new(name).weak());
            copyable(ui, RichText::new(value).monospace());
            ui.end_row();
        }
    });
    parts::all().for_each(|part| part.diagram(ui, report));
    for warning in &report.warnings {
        copyable(ui, RichText::new(warning).color(ui.visuals().warn_fg_color));
    }
}

/// The table: names and values with units. Only baked parts have rows.
fn rows(report: &BakeReport, settings: &BakeSettings) -> Vec<(String, String)> {
    let mut rows = vec![
        ("Vertices", format!("{} ({} points)", count(report.vertices), count(report.bake_points))),
        ("Triangles", count(report.triangles)),
    ];
    rows.extend(parts::all().flat_map(|part| part.rows(report, settings)));
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

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::dataset::{BakeAudit, BakeParts, BakeRun, IndirectReport};
    use lapidary_precompute::Preset;

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
        assert_eq!(value("Lights missed"), None);
        let audited = |lights_per_probe| {
            let found = BakeAudit {
                leaves_per_probe: lights_per_probe,
                leaves_wrong: 2e-4,
                rms_error: 0.08,
                ..Default::default()
            };
            let rows = self::rows(&BakeReport { audit: Some(found), ..report.clone() }, &Preset::Normal.settings());
            let is_of_audit = |name: &str| ["Error, checked", "Lights missed"].contains(&name);
            rows.into_iter().filter(|(name, _)| is_of_audit(name)).map(|(_, value)| value).collect::<Vec<_>>()
        };
        assert_eq!(audited(16), ["0.0800 RMS", "0.020 % of lights"]);
        assert_eq!(audited(1), ["0.0800 RMS", "none: all lights were traced"]);
        let sources = |audit| {
            let indirect = Some(IndirectReport { audit, ..Default::default() });
            let rows = self::rows(&BakeReport { indirect, ..report.clone() }, &Preset::Normal.settings());
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
