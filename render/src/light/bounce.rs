//! Bounced light from surface sources (paper, 4.1): local lights and environment on the sources, their radiosity under the current
//! materials, means up their tree, and the illumination cut. The merge then gathers it at every pixel.
//!
//! Each step keeps its result: a moved light casts rays for that light only, an edited material casts none.

mod ends;
mod gloss;
mod irradiance;
mod light_groups;
mod lit_points;
pub(crate) mod meshless;
mod radiosity;
mod source_parts;
mod wavelet;

use crate::{
    baked::Baked,
    light::{
        situation::{Changes, Relight, Situation},
        tree_light::TreeLight,
    },
};
use glam::Vec3;
use gloss::{DiffuseParts, LampLight};
use irradiance::environment_irradiance;
use lapidary_core::{cut::lit::CutValues, dataset::Dataset, offset, sources::SourceTree};
use light_groups::LightGroup;
use source_parts::{PARTS, means, source_parts};
use std::{f32::consts::FRAC_1_PI, sync::Arc};

pub use gloss::{GlossRig, remark_on_widened_lobes};
pub(crate) use lit_points::LitPoints;
pub use meshless::{
    MeshlessRig,
    functions::{MeshlessLight, VerticesAsBaked},
};
pub use radiosity::{RadiosityRays, RadiosityRig};
pub use wavelet::{PatchLight, Quads, WaveletRig};

/// Samples of an area light along each of its sides, at each part of a source.
const AREA_SAMPLES: u32 = 2;

/// The light of a tree of surface sources.
pub type SourceLighting = TreeLight<Arc<SourceTree>>;

impl SourceLighting {
    /// Computes means up the tree from `leaf_radiance` (one value per source) and an illumination cut of at most
    /// `illum_cut` nodes.
    pub fn new(tree: Arc<SourceTree>, leaf_radiance: &[Vec3], illum_cut: u32) -> Self {
        let nodes = tree.light(leaf_radiance);
        Self::of(tree.clone(), nodes, tree.radii(), CutValues::SolidAngles, illum_cut)
    }
}

/// Lights the sources of a dataset repeatedly and keeps results that an edit does not change.
pub struct SourceRig {
    dataset: Arc<Dataset>,
    tree: Arc<SourceTree>,
    /// Points of the sources' surfaces, [`PARTS`] each.
    lit: LitPoints,
}

impl SourceRig {
    /// Starts with the baked materials and no light; `None` if the dataset has no sources.
    pub fn new(baked: &Baked) -> Option<Self> {
        let dataset = baked.dataset.clone();
        let sources = &dataset.indirect.as_ref()?.sources;
        let offset = offset::TRANSPORT * dataset.scene.mesh.bounds().diagonal();
        let lit = LitPoints::new(baked, source_parts(sources, baked.intersector(), offset), AREA_SAMPLES);
        Some(Self { tree: SourceTree::new(sources).into(), lit, dataset })
    }

    /// The sources.
    pub fn tree(&self) -> &Arc<SourceTree> {
        &self.tree
    }

    /// Irradiance of the sources in W/m².
    pub fn irradiance(&self) -> Vec<Vec3> {
        means(self.lit.irradiance().into_iter())
    }

    /// Radiosity of the sources under the current lights and materials, with an illumination cut of at most `illum_cut`
    /// nodes.
    pub fn lighting(&self, illum_cut: u32) -> SourceLighting {
        self.lighting_with(&[], illum_cut)
    }

    /// [`Self::lighting`] with irradiance of further bounces: one value per source, or none.
    ///
    /// # Panics
    /// If the number of values is neither zero nor the number of sources.
    pub fn lighting_with(&self, further: &[Vec3], illum_cut: u32) -> SourceLighting {
        assert!(further.is_empty() || further.len() == self.tree.len(), "one irradiance a source");
        let mut irradiance = self.lit.irradiance();
        for (parts, further) in irradiance.chunks_mut(PARTS).zip(further) {
            parts.iter_mut().for_each(|sum| *sum += further);
        }
        let reflected = irradiance.iter().zip(self.lit.albedo()).map(|(e, rho)| rho * e * FRAC_1_PI);
        let sent = reflected.zip(self.lit.emission()).map(|(reflected, emitted)| reflected + emitted);
        SourceLighting::new(self.tree.clone(), &means(sent), illum_cut)
    }

    /// The radiance of [`Self::lighting_with`], by where it comes from.
    fn diffuse_parts(&self, further: &[Vec3]) -> DiffuseParts {
        let reflected = |irradiance: Vec<Vec3>| {
            means(irradiance.into_iter().zip(self.lit.albedo()).map(|(e, rho)| rho * e * FRAC_1_PI))
        };
        let mut rest = self.lit.environment.clone().unwrap_or_else(|| vec![Vec3::ZERO; PARTS * self.tree.len()]);
        for (parts, further) in rest.chunks_mut(PARTS).zip(further) {
            parts.iter_mut().for_each(|sum| *sum += further);
        }
        DiffuseParts {
            lamps: reflected(self.lit.of_lamps()),
            rest: reflected(rest),
            emitted: means(self.lit.emission().iter().copied()),
        }
    }

    /// Irradiance of the sources from each group of lamps.
    fn lamp_light(&self) -> Vec<LampLight<'_>> {
        let groups = self.lit.lights.groups.iter();
        let irradiance = |group: &LightGroup| means(group.irradiance.iter().copied());
        groups.map(|group| LampLight { lights: group.lights(), irradiance: irradiance(group) }).collect()
    }
}

impl Relight for SourceRig {
    fn update(&mut self, situation: &Situation, changes: Changes) {
        self.lit.update((&situation.appearance, &situation.bouncing()), &situation.compute, changes);
        if changes.environment {
            let lighting = situation.environment.as_ref();
            let sources = lighting.and_then(|lighting| environment_irradiance(&self.dataset, lighting));
            self.lit.environment = sources.map(|sources| sources.into_iter().flat_map(|e| [e; PARTS]).collect());
        }
    }
}

#[cfg(test)]
mod tests;
