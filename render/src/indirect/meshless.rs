//! Bounced light through the meshless basis: direct light on the points of the senders, some bounces through the operator,
//! and what arrives at the vertices, for display, or at the surface sources, for the bounce that cuts gather.

use super::{irradiance::environment_irradiance_of, lit_points::LitPoints};
use crate::{appearance::Appearance, baked::Baked, lighting::SceneLighting};
use glam::{Mat3A, Vec3};
use lapidary_core::{
    dataset::Dataset,
    lights::Light,
    meshless::{Flattening, MeshlessBake, Solution, SolveSettings, Solver, irradiance},
    surfel::Surfel,
};
use rayon::prelude::*;
use std::sync::Arc;

/// Vector irradiance of bounced light in W/m², one a vertex, a column a colour channel.
pub type VertexIrradiance = Vec<Mat3A>;

/// Solves for the bounces of a dataset again and again: what an edit does not change is kept.
pub struct MeshlessRig {
    dataset: Arc<Dataset>,
    solver: Solver,
    senders: LitPoints,
    /// Weights of the vertices, and of the sources if there are any; found at the first use.
    at_vertices: Option<Flattening>,
    at_sources: Option<Flattening>,
    solved: Option<Solution>,
}

impl MeshlessRig {
    /// For a dataset that looks as it was baked, in the dark; `None` if it has no meshless basis.
    pub fn new(baked: &Baked) -> Option<Self> {
        let dataset = baked.dataset.clone();
        let bake = dataset.meshless.as_ref()?;
        let solver = Solver::new(bake);
        let senders = LitPoints::new(baked, bake.basis.points()[bake.basis.senders()].to_vec());
        Some(Self { solver, senders, at_vertices: None, at_sources: None, solved: None, dataset })
    }

    /// Gives the senders the reflectance of other materials.
    pub fn set_appearance(&mut self, appearance: &Appearance) {
        self.senders.set_appearance(appearance);
        self.solved = None;
    }

    /// Shines local lights on the senders, by rays; only for those that are not as before.
    pub fn set_lights(&mut self, lights: &[Light]) {
        self.senders.set_lights(lights);
        self.solved = None;
    }

    /// Shines the environment on the senders, or none.
    pub fn set_environment(&mut self, lighting: Option<&SceneLighting>) {
        let shine = |lighting| environment_irradiance_of(self.senders.points(), &self.dataset, lighting);
        let irradiance = lighting.map(shine);
        self.senders.set_environment(irradiance);
        self.solved = None;
    }

    /// What arrives at the vertices after all bounces.
    pub fn at_vertices(&mut self) -> Option<VertexIrradiance> {
        let bake = self.solve()?;
        let solved = self.solved.as_ref()?;
        let mesh = &self.dataset.scene.mesh;
        let vertices = || mesh.positions.iter().copied().zip(mesh.normals.iter().copied()).collect::<Vec<_>>();
        let make =
            || Flattening::new(&bake.meshless.as_ref()?.basis, &bake.meshless.as_ref()?.transport, &vertices()).into();
        if self.at_vertices.is_none() {
            self.at_vertices = make();
        }
        Some(self.at_vertices.as_ref()?.apply(&solved.coefficients))
    }

    /// Irradiance of all bounces at the surface sources.
    pub fn at_sources(&mut self, sources: &[Surfel]) -> Option<Vec<Vec3>> {
        let dataset = self.solve()?;
        let solved = self.solved.as_ref()?;
        if self.at_sources.is_none() {
            let MeshlessBake { basis, transport } = dataset.meshless.as_ref()?;
            let points: Vec<_> = sources.iter().map(|s| (s.position, s.normal)).collect();
            self.at_sources = Some(Flattening::new(basis, transport, &points));
        }
        let vectors = self.at_sources.as_ref()?.apply(&solved.coefficients);
        let received = |(vector, source): (&Mat3A, &Surfel)| irradiance(vector, source.normal).max(Vec3::ZERO);
        Some(vectors.par_iter().zip(sources).map(received).collect())
    }

    fn solve(&mut self) -> Option<Arc<Dataset>> {
        let dataset = self.dataset.clone();
        if self.solved.is_none() {
            let (direct, albedo) = (self.senders.irradiance(), self.senders.albedo());
            let bake = dataset.meshless.as_ref()?;
            self.solved = Some(self.solver.solve(bake, &direct, albedo, SolveSettings::default()));
        }
        Some(dataset)
    }
}
