//! Table 1: times of the paper's links by number of bins; and Fig. 4: bins that are wrong without refinement.

use super::super::{Measurement, notebook::Notebook};
use crate::report::{
    table,
    text::{grouped, megabytes},
};
use anyhow::Result;
use glam::{Vec3, Vec3A};
use lapidary_core::{
    implicit::{
        bins::CubeBins,
        disc_forest::DiscForest,
        links::{Links, VertexForest},
        room_of_grids,
    },
    scene::Mesh,
};
use maud::{Markup, html};
use serde::Serialize;
use std::time::Instant;

/// Texels along an edge of a bin face, as in the paper.
const SIDES: [usize; 3] = [8, 12, 16];
/// Number of runs; the least time counts, because other work disturbs it least.
const RUNS: usize = 3;
/// One in this many leaves is compared with all pairs.
const CHECKED: usize = 7;

/// Figures for one number of bins and vertices. Times are in milliseconds.
#[derive(Serialize)]
struct Row {
    vertices: usize,
    bins_side: usize,
    /// Time of the trees, built once.
    hierarchy_ms: f64,
    /// Time to update discs and nodes.
    update_ms: f64,
    links_ms: f64,
    refine_and_push_ms: f64,
    /// Time of direct light and one bounce.
    light_ms: f64,
    /// Size of the links.
    bytes: u64,
}

/// Share of wrong bins.
#[derive(Serialize)]
struct Refinement {
    vertices: usize,
    bins_side: usize,
    /// Share of bins whose link is not the shortest, within the size of a node.
    wrong: f32,
    wrong_without_refinement: f32,
}

/// Times links and counts wrong bins.
///
/// # Errors
/// Ctrl-C, or an unwritable folder.
pub fn record(measurement: &Measurement, notebook: &mut Notebook) -> Result<()> {
    let mut rows = Vec::new();
    for &side in measurement.scale.room_sides {
        let room = Room::new(side);
        for bins in SIDES.map(|side| CubeBins { side }) {
            measurement.steps.check()?;
            rows.push(room.timed(bins));
        }
    }
    notebook.record("implicit_table1", "Implicit visibility, Table 1: times of links", times(&rows), &rows)?;
    let room = Room::new(measurement.scale.refined_room_side);
    let refinements = SIDES.map(|side| room.refinement(CubeBins { side }));
    let heading = "Implicit visibility, Fig. 4: links without refinement";
    notebook.record("implicit_fig4", heading, wrong_bins(&refinements), &refinements)
}

/// A closed room and the trees over its vertices.
struct Room {
    mesh: Mesh,
    forest: VertexForest,
    hierarchy_ms: f64,
}

impl Room {
    fn new(side: u32) -> Self {
        let mesh = room_of_grids(side);
        let begin = Instant::now();
        let forest = VertexForest::new(&mesh);
        Self { forest, mesh, hierarchy_ms: ms_since(begin) }
    }

    fn timed(&self, bins: CubeBins) -> Row {
        let mut forest = self.forest.clone();
        let mut least = Row {
            vertices: self.mesh.positions.len(),
            bins_side: bins.side,
            hierarchy_ms: self.hierarchy_ms,
            update_ms: f64::INFINITY,
            links_ms: f64::INFINITY,
            refine_and_push_ms: f64::INFINITY,
            light_ms: f64::INFINITY,
            bytes: 0,
        };
        for _ in 0..RUNS {
            least.update_ms = least.update_ms.min(ms(|| forest.update(&self.mesh)));
            let begin = Instant::now();
            let mut links = Links::create(&forest.discs, bins);
            least.links_ms = least.links_ms.min(ms_since(begin));
            least.refine_and_push_ms = least.refine_and_push_ms.min(ms(|| links.refine_and_push_down(&forest.discs)));
            least.light_ms = least.light_ms.min(ms(|| one_bounce(&forest, &links)));
            least.bytes = links.bytes();
        }
        least
    }

    fn refinement(&self, bins: CubeBins) -> Refinement {
        let discs = &self.forest.discs;
        let wrong = |push_down: fn(&mut Links, &DiscForest)| {
            let mut links = Links::create(discs, bins);
            push_down(&mut links, discs);
            links.share_of_wrong(discs, CHECKED)
        };
        Refinement {
            vertices: self.mesh.positions.len(),
            bins_side: bins.side,
            wrong: wrong(Links::refine_and_push_down),
            wrong_without_refinement: wrong(Links::push_down_unrefined),
        }
    }
}

fn ms(run: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    run();
    ms_since(begin)
}

