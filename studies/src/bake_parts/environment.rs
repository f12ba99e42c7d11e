//! Visibility of distant light. Other parts also use its light tree and pilot.

use super::StudiedPart;
use crate::args::choices;
use clap::Args;
use lapidary_core::{
    cut::CutCriterion,
    dataset::{BakeAudit, BakeReport, BakeSettings, sigma_text},
    light_tree::TreeKind,
};

/// The environment part.
pub struct Environment;

/// Options of the environment part.
#[derive(Args, Clone, Debug)]
pub struct EnvironmentOptions {
    /// Light samples of the environment: a power of two up to 32768 [default: from the preset]
    #[arg(long, value_name = "N")]
    lights: Option<usize>,
    /// Metric that clusters the light tree [default: mixed]
    #[arg(long, value_parser = choices::tree_kind())]
    tree: Option<TreeKind>,
    /// Weight of the geometric metric in a mixed tree, 0 to 1 [default: 0.5]
    #[arg(long, value_name = "B")]
    beta: Option<f32>,
    /// Error bound of a cluster of lights: split while |C| var > sigma² (Eq. 5); 0 to 1000, usually 1.5 to 3, smaller is finer
    /// [default: from the preset]
    #[arg(long, value_name = "S")]
    sigma: Option<f32>,
    /// Most nodes in the cut of one vertex, 1 or more [default: no limit]
    #[arg(long, value_name = "K")]
    max_cut: Option<u32>,
    /// Bound the error of each whole cut instead of each cluster, 0 to 1000 [default: off]
    #[arg(long, value_name = "E")]
    total_error: Option<f32>,
    /// Most bytes for the vertices' cuts over the environment, 1024 or more; cuts are coarsened until they fit. The
    /// limit leaves out surface sources and the meshless basis [default: no limit]
    #[arg(long, value_name = "BYTES")]
    max_bytes: Option<u64>,
    /// Vertex clusters of the pilot visibility, 1 to 65536 [default: from the preset]
    #[arg(long, value_name = "M")]
    pilot_clusters: Option<usize>,
}

impl EnvironmentOptions {
    /// Applies the options to `s`.
    pub fn apply(&self, s: &mut BakeSettings) {
        s.lights = self.lights.unwrap_or(s.lights);
        s.tree = self.tree.unwrap_or(s.tree);
        s.beta = self.beta.unwrap_or(s.beta);
        s.criterion.sigma = self.sigma.unwrap_or(s.criterion.sigma);
        s.criterion.max_nodes = self.max_cut.unwrap_or(s.criterion.max_nodes);
        s.criterion.total_error = self.total_error.or(s.criterion.total_error);
        s.max_bytes = self.max_bytes.or(s.max_bytes);
        s.pilot_clusters = self.pilot_clusters.unwrap_or(s.pilot_clusters);
    }
}

impl StudiedPart for Environment {
    fn summary(&self, report: &BakeReport) -> Option<String> {
        let text = || format!("{:.0} nodes a cut, visibility RMS {:.3}", report.mean_cut, report.rms_visibility);
        report.mode.environment().then(text)
    }

    fn info(&self, r: &BakeReport, s: &BakeSettings) -> String {
        if !s.mode.environment() {
            return "cuts       not baked: the environment is dark\n".into();
        }
        let sigma = sigma_text(r.sigma, s.criterion.sigma);
        format!(
            "light tree {} samples, {:?}, beta {}\n\
             cuts       {:.1} nodes on average, {} at most, sigma {sigma}\n\
             error      {:.4} RMS of visibility\n{}",
            r.lights,
            s.tree,
            s.beta,
            r.mean_cut,
            r.max_cut,
            r.rms_visibility,
            r.audit.as_ref().map_or(String::new(), audit_text)
        )
    }

    /// Suns are the sharp part of an environment's light, and their shadows need no bake. Few lights suffice for the rest.
    fn coarsen(&self, draft: &mut BakeSettings, wanted: &BakeSettings) {
        let lights = (draft.lights / 16).min(wanted.lights);
        // A quarter of the lights at half the sigma has the same error in solid angle.
        let as_fine_as = |other: &BakeSettings| other.criterion.sigma * (lights as f32 / other.lights as f32).sqrt();
        let sigma = as_fine_as(draft).max(as_fine_as(wanted));
        draft.criterion = CutCriterion { sigma, max_nodes: wanted.criterion.max_nodes, ..draft.criterion };
        draft.lights = lights;
        draft.pilot_clusters = wanted.pilot_clusters.min(64);
    }

    fn is_sooner(&self, draft: &BakeSettings, wanted: &BakeSettings) -> bool {
        draft.lights < wanted.lights
    }
}

fn audit_text(audit: &BakeAudit) -> String {
    let wrong = 100.0 * audit.leaves_wrong;
    match audit.leaves_per_probe {
        1 => "audit      too fine for boundaries: every light was traced\n".into(),
        lights => format!(
            "audit      {wrong:.3} % of visibility wrong, {:.4} RMS where {:.4} is possible, over {} vertices; a probe for \
             {lights} lights\n",
            audit.rms_error, audit.rms_exhaustive, audit.vertices
        ),
    }
}
