//! Table 1 of both papers: sizes, times and errors of the meshless basis and of radiosity.

use super::super::{Measurement, cases::Case, implicit::Dragged, notebook::Notebook};
use crate::{
    bounces::{
        light_paths::{Figures, LightPaths},
        resolve::{Resolve, measured},
    },
    report::{
        table,
        text::{grouped, megabytes, seconds, short},
    },
};
use anyhow::{Context, Result};
use lapidary_core::{dataset::Dataset, image::Image};
use lapidary_precompute::Phase;
use lapidary_render::{Baked, CpuBackend, LitScene, Look, Solution};
use maud::{Markup, html};
use serde::Serialize;
use std::{sync::Arc, time::Instant};

/// Moves of the dragged object, there and back.
const MOVES: u32 = 2;

/// A scene in the meshless basis.
#[derive(Serialize)]
struct BasisRow {
    scene: String,
    triangles: usize,
    /// Levels that receive, and those of them that send.
    levels: [usize; 2],
    coarsest: usize,
    functions: usize,
    links: usize,
    /// Placing the functions, and finding the links.
    precompute_seconds: f64,
    bytes: u64,
    /// From a dataset to its first picture with all bounces.
    picture_seconds: f64,
    #[serde(flatten)]
    figures: Figures,
}

/// A scene in functions of its objects.
#[derive(Serialize)]
struct RadiosityRow {
    scene: String,
    triangles: usize,
    levels: usize,
    sender_level: usize,
    objects: usize,
    coarsest: usize,
    finest: usize,
    placing_seconds: f64,
    #[serde(flatten)]
    resolve: Resolve,
    #[serde(flatten)]
    figures: Figures,
}

/// Table 1 of the meshless paper.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record_basis(
    measurement: &Measurement,
    cases: &[(&Case, &Arc<Dataset>)],
    notebook: &mut Notebook,
) -> Result<()> {
    let rows = cases.iter().map(|(case, dataset)| BasisRow::of(measurement, case, dataset));
    let rows = rows.collect::<Result<Vec<_>>>()?;
    notebook.record("meshless_table1", "Meshless basis, Table 1: direct-to-indirect transport", basis(&rows), &rows)
}

/// Table 1 of meshless radiosity, with times; the paper's Table 2 is not in the text that we have.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record_radiosity(
    measurement: &Measurement,
    cases: &[(&Case, &Arc<Dataset>)],
    notebook: &mut Notebook,
) -> Result<()> {
    let rows = cases.iter().filter_map(|(case, dataset)| RadiosityRow::of(measurement, case, dataset).transpose());
    let rows = rows.collect::<Result<Vec<_>>>()?;
    notebook.record("radiosity_table1", "Meshless radiosity, Table 1: sizes and times", radiosity(&rows), &rows)
}

impl BasisRow {
    fn of(measurement: &Measurement, case: &Case, dataset: &Arc<Dataset>) -> Result<Self> {
        let report = dataset.report.meshless.as_ref().context("the bake has a meshless basis")?;
        let of_phase = |phase: Phase| dataset.report.seconds(phase.name()).unwrap_or_default();
        let settings = &dataset.settings.meshless;
        let start = Instant::now();
        let look = measurement.bounced(dataset, Solution::Meshless);
        let image = measurement.picture(dataset, &look)?;
        Ok(Self {
            scene: case.name.clone(),
            triangles: case.scene.mesh.triangles.len(),
            levels: [settings.levels, settings.sender_levels],
            coarsest: report.functions.first().copied().unwrap_or_default(),
            functions: report.functions.iter().sum(),
            links: report.links,
            precompute_seconds: of_phase(Phase::Basis) + of_phase(Phase::Transport),
            bytes: report.bytes_links + report.bytes_points,
            picture_seconds: start.elapsed().as_secs_f64(),
            figures: measurement.against_paths(dataset, &look, &image)?,
        })
    }
}

