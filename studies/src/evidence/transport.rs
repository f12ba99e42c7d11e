//! The figures of wavelet radiance transport (Kontkanen et al. 2006: Table 1, Fig. 4, 6 to 10), measured anew on the scenes that
//! consist of quads. Only the light of lamps after one bounce or more is shown and compared: the rest is not the method's.

mod lit;
mod tables;

use super::{Measurement, cases::Case, notebook::Notebook};
use crate::{
    report::{
        chart::{AxisScale, Chart, Line},
        figure, table,
        text::{grouped, short},
    },
    sheet::{exposure, side_by_side},
};
use anyhow::Result;
use lapidary_core::wavelet::series::GlobalTransport;
use lapidary_interchange::image;
use lit::LitQuads;
use maud::html;
use serde::Serialize;

/// Thresholds of compression in Fig. 4 and 6 to 8, from the paper's finest on.
const THRESHOLDS: [f32; 4] = [1e-6, 1e-5, 1e-4, 1e-3];
/// The three of them in Fig. 4, coarse first.
const OF_FIG_4: [f32; 3] = [1e-3, 1e-4, 1e-5];

/// Measures all figures on the cases whose scenes are quads and have lamps.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, cases: &[Case], notebook: &mut Notebook) -> Result<()> {
    let lit = cases.iter().filter_map(|case| LitQuads::new(measurement, case).transpose());
    let lit = lit.collect::<Result<Vec<_>>>()?;
    let Some(first) = lit.first() else { return Ok(()) };
    measurement.steps.begin("wavelet transport: Table 1");
    tables::record(measurement, &lit, notebook)?;
    measurement.steps.begin("wavelet transport: compression");
    record_compression(measurement, first, notebook)?;
    measurement.steps.begin("wavelet transport: gathering");
    record_gathering(measurement, first, notebook)
}

/// A threshold of Fig. 6 to 8.
#[derive(Serialize)]
struct Compressed {
    threshold: f32,
    /// Coefficients of each power of transport (Fig. 6).
    coefficients: Vec<usize>,
    /// Memory of the operator, and of the gathered one, in bytes.
    bytes: [u64; 2],
    /// Sum of squared differences of coefficients from the finest threshold, of the operator and of the gathered one (Fig. 7).
    errors: [f64; 2],
}

fn record_compression(measurement: &Measurement, lit: &LitQuads, notebook: &mut Notebook) -> Result<()> {
    let direct = &lit.transport.direct;
    let of = |threshold: f32| {
        let global = GlobalTransport::of(direct, threshold);
        let gathered = direct.after(&global.operator, threshold);
        (global, gathered)
    };
    let mut finest = None;
    let mut rows = Vec::new();
    for threshold in THRESHOLDS {
        measurement.steps.check()?;
        let (global, gathered) = of(threshold);
        let operators = [global.operator, gathered];
        let of_finest = finest.get_or_insert_with(|| operators.clone());
        rows.push(Compressed {
            threshold,
            coefficients: global.coefficients,
            bytes: [0, 1].map(|i| operators[i].bytes()),
            errors: [0, 1].map(|i| operators[i].squared_distance(&of_finest[i])),
        });
    }
    let body = html! {
        p { "Scene “" (lit.name) "”. Coefficients of each power of transport, by the threshold of compression:" }
        (powers(&rows))
        p { "Squared difference from the finest threshold, and memory, of the operator of all bounces and of the gathered one:" }
        (table(&["Threshold", "Error", "Memory", "Gathered: error", "Memory"], &rows.iter().map(cells).collect::<Vec<_>>()))
    };
    notebook.record("wavelet_compression", "Wavelet transport, Fig. 6 to 8: compression", body, &rows)
}

/// Fig. 6.
fn powers(rows: &[Compressed]) -> maud::Markup {
    let line = |row: &Compressed| Line {
        name: format!("{:e}", row.threshold),
        points: (1..).map(f64::from).zip(row.coefficients.iter().map(|&count| count as f64)).collect(),
    };
    let lines: Vec<Line> = rows.iter().map(line).collect();
    let chart = Chart {
        title: "Coefficients by power",
        x_label: "power of transport",
        x: AxisScale::Linear,
        y: AxisScale::Log,
        lines: &lines,
    };
    chart.svg()
}

fn cells(row: &Compressed) -> Vec<String> {
    let megabytes = |bytes: u64| format!("{:.1} MB", bytes as f64 / 1e6);
    vec![
        format!("{:e}", row.threshold),
        short(row.errors[0]),
        megabytes(row.bytes[0]),
        short(row.errors[1]),
        megabytes(row.bytes[1]),
    ]
}

/// Fig. 4: pictures of the operator of all bounces, and gathered, by threshold.
fn record_gathering(measurement: &Measurement, lit: &LitQuads, notebook: &mut Notebook) -> Result<()> {
    #[derive(Serialize)]
    struct Gathered {
        threshold: f32,
        coefficients: usize,
        error: f64,
        gathered_error: f64,
    }
    let paths = lit.paths(measurement)?;
    let (mut rows, mut pictures) = (Vec::new(), Vec::new());
    for threshold in OF_FIG_4 {
        let global = GlobalTransport::of(&lit.transport.direct, threshold);
        let direct = lit.direct();
        let all = global.operator.apply(&direct);
        let bounced: Vec<_> = all.iter().zip(&direct).map(|(all, direct)| *all - *direct).collect();
        let [plain, gathered] = [bounced, lit.transport.direct.apply(&all)].map(|light| lit.picture(&light));
        rows.push(Gathered {
            threshold,
            coefficients: global.operator.len(),
            error: paths.against(&plain)?.error,
            gathered_error: paths.against(&gathered)?.error,
        });
        pictures.extend([plain, gathered]);
        measurement.steps.check()?;
    }
    pictures.push(paths.image.clone());
    let exposure = exposure(&paths.image);
    let strip = side_by_side(&pictures.iter().map(|picture| picture.scaled(exposure)).collect::<Vec<_>>());
    let png = "wavelet-gathering.png";
    image::write(&strip, &measurement.out.join(png))?;
    let cells = |row: &Gathered| {
        vec![
            format!("{:e}", row.threshold),
            grouped(row.coefficients as u64),
            short(row.error),
            short(row.gathered_error),
        ]
    };
    let body = html! {
        p { "Bounced light of the scene “" (lit.name) "”. Error: relative RMSE against light paths, noise taken off." }
        (figure("", png, strip.size, "by threshold: as computed, and gathered; last, light paths", html! {
            "Each threshold as computed, then gathered; last, light paths."
        }))
        (table(&["Threshold", "Coefficients", "Error", "Gathered"], &rows.iter().map(cells).collect::<Vec<_>>()))
    };
    notebook.record("wavelet_gathering", "Wavelet transport, Fig. 4: gathering by the fine operator", body, &rows)
}