fn ms_since(begin: Instant) -> f64 {
    1e3 * begin.elapsed().as_secs_f64()
}

/// Light of the sky on half-gray surfaces, with its first bounce.
fn one_bounce(forest: &VertexForest, links: &Links) {
    let discs = &forest.discs;
    let gray = |light: Vec<Vec3>| -> Vec<Vec3A> { light.into_iter().map(|e| (0.5 * e).into()).collect() };
    let gather = |sent: &[Vec3A]| links.irradiance(discs, &discs.pull(sent), &|_| Vec3::ONE);
    let direct = gather(&vec![Vec3A::ZERO; discs.discs().len()]);
    gather(&gray(direct));
}

impl Row {
    fn total_ms(&self) -> f64 {
        self.update_ms + self.links_ms + self.refine_and_push_ms + self.light_ms
    }

    fn cells(&self) -> Vec<String> {
        let parts = [self.hierarchy_ms, self.update_ms, self.links_ms, self.refine_and_push_ms, self.light_ms];
        let times = parts.into_iter().chain([self.total_ms()]).map(|ms| format!("{ms:.1}"));
        let size = format!("6 × {0} × {0}", self.bins_side);
        [grouped(self.vertices as u64), size].into_iter().chain(times).chain([megabytes(self.bytes)]).collect()
    }
}

const HEAD: [&str; 9] =
    ["Vertices", "Bins", "Hierarchy, once", "Update", "Links", "Refine & push", "Light", "Total, ms", "Memory"];

/// Table 1 as printed, with the hierarchy from the text: bins, milliseconds.
const PAPER: [[&str; 9]; 3] = [
    ["3378", "6 × 8 × 8", "72", "12", "23", "30", "35", "112", "–"],
    ["3378", "6 × 12 × 12", "72", "12", "43", "35", "40", "148", "–"],
    ["3378", "6 × 16 × 16", "72", "12", "78", "60", "48", "218", "–"],
];

fn times(rows: &[Row]) -> Markup {
    let ours: Vec<Vec<String>> = rows.iter().map(Row::cells).collect();
    let theirs: Vec<Vec<String>> = PAPER.iter().map(|row| row.map(String::from).into()).collect();
    html! {
        p {
            "Closed rooms whose walls are grids, in milliseconds; least of " (RUNS) " runs on the CPU. Light is that of the sky and \
             its first bounce. Memory is that of the links, 8 bytes a bin and node; a tree takes as \
             much as one of the next power of two of leaves."
        }
        (table(&HEAD, &ours))
        h3 { "As printed in the paper, for its monster; light on a GeForce 8800" }
        div.quoted { (table(&HEAD, &theirs)) }
        p { "Dong et al. 2007, Table 1; the hierarchy is from its section 5; memory is not given." }
    }
}

fn wrong_bins(rows: &[Refinement]) -> Markup {
    let percent = |share: f32| format!("{:.2} %", 100.0 * share);
    let cells = |row: &Refinement| {
        let size = format!("6 × {0} × {0}", row.bins_side);
        vec![size, percent(row.wrong), percent(row.wrong_without_refinement)]
    };
    let vertices = rows.first().map_or(0, |row| row.vertices);
    html! {
        p {
            "Bins whose link is longer or shorter than that of the nearest vertex, by more than the two ends are large: against \
             linking all with all (3.1), in a room of " (grouped(vertices as u64)) " vertices."
        }
        (table(&["Bins", "Wrong, refined", "Wrong without refinement"], &rows.iter().map(cells).collect::<Vec<_>>()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_totals_are_sums_of_its_rows() {
        for row in PAPER {
            let number = |cell: &str| cell.parse::<i32>().unwrap();
            let sum: i32 = row[3..7].iter().map(|cell| number(cell)).sum();
            // Printed totals are up to 20 ms larger.
            assert!((0..=20).contains(&(number(row[7]) - sum)), "{row:?}: {sum}");
        }
    }

    #[test]
    fn bins_are_wrong_without_refinement() {
        let Refinement { wrong, wrong_without_refinement, .. } = Room::new(10).refinement(CubeBins { side: 8 });
        assert!(wrong < 0.01 && wrong_without_refinement > 0.01, "{wrong} {wrong_without_refinement}");
    }

    #[test]
    fn memory_grows_with_bins_and_times_are_taken() {
        let room = Room::new(4);
        let [few, many] = [8, 16].map(|side| room.timed(CubeBins { side }));
        assert_eq!((few.vertices, many.bytes), (150, 4 * few.bytes));
        assert!(few.total_ms() > 0.0 && few.total_ms() < f64::INFINITY);
    }
}
