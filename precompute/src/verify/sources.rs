//! Retraced and reselected cuts over surface sources, and the sources' own cuts over the environment.

use super::{
    Again, MOST_ERROR_OF_FEW,
    environment::{Checked, agree, check_cut, different},
};
use crate::{
    sources::{
        error::{relative_rms, squared_norm},
        sampler::SourceSampler,
    },
    vertices::{points::BakePoint, visibility::EXHAUSTIVE},
};
use lapidary_core::{
    cut::{SourceCutSelector, prune_sources, solid_angle_error},
    dataset::IndirectReport,
    sources::IndirectBake,
    surfel::Surface,
};
use rayon::prelude::*;
use serde::Serialize;

/// Largest number of vertices whose cuts over the sources are recomputed: each takes some 30 ms.
const SOURCE_VERTICES: usize = 64;
/// Largest number of sources whose cuts over the environment are recomputed.
const SOURCES: usize = 64;

/// Vertices below which the error says little: one of a few may see hardly anything and dominate.
const ENOUGH: usize = 16;

/// Results for the surface sources.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SourcesVerification {
    /// Vertices whose cut over the surface sources was retraced and reselected by single segments.
    pub source_vertices: usize,
    /// Number of these whose recomputed cut differs from the stored one.
    pub different_source_cuts: usize,
    /// Share of the sources that the bake wrongly takes for visible or hidden; 0 to 1.
    pub sources_wrong: f64,
    /// Root mean square over these vertices of `||stored - traced||` for solid angles, relative to `||traced||`, or to its mean if
    /// that is larger.
    pub source_error: f64,
    /// The same error for cuts selected from the traced values, as in an exhaustive bake.
    pub exhaustive_source_error: f64,
    /// Surface sources whose cut over the environment was retraced and reselected.
    pub sources: usize,
    /// Number of these whose cut differs from the stored one.
    pub different_source_environment_cuts: usize,
    /// Whether the cuts agree.
    #[serde(skip)]
    pub agrees: bool,
}

impl SourcesVerification {
    /// Checks a dataset with or without sources.
    pub(super) fn of(again: &Again) -> Self {
        let dataset = again.dataset;
        let Some(indirect) = &dataset.indirect else { return Self { agrees: true, ..Self::default() } };
        let vertices = &again.vertices[..again.vertices.len().min(SOURCE_VERTICES)];
        let checked = check_vertices(again, indirect, vertices);
        let environments = check_environments(again, indirect);
        let rms = |of: usize| {
            relative_rms(&checked.iter().map(|c| (c.squared_errors[of], c.squared_norm)).collect::<Vec<_>>())
        };
        let [source_error, exhaustive_source_error] = [0, 1].map(rms);
        let different_source_cuts = checked.iter().filter(|c| !c.is_equal).count();
        let pairs = (vertices.len() * indirect.sources.len()).max(1);
        let few = vertices.len() < ENOUGH;
        let agrees = (different_source_cuts == 0 || dataset.report.updates > 0)
            && (few || source_error <= MOST_ERROR_OF_FEW * exhaustive_source_error)
            && agree(&environments, dataset.tree.len() as f64, &dataset.report);
        Self {
            source_vertices: vertices.len(),
            different_source_cuts,
            sources_wrong: checked.iter().map(|c| c.wrong).sum::<usize>() as f64 / pairs as f64,
            source_error,
            exhaustive_source_error,
            sources: environments.len(),
            different_source_environment_cuts: different(&environments),
            agrees,
        }
    }

    /// The result in sentences, one per line.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        if self.source_vertices > 0 {
            text += &format!(
                "traced the sources from {} vertices again: {} cuts differ\n",
                self.source_vertices, self.different_source_cuts
            );
        }
        if self.sources_wrong > 0.0 {
            text += &format!(
                "boundaries have missed {:.3} % of these sources; the error of solid angles is {:.2} %, of all that was \
                 traced {:.2} %\n",
                100.0 * self.sources_wrong,
                100.0 * self.source_error,
                100.0 * self.exhaustive_source_error
            );
        }
        if self.sources > 0 {
            text += &format!(
                "traced the environment from {} sources again: {} cuts differ\n",
                self.sources, self.different_source_environment_cuts
            );
        }
        text
    }
}

/// A recomputed cut over the sources.
struct CheckedSourceCut {
    is_equal: bool,
    wrong: usize,
    /// Squared errors of the stored cut and of an exhaustive bake's.
    squared_errors: [f64; 2],
    squared_norm: f64,
}

fn check_vertices(again: &Again, indirect: &IndirectBake, vertices: &[usize]) -> Vec<CheckedSourceCut> {
    let Again { dataset, points, intersector, surface, .. } = again;
    let report = dataset.report.indirect.as_ref();
    let (count, height) = (indirect.sources.len(), indirect.sources.len().ilog2());
    let sources_per_probe = report.map_or(EXHAUSTIVE, IndirectReport::sources_per_probe);
    let sampler = SourceSampler::new(intersector, &indirect.sources, surface.offset(), sources_per_probe);
    let asked = dataset.settings.indirect.criterion;
    let kept = report.map_or(asked, |report| report.criterion(asked));
    let places = points.for_sources(&dataset.scene.mesh, intersector, &dataset.settings.shots);
    let check = |&vertex: &usize| {
        let place = &places[points.of_vertex[vertex] as usize];
        let (mut traced, mut seen) = (vec![0.0; count], vec![0.0; count]);
        sampler.sample_singly(place, &mut traced);
        sampler.sample_again(place, &mut seen);
        let cut_of = |leaves: &[f32]| {
            let mut cut = Vec::new();
            SourceCutSelector::new(height, asked).select(leaves, &mut cut);
            if kept == asked { cut } else { prune_sources(height, kept, &cut) }
        };
        let stored = indirect.cuts.cut(height, vertex as u32);
        CheckedSourceCut {
            is_equal: cut_of(&seen) == stored,
            wrong: traced.iter().zip(&seen).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).count(),
            squared_errors: [stored, &cut_of(&traced)].map(|cut| solid_angle_error(height, cut, &traced)),
            squared_norm: squared_norm(&traced),
        }
    };
    vertices.par_iter().map(check).collect()
}

/// Recomputes some of the sources' cuts over the environment.
fn check_environments(again: &Again, indirect: &IndirectBake) -> Vec<Checked> {
    let Again { dataset, sampler, surface, count, .. } = again;
    if !dataset.settings.mode.environment() {
        return Vec::new();
    }
    let check = |source: &usize| {
        let point = BakePoint::of_surfel(indirect.sources[*source].surfel, surface.offset());
        check_cut(dataset, sampler, &point, indirect.environment_cuts.cut(dataset.tree.height(), *source as u32))
    };
    let count = (*count).min(SOURCES).min(indirect.sources.len());
    let picked = again.random().choose_multiple(0..indirect.sources.len(), count);
    picked.par_iter().map(check).collect()
}
