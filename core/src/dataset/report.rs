//! The report of a bake.

use super::{BakeAudit, BakeParts, IndirectReport, MeshlessReport, ObjectBasesReport, WaveletReport};
use crate::light_tree::TreeKind;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Report of a bake, with the keys of `--report`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BakeReport {
    /// Vertices after tessellation.
    pub vertices: usize,
    /// Triangles after tessellation.
    pub triangles: usize,
    /// Light samples.
    pub lights: usize,
    /// Clustering metric.
    pub tree: TreeKind,
    /// Weight of the geometric metric.
    pub beta: f32,
    /// Error bound of a cluster over the environment; larger than requested if a byte budget required it.
    pub sigma: f32,
    /// Mean number of nodes of a vertex's cut.
    pub mean_cut: f64,
    /// Largest cut.
    pub max_cut: usize,
    /// Root mean square of stored minus traced visibility over all vertices and lights, before cuts were coarsened to
    /// fit. It covers the traced boundaries; [`Self::audit`] covers missed ones.
    pub rms_visibility: f64,
    /// Bytes of nodes, padding and offsets.
    pub bytes_cuts: u64,
    /// Bytes of all tensors.
    pub bytes_total: u64,
    /// (vertex, light) pairs.
    pub samples_resolved: u64,
    /// Rays traced for them. Directions below the horizon of a closed surface or far from boundaries need none.
    pub rays_traced: u64,
    /// Errors of following boundaries; `None` for an exhaustive bake.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<BakeAudit>,
    /// Whether a graphics device traced the environment; its rays along edges may fall to either side. Vertices that a device asked
    /// for are not marked: checks begin with the stored mesh.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub on_device: bool,
    /// How often cuts were baked anew where an edit reached. They may then be finer than those of a whole bake. Rays are those of
    /// the last update, errors those of the whole bake before it.
    #[serde(skip_serializing_if = "is_zero")]
    pub updates: u32,
    /// The baked parts.
    pub mode: BakeParts,
    /// Report of the surface sources.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub indirect: Option<IndirectReport>,
    /// Report of the meshless basis, if baked.
    pub meshless: Option<MeshlessReport>,
    /// Report of the bases of objects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object_bases: Option<ObjectBasesReport>,
    /// Report of wavelet transport.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelet: Option<WaveletReport>,
    /// Duration and memory. A dataset omits it, so equal bakes are equal files; datasets of earlier versions have it.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub run: Option<BakeRun>,
    /// Distinct bake points; vertices that agree in position and normal share one.
    pub bake_points: usize,
    /// Bake points inside other geometry.
    pub buried_points: usize,
    /// Vertices before tessellation.
    pub source_vertices: usize,
    /// Histogram of cut sizes: entry `i` counts bake points with `2^i` to `2^(i+1) - 1` nodes.
    pub cut_size_histogram: Vec<u64>,
    /// Warnings of the import and the bake.
    pub warnings: Vec<String>,
}

fn is_zero(number: &u32) -> bool {
    *number == 0
}

/// Cost of a bake on the machine that ran it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BakeRun {
    /// Wall-clock seconds by phase: `import, tessellate, pilot, tree, visibility, pack, total`, and the phases of other modes.
    pub seconds: BTreeMap<String, f64>,
    /// Pairs a second of the visibility phase.
    pub samples_per_second: f64,
    /// Peak resident memory of the process.
    pub peak_memory_bytes: u64,
    /// Estimate of it before the bake; `None` if the dataset was merged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimated_memory_bytes: Option<u64>,
}

impl BakeRun {
    /// This run and another after it.
    #[must_use]
    pub fn followed_by(mut self, after: Option<Self>) -> Self {
        for (phase, seconds) in after.iter().flat_map(|run| &run.seconds) {
            *self.seconds.entry(phase.clone()).or_default() += seconds;
        }
        self.peak_memory_bytes = self.peak_memory_bytes.max(after.map_or(0, |run| run.peak_memory_bytes));
        self
    }
}

impl BakeReport {
    /// Lights per probe in tracing the environment, 1 if every light is traced.
    pub fn lights_per_probe(&self) -> usize {
        self.audit.map_or(1, |audit| audit.leaves_per_probe)
    }

    /// Seconds of a phase, or of all as `total`; `None` if unknown, as in a dataset from a file.
    pub fn seconds(&self, phase: &str) -> Option<f64> {
        self.run.as_ref()?.seconds.get(phase).copied()
    }
}

/// A sigma as text: as requested, or rounded with the requested one, where a size limit raised it.
pub fn sigma_text(held: f32, asked: f32) -> String {
    if held == asked {
        return asked.to_string();
    }
    let rounded = format!("{held:.2e}").parse().unwrap_or(held);
    format!("{rounded} ({asked} asked for)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sigma_that_a_limit_raised_is_told_rounded_and_others_as_asked() {
        assert_eq!(sigma_text(2.0 * 1.05_f32.powi(2), 2.0), "2.2 (2 asked for)");
        assert_eq!(sigma_text(2.0 * 1.05_f32.powi(3), 2.0), "2.32 (2 asked for)");
        assert_eq!(sigma_text(0.001_234_5, 0.001_234_5), "0.0012345");
    }
}
