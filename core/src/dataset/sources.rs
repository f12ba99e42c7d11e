//! Surface sources and their cuts in a dataset: settings, report and tensors.

use super::{
    BakeAudit, Dataset,
    error::{Damage, SurfelDamage},
    reader::Reader,
    stored::{StoredPart, is_size},
    tensors::{Tensor, cut_tensors, owned, surfel_tensors, tensor},
    validate::{check_cuts, check_surfel},
};
use crate::{
    bounds::is_within_reach,
    cut::SourceCriterion,
    light_tree::height_of,
    ray::is_number_per_probe,
    sources::{IndirectBake, Source},
    surfel::Surfel,
};
use glam::Vec3;
use safetensors::Dtype;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Largest area of a source in squares of the scene's diagonal, and spacing in diagonals. A scene may be folded.
const MOST_SOURCE_SIZE: f32 = 64.0;
/// Names of the tensors of the vertices' cuts over the sources.
const SOURCE_CUTS: [&str; 2] = ["source_cuts", "source_cut_offsets"];
/// Names of the tensors of the sources' cuts over the environment.
const SOURCE_ENVIRONMENT_CUTS: [&str; 2] = ["source_environment_cuts", "source_environment_cut_offsets"];
/// Settings of bounced light by surface sources.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndirectSettings {
    /// Number of surface sources, `2^H`, at most 32,768.
    pub sources: usize,
    /// Accuracy of the vertices' cuts over the sources.
    pub criterion: SourceCriterion,
    /// A point in the open that separates reachable surfaces from enclosed ones; `None` for the point of a camera or a
    /// local light, or a search.
    pub viewpoint: Option<Vec3>,
}

impl Default for IndirectSettings {
    fn default() -> Self {
        Self { sources: 32_768, criterion: SourceCriterion::default(), viewpoint: None }
    }
}

/// Report of the bake of the surface sources.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct IndirectReport {
    /// The viewpoint of the bake.
    pub viewpoint: [f32; 3],
    /// Number of surface sources.
    pub sources: usize,
    /// Smallest distance of any two in position and normal, in meters.
    pub radius: f32,
    /// Largest spacing of the sources; 0 for a dataset with equal spacing.
    pub widest_spacing: f32,
    /// Total area of the sources in m²: the surface that light reaches.
    pub area: f64,
    /// Number of sources without area, which bounce no light.
    pub without_area: usize,
    /// Mean number of nodes of a bake point's cut over the sources.
    pub mean_cut: f64,
    /// Largest of these cuts.
    pub max_cut: usize,
    /// Root mean square of `||stored - traced|| / ||traced||` of solid angles over the bake points, which vertices may share.
    /// Measured along boundaries ([`Self::audit`] covers missed ones), before cuts were coarsened to fit a texture.
    pub relative_error: f64,
    /// Factor by which these cuts' bounds were raised to fit a texture, if any.
    pub coarsened: Option<f32>,
    /// Mean number of nodes of a source's cut over the environment.
    pub mean_environment_cut: f64,
    /// Bytes of both kinds of cuts.
    pub bytes_cuts: u64,
    /// Rays traced between vertices and sources, and around vertices for near ones.
    pub rays_traced: u64,
    /// Errors of following boundaries between distant sources; `None` for an exhaustive bake.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<BakeAudit>,
}

impl IndirectReport {
    /// Sources per probe in tracing distant sources, 1 if every source is traced.
    pub fn sources_per_probe(&self) -> usize {
        self.audit.map_or(1, |audit| audit.leaves_per_probe)
    }

    /// The criterion that the cuts over the sources meet, for a requested one.
    pub fn criterion(&self, asked: SourceCriterion) -> SourceCriterion {
        self.coarsened.map_or(asked, |factor| asked.coarser(factor))
    }
}

/// Surface sources in a dataset.
pub(super) struct StoredSources;

impl StoredPart for StoredSources {
    fn is_in(&self, dataset: &Dataset) -> bool {
        dataset.indirect.is_some()
    }

    fn tensors<'a>(&self, dataset: &'a Dataset) -> Vec<Tensor<'a>> {
        dataset.indirect.as_ref().map_or_else(Vec::new, tensors)
    }

    fn read(&self, reader: &Reader, dataset: &mut Dataset) -> Result<(), Damage> {
        let reported = dataset.report.indirect.as_ref().map_or(0.0, |report| report.radius);
        dataset.indirect = reader.indirect(dataset.scene.mesh.positions.len(), reported)?;
        Ok(())
    }

    fn settings(&self, dataset: &Dataset) -> Vec<(&'static str, bool)> {
        let IndirectSettings { criterion, viewpoint, sources: _ } = &dataset.settings.indirect;
        let report = dataset.report.indirect.as_ref();
        vec![
            ("sigma of the sources", is_size(criterion.sigma)),
            ("contrast of the sources", is_size(criterion.contrast)),
            ("largest solid angle", is_size(criterion.max_solid_angle)),
            ("viewpoint", viewpoint.is_none_or(is_within_reach)),
            ("sources per probe", report.is_none_or(|report| is_number_per_probe(report.sources_per_probe()))),
        ]
    }

    fn check(&self, dataset: &Dataset) -> Result<(), Damage> {
        dataset.indirect.as_ref().map_or(Ok(()), |bake| check(dataset, bake))
    }
}