impl RadiosityRow {
    /// `None` for a scene without an object that could move.
    fn of(measurement: &Measurement, case: &Case, dataset: &Arc<Dataset>) -> Result<Option<Self>> {
        let Some(dragged) = Dragged::of(&dataset.scene) else { return Ok(None) };
        let report = dataset.report.object_bases.as_ref().context("the bake has functions of objects")?;
        let look = measurement.bounced(dataset, Solution::Radiosity);
        let baked = Baked::from(dataset.clone());
        let image = measurement.picture(dataset, &look)?;
        let ends = [report.functions.first(), report.functions.last()].map(|count| count.copied().unwrap_or_default());
        Ok(Some(Self {
            scene: case.name.clone(),
            triangles: case.scene.mesh.triangles.len(),
            levels: report.functions.len(),
            sender_level: dataset.settings.object_bases.sender_level,
            objects: report.objects,
            coarsest: ends[0],
            finest: ends[1],
            placing_seconds: dataset.report.seconds(Phase::ObjectBases.name()).unwrap_or_default(),
            resolve: measured(&baked, &look, &dragged.name, &dragged.poses(1.0), MOVES)?,
            figures: measurement.against_paths(dataset, &look, &image)?,
        }))
    }
}

impl Measurement<'_> {
    /// The picture of a look.
    pub(super) fn picture(&self, dataset: &Arc<Dataset>, look: &Look) -> Result<Image> {
        self.steps.check()?;
        Ok(LitScene::new(Box::new(CpuBackend::new()), dataset.clone().into())?.show_whole(look)?.image)
    }

    /// Error of a picture against light paths of as many bounces.
    pub(super) fn against_paths(&self, dataset: &Arc<Dataset>, look: &Look, image: &Image) -> Result<Figures> {
        let baked = Baked::from(dataset.clone());
        let paths = self.posed_paths(&baked, look, look.solution.bounces(), self.scale.spp)?;
        LightPaths::from(paths).against(image)
    }
}

fn basis(rows: &[BasisRow]) -> Markup {
    let head = [
        "Scene",
        "Triangles",
        "Levels, senders",
        "Coarsest",
        "Functions",
        "Links",
        "Precompute",
        "Memory",
        "Picture",
        "Error",
    ];
    let cells = |row: &BasisRow| {
        vec![
            row.scene.clone(),
            grouped(row.triangles as u64),
            format!("{}, {}", row.levels[0], row.levels[1]),
            grouped(row.coarsest as u64),
            grouped(row.functions as u64),
            grouped(row.links as u64),
            seconds(row.precompute_seconds),
            megabytes(row.bytes),
            seconds(row.picture_seconds),
            short(row.figures.error),
        ]
    };
    html! {
        p {
            "The paper's scenes have 176 to 339 coarsest and 177,000 to 221,000 functions of six levels, of which three send, and took \
             26 to 35 minutes and 77 to 120 MB. Error: relative RMSE of bounced light against light paths, noise taken off."
        }
        (table(&head, &rows.iter().map(cells).collect::<Vec<_>>()))
    }
}

fn radiosity(rows: &[RadiosityRow]) -> Markup {
    let head = [
        "Scene",
        "Triangles",
        "Levels, sender",
        "Coarsest",
        "Finest",
        "Placing",
        "Whole solve",
        "After a move",
        "Its first bounce",
        "Rays traced again",
        "Error",
    ];
    let cells = |row: &RadiosityRow| {
        let milliseconds = |value: f64| seconds(value / 1000.0);
        let again = row.resolve.rays_traced_again as f64 / row.resolve.rays.max(1) as f64;
        vec![
            row.scene.clone(),
            grouped(row.triangles as u64),
            format!("{}, {}", row.levels, row.sender_level),
            grouped(row.coarsest as u64),
            grouped(row.finest as u64),
            seconds(row.placing_seconds),
            milliseconds(row.resolve.whole_milliseconds),
            milliseconds(row.resolve.after_a_move_milliseconds),
            milliseconds(row.resolve.first_bounce_milliseconds),
            format!("{:.1} %", 100.0 * again),
            short(row.figures.error),
        ]
    };
    html! {
        p {
            "The paper's scenes have 226 to 1,438 coarsest and 167,000 to 356,000 finest functions of six levels; level 4 sends. An \
             object is moved by half its width and back. The paper's Table 2, its times, is missing from our copy."
        }
        (table(&head, &rows.iter().map(cells).collect::<Vec<_>>()))
    }
}
