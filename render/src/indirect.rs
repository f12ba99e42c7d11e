//! Bounced light from surface sources (paper, 4.1): local lights and environment on the sources, their radiosity under
//! the current materials, means up their tree and the illumination cut. The merge then gathers it at every pixel.
//!
//! All steps are kept apart, so that a moved light casts rays for that light only and an edited material none.

mod irradiance;

use crate::{appearance::Appearance, baked::Baked, lighting::SceneLighting};
use glam::Vec3;
use irradiance::{environment_irradiance, light_irradiance};
use lapidary_core::{
    cut::illumination::{IlluminationCriterion, intensity_cut},
    dataset::Dataset,
    indirect::IndirectBake,
    lights::Light,
    ray::Intersector,
    source_tree::{SourceRadiance, SourceTree},
};
use rayon::prelude::*;
use std::{f32::consts::FRAC_1_PI, sync::Arc};

/// A source tree under one illumination.
#[derive(Clone, Debug)]
pub struct SourceLighting {
    /// Where the sources are.
    pub tree: Arc<SourceTree>,
    /// Radiance, centres and spreads by heap index.
    pub nodes: SourceRadiance,
    /// Packed illumination cut.
    pub cut: Vec<u16>,
    /// Most nodes that the illumination cut was allowed.
    pub max_nodes: u32,
}

impl SourceLighting {
    /// Means up the tree of `leaf_radiance` (one a source) and an illumination cut of at most `illum_cut` nodes.
    pub fn new(tree: Arc<SourceTree>, leaf_radiance: &[Vec3], illum_cut: u32) -> Self {
        let nodes = SourceRadiance::new(&tree, leaf_radiance);
        let criterion = IlluminationCriterion::with_budget(illum_cut);
        let cut = intensity_cut(&nodes.power, &nodes.power_sq, criterion);
        Self { tree, nodes, cut, max_nodes: illum_cut }
    }
}

/// Lights the sources of a dataset again and again: what an edit does not change is kept.
pub struct SourceRig {
    dataset: Arc<Dataset>,
    intersector: Arc<Intersector>,
    tree: Arc<SourceTree>,
    albedo: Vec<Vec3>,
    /// Lights with the irradiance that they give the sources, visibility included.
    groups: Vec<(Vec<Light>, Vec<Vec3>)>,
    environment: Option<Vec<Vec3>>,
    further: Option<Vec<Vec3>>,
}

/// Most groups of lights whose irradiance is kept apart; each takes 12 bytes a source.
const LIGHT_GROUPS: usize = 64;

impl SourceRig {
    /// For a dataset that looks as it was baked, in the dark; `None` if it has no sources.
    pub fn new(baked: &Baked) -> Option<Self> {
        let dataset = baked.dataset.clone();
        let tree = Arc::new(SourceTree::new(&dataset.indirect.as_ref()?.sources));
        let intersector = baked.intersector();
        let mut rig = Self {
            tree,
            intersector,
            albedo: Vec::new(),
            groups: Vec::new(),
            environment: None,
            further: None,
            dataset: dataset.clone(),
        };
        rig.set_appearance(&Appearance::of(&dataset.scene));
        Some(rig)
    }

    /// The sources.
    pub fn tree(&self) -> &Arc<SourceTree> {
        &self.tree
    }

    /// Gives the sources the reflectance of other materials; what does not fit looks as in the dataset.
    pub fn set_appearance(&mut self, appearance: &Appearance) {
        let scene = &self.dataset.scene;
        let (fitted, _) = appearance.fitted(&scene.materials);
        let albedo = |s: &lapidary_core::indirect::Source| fitted.albedo(&scene.mesh, s.surfel.place);
        self.albedo = self.tree.sources().par_iter().map(albedo).collect();
    }

    /// Shines local lights on the sources, by rays; only for those that are not as before.
    pub fn set_lights(&mut self, lights: &[Light]) {
        let lit: Vec<Light> = lights.iter().filter(|l| l.enabled).cloned().collect();
        let mut before = std::mem::take(&mut self.groups);
        let group = |lights: &[Light]| match before.iter().position(|(known, _)| known == lights) {
            Some(i) => before.swap_remove(i),
            None => (lights.to_vec(), light_irradiance(&self.tree, lights, &self.intersector, self.ray_offset())),
        };
        self.groups = lit.chunks(lit.len().div_ceil(LIGHT_GROUPS).max(1)).map(group).collect();
    }

    /// Shines the environment on the sources, or none.
    pub fn set_environment(&mut self, lighting: Option<&SceneLighting>) {
        self.environment = lighting.and_then(|lighting| environment_irradiance(self.bake()?, lighting));
    }

    /// Adds irradiance of further bounces, one value a source, or none.
    ///
    /// # Panics
    /// If there is not one value a source.
    pub fn set_further(&mut self, irradiance: Option<Vec<Vec3>>) {
        assert!(irradiance.as_ref().is_none_or(|i| i.len() == self.tree.len()), "one irradiance a source");
        self.further = irradiance;
    }

    /// Irradiance of the sources in W/m².
    pub fn irradiance(&self) -> Vec<Vec3> {
        let mut sum = vec![Vec3::ZERO; self.tree.len()];
        let parts = self.groups.iter().map(|(_, part)| part).chain(&self.environment).chain(&self.further);
        for part in parts {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        sum
    }

    /// What the sources send under the lights and materials that were set, with an illumination cut of at most
    /// `illum_cut` nodes.
    pub fn lighting(&self, illum_cut: u32) -> SourceLighting {
        let sent = self.irradiance().iter().zip(&self.albedo).map(|(e, rho)| rho * e * FRAC_1_PI).collect::<Vec<_>>();
        SourceLighting::new(self.tree.clone(), &sent, illum_cut)
    }

    fn bake(&self) -> Option<&IndirectBake> {
        self.dataset.indirect.as_ref()
    }

    /// Distance in metres that shadow rays start off a source.
    fn ray_offset(&self) -> f32 {
        1e-4 * self.dataset.scene.mesh.bounds().diagonal()
    }
}

#[cfg(test)]
pub(crate) mod tests;
