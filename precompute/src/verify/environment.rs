//! Retraced and reselected cuts over the environment.

use super::{Again, MOST_ERROR_OF_FEW};
use crate::vertices::{points::BakePoint, visibility::VisibilitySampler};
use lapidary_core::{
    cut::{CutSelector, squared_error},
    dataset::{BakeReport, Dataset},
};
use rayon::prelude::*;
use serde::Serialize;

/// Largest share of rays that may fall on another side of an edge on a device; ten times the largest value in tests.
const ALONG_EDGES: f64 = 1e-4;
/// Results for the vertices' cuts over the environment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EnvironmentVerification {
    /// Retraced vertices.
    pub vertices: usize,
    /// Root mean square of stored minus traced visibility over their lights.
    pub rms_visibility: f64,
    /// The same error over the whole bake, from its report.
    pub expected_rms: f64,
    /// The same error for cuts selected from the traced values, as in an exhaustive bake.
    pub exhaustive_rms: f64,
    /// Share of these vertices' lights that the bake wrongly takes for visible or blocked; 0 to 1.
    pub leaves_wrong: f64,
    /// Vertices whose recomputed cut differs from the stored one.
    pub different_cuts: usize,
    /// Largest root mean square of one vertex.
    pub worst_rms: f64,
    /// Whether the cuts agree.
    #[serde(skip)]
    pub agrees: bool,
}

impl EnvironmentVerification {
    /// Checks these vertices, or none if the environment was not baked.
    pub(super) fn of(again: &Again) -> Self {
        let Again { dataset, points, sampler, .. } = again;
        let check = |&vertex: &usize| {
            let stored = dataset.cuts.cut(dataset.tree.height(), vertex as u32);
            check_cut(dataset, sampler, &points.points[points.of_vertex[vertex] as usize], stored)
        };
        let picked = if dataset.settings.mode.environment() { &again.vertices[..] } else { &[] };
        let results: Vec<Checked> = picked.par_iter().map(check).collect();
        let lights = dataset.tree.len() as f64;
        let pairs = results.len().max(1) as f64 * lights;
        let rms_visibility = mean(&results, |r| r.squared_error, lights).sqrt();
        let worst = results.iter().map(|r| r.squared_error).fold(0.0, f64::max);
        let report = &dataset.report;
        // A byte budget coarsens cuts afterwards, so only their errors are compared.
        let agrees = match report.sigma == dataset.settings.criterion.sigma {
            true => agree(&results, lights, report),
            false => rms_visibility < 4.0 * report.rms_visibility.max(0.02),
        };
        Self {
            vertices: results.len(),
            rms_visibility,
            expected_rms: report.rms_visibility,
            exhaustive_rms: mean(&results, |r| r.squared_error_exhaustive, lights).sqrt(),
            leaves_wrong: results.iter().map(|r| r.wrong).sum::<u64>() as f64 / pairs,
            different_cuts: different(&results),
            worst_rms: (worst / lights).sqrt(),
            agrees,
        }
    }

    /// The result in sentences, one per line.
    pub(super) fn text(&self) -> String {
        let mut text = format!(
            "traced {} vertices again: RMS of visibility {:.4} (whole bake {:.4}, worst vertex {:.4}), {} cuts differ\n",
            self.vertices, self.rms_visibility, self.expected_rms, self.worst_rms, self.different_cuts
        );
        if self.leaves_wrong > 0.0 {
            text += &format!(
                "boundaries have missed {:.3} % of their visibility; cuts of all that was traced have an RMS of {:.4}\n",
                100.0 * self.leaves_wrong,
                self.exhaustive_rms
            );
        }
        text
    }
}

/// A recomputed cut over the environment.
pub(super) struct Checked {
    /// Sum over the lights of squared differences between stored and traced visibility.
    squared_error: f64,
    squared_error_exhaustive: f64,
    /// Lights for which the bake is wrong.
    wrong: u64,
    /// Whether the recomputed cut equals the stored one.
    is_equal: bool,
}

pub(super) fn check_cut(dataset: &Dataset, sampler: &VisibilitySampler, point: &BakePoint, stored: &[u16]) -> Checked {
    let height = dataset.tree.height();
    let (mut traced, mut seen) = (vec![0; dataset.tree.len()], vec![0; dataset.tree.len()]);
    sampler.sample_singly(&dataset.tree, point, &mut traced);
    sampler.sample_again(&dataset.tree, point, &mut seen);
    let mut selector = CutSelector::new(height, dataset.settings.criterion);
    let (mut again, mut exhaustive) = (Vec::new(), Vec::new());
    selector.select(&seen, &mut again);
    Checked {
        squared_error: squared_error(height, stored, &traced),
        squared_error_exhaustive: selector.select(&traced, &mut exhaustive),
        wrong: traced.iter().zip(&seen).filter(|(a, b)| a != b).count() as u64,
        is_equal: again == stored,
    }
}

/// Whether the cuts equal the stored ones and are hardly worse than an exhaustive bake's. Cuts traced on a device need not be
/// equal, because one ray along an edge changes a cut, nor those of an update, which may be finer; they must be as good.
pub(super) fn agree(cuts: &[Checked], lights: f64, report: &BakeReport) -> bool {
    let may_differ = report.on_device || report.updates > 0;
    let along_edges = if report.on_device { ALONG_EDGES } else { 0.0 };
    let least = MOST_ERROR_OF_FEW * MOST_ERROR_OF_FEW * mean(cuts, |c| c.squared_error_exhaustive, lights);
    (may_differ || different(cuts) == 0) && mean(cuts, |c| c.squared_error, lights) <= least + along_edges
}

pub(super) fn different(cuts: &[Checked]) -> usize {
    cuts.iter().filter(|cut| !cut.is_equal).count()
}

/// Mean over cuts and lights.
fn mean(cuts: &[Checked], error: fn(&Checked) -> f64, lights: f64) -> f64 {
    cuts.iter().map(error).sum::<f64>() / (cuts.len().max(1) as f64 * lights)
}