/// The tensors of an indirect bake.
fn tensors(bake: &IndirectBake) -> Vec<Tensor<'_>> {
    let n = bake.sources.len();
    let areas: Vec<f32> = bake.sources.iter().map(|s| s.area).collect();
    let spacings: Vec<f32> = bake.sources.iter().map(|s| s.spacing).collect();
    let mut tensors = Vec::from(surfel_tensors("source", bake.sources.iter().map(|s| s.surfel)));
    tensors.extend([
        owned(tensor("source_areas", Dtype::F32, [n], &areas)),
        owned(tensor("source_spacings", Dtype::F32, [n], &spacings)),
    ]);
    tensors.extend(cut_tensors(SOURCE_CUTS, &bake.cuts));
    tensors.extend(cut_tensors(SOURCE_ENVIRONMENT_CUTS, &bake.environment_cuts));
    tensors
}

impl Reader<'_> {
    /// The indirect bake, if there is one. `reported` is the spacing of sources without a stored one.
    fn indirect(&self, vertices: usize, reported: f32) -> Result<Option<IndirectBake>, Damage> {
        if !self.has("source_positions") {
            return Ok(None);
        }
        let sources = self.sources(reported)?;
        let cuts = self.cuts(SOURCE_CUTS, vertices)?;
        let environment_cuts = self.cuts(SOURCE_ENVIRONMENT_CUTS, sources.len())?;
        Ok(Some(IndirectBake { sources, cuts, environment_cuts }))
    }

    fn sources(&self, reported: f32) -> Result<Vec<Source>, Damage> {
        let surfels = self.surfels("source")?;
        let n = Some(surfels.len());
        let areas: Vec<f32> = self.array("source_areas", Dtype::F32, &[], n)?;
        let spacings = match self.has("source_spacings") {
            true => self.array("source_spacings", Dtype::F32, &[], n)?,
            false => vec![even_spacing(reported, &areas); surfels.len()],
        };
        let source = |(i, surfel): (usize, Surfel)| Source { surfel, area: areas[i], spacing: spacings[i] };
        Ok(surfels.into_iter().enumerate().map(source).collect())
    }
}

/// Spacing of sources without a stored one: the reported one, or else the side of a square of their mean area, which is
/// about as long.
fn even_spacing(reported: f32, areas: &[f32]) -> f32 {
    let mean_area = areas.iter().sum::<f32>() / areas.len().max(1) as f32;
    if reported > 0.0 { reported } else { mean_area.sqrt() }
}

fn check(dataset: &Dataset, bake: &IndirectBake) -> Result<(), Damage> {
    let mesh = &dataset.scene.mesh;
    let (count, diagonal) = (bake.sources.len(), mesh.bounds().diagonal());
    let height = height_of(count).map_err(|_| Damage::of_part(SourceDamage::Count(count)))?;
    for (index, source) in bake.sources.iter().enumerate() {
        check_surfel(&source.surfel, mesh.triangles.len())
            .map_err(|source| Damage::of_part(SourceDamage::Place { index, source }))?;
        let &Source { area, spacing, .. } = source;
        let fits = |size: f32, scene: f32| size >= 0.0 && size <= MOST_SOURCE_SIZE * scene;
        if !(fits(area, diagonal * diagonal) && fits(spacing, diagonal)) {
            return Err(Damage::of_part(SourceDamage::Size { index, area, spacing, diagonal }));
        }
    }
    check_cuts(SOURCE_CUTS[0], &bake.cuts, height, mesh.positions.len())?;
    check_cuts(SOURCE_ENVIRONMENT_CUTS[0], &bake.environment_cuts, dataset.tree.height(), count)
}

/// Errors of surface sources.
#[derive(Debug, Error, PartialEq)]
pub(super) enum SourceDamage {
    /// Their number is not a power of two.
    #[error("{0} surface sources do not form a complete binary tree")]
    Count(usize),
    /// The place of a source is invalid.
    #[error("surface source {index} {source}")]
    Place {
        /// Index of the source.
        index: usize,
        /// The problem.
        source: SurfelDamage,
    },
    /// The size of a source is invalid.
    #[error(
        "surface source {index} has an area of {area} m² and a spacing of {spacing} m; both must be 0 or more and fit the \
         scene, which is {diagonal} m large"
    )]
    Size {
        /// Index of the source.
        index: usize,
        /// Its area in m².
        area: f32,
        /// Its spacing in meters.
        spacing: f32,
        /// Diagonal of the scene in meters.
        diagonal: f32,
    },
}
