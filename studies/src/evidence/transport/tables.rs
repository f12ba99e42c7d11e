//! Table 1, Fig. 9 and Fig. 10: sizes and times of wavelet transport, errors, pictures.

use super::{
    super::{Measurement, notebook::Notebook},
    lit::LitQuads,
};
use crate::{
    bounces::light_paths::Figures,
    report::{
        figure, table,
        text::{grouped, megabytes, seconds, short},
    },
    sheet::{exposure, side_by_side},
    timing::median,
};
use anyhow::Result;
use lapidary_interchange::image;
use lapidary_precompute::wavelet::TransportSettings;
use maud::html;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Light changes in the median of Fig. 9.
const CHANGES: usize = 5;

/// A scene of Table 1.
#[derive(Serialize)]
struct Row {
    scene: String,
    patches: usize,
    functions: usize,
    /// Time of one bounce, and of the series.
    precompute_seconds: [f64; 2],
    /// Links of one bounce, of all bounces, and of all bounces gathered.
    links: [usize; 3],
    /// Of one bounce and of all, which a picture uses.
    bytes: u64,
    /// Fig. 9: projection of direct light, both products, and textures.
    milliseconds: [f64; 3],
    picture: String,
    #[serde(skip)]
    picture_size: [u32; 2],
    #[serde(flatten)]
    figures: Figures,
}

/// Measures all scenes.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, lit: &[LitQuads], notebook: &mut Notebook) -> Result<()> {
    let rows = lit.iter().map(|lit| Row::of(measurement, lit)).collect::<Result<Vec<_>>>()?;
    let head = [
        "Scene",
        "Quads",
        "One bounce",
        "All",
        "Links of one",
        "Of all",
        "Gathered",
        "Memory",
        "Direct light",
        "Products",
        "Textures",
        "Error",
        "Energy",
    ];
    let milliseconds = |value: f64| format!("{value:.1} ms");
    let cells = |row: &Row| {
        vec![
            row.scene.clone(),
            grouped(row.patches as u64),
            seconds(row.precompute_seconds[0]),
            seconds(row.precompute_seconds[1]),
            grouped(row.links[0] as u64),
            grouped(row.links[1] as u64),
            grouped(row.links[2] as u64),
            megabytes(row.bytes),
            milliseconds(row.milliseconds[0]),
            milliseconds(row.milliseconds[1]),
            milliseconds(row.milliseconds[2]),
            short(row.figures.error),
            short(row.figures.energy),
        ]
    };
    let body = html! {
        p {
            "The paper, on a Pentium 4 of 3 GHz, at its two qualities: Cornell 2 and 25 minutes, maze 23 and 72 minutes, glossy 1 and 9 \
             minutes; 3,477 to 288,628 links of one bounce; 60 to 3 pictures per second. Error: relative RMSE of bounced light against \
             light paths, noise taken off. Direct light, products and textures are what a moved lamp costs."
        }
        (table(&head, &rows.iter().map(cells).collect::<Vec<_>>()))
        @for row in &rows {
            (figure("", &row.picture, row.picture_size, &row.scene, html! {
                b { "Fig. 10, " (row.scene) ": " } "bounced light by wavelets, and by light paths"
            }))
        }
    };
    notebook.record(
        "wavelet_table1",
        "Wavelet transport, Table 1, Fig. 9 and 10: sizes, times and pictures",
        body,
        &rows,
    )
}

impl Row {
    fn of(measurement: &Measurement, lit: &LitQuads) -> Result<Self> {
        measurement.steps.check()?;
        let transport = &lit.transport;
        let gathered = transport.direct.after(&transport.global, TransportSettings::DEFAULT.compression);
        let links = [&transport.direct, &transport.global, &gathered].map(|operator| operator.links(&transport.basis));
        let mut times = [const { Vec::new() }; 3];
        for _ in 0..CHANGES {
            let (direct, took) = timed(|| lit.direct());
            let (light, of_products) = timed(|| transport.indirect(&direct));
            let (_, of_textures) = timed(|| lit.textures(&light));
            times.iter_mut().zip([took, of_products, of_textures]).for_each(|(times, took)| times.push(took));
        }
        let paths = lit.paths(measurement)?;
        let image = lit.picture(&transport.indirect(&lit.direct()));
        let exposure = exposure(&paths.image);
        let strip = side_by_side(&[&image, &paths.image].map(|image| image.scaled(exposure)));
        let picture = format!("wavelet-{}.png", lit.name);
        image::write(&strip, &measurement.out.join(&picture))?;
        Ok(Self {
            scene: lit.name.to_owned(),
            patches: transport.patches.len(),
            functions: transport.basis.functions().len(),
            precompute_seconds: lit.precompute.map(|took| took.as_secs_f64()),
            links,
            bytes: transport.direct.bytes() + transport.global.bytes(),
            milliseconds: times.map(median),
            picture,
            picture_size: strip.size,
            figures: paths.against(&image)?,
        })
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}
