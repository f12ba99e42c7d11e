//! The same light without links: light that was not sent yet is gathered bounce by bounce (meshless paper, 5.1, and meshless
//! radiosity).

use crate::{aggregate::Aggregate, lamp::Lamp};
use anyhow::Result;
use glam::Vec3;
use lapidary_core::{
    meshless::{
        Basis, Carrier, LitFunctions, ObjectBases, Owner, Radiosity, RadiosityLight, RadiositySettings, RadiosityStep,
        irradiance,
    },
    surfel::{Surface, Surfel},
};
use rayon::prelude::*;

/// A solver of the scene's bounces, and its light so far.
pub struct Progressive<'a> {
    scene: &'a Aggregate,
    solver: Radiosity,
    direct: Vec<Vec3>,
    reflectance: Vec<Vec3>,
    light: RadiosityLight,
}

impl<'a> Progressive<'a> {
    /// Direct light of the lamp on the functions of a basis.
    pub fn new(basis: &Basis, scene: &'a Aggregate, lamp: &Lamp, settings: RadiositySettings) -> Result<Self> {
        let mut solver = Radiosity::new(by_part(basis, scene)?, settings);
        let points = solver.bases().points();
        let direct: Vec<Vec3> = points.par_iter().map(|point| lamp.irradiance(scene, point)).collect();
        let reflectance: Vec<Vec3> = points.iter().map(|point| scene.reflectance(point)).collect();
        let light = solver.begin(scene, &lit(&direct, &reflectance));
        Ok(Self { scene, solver, direct, reflectance, light })
    }

    /// Adds the next bounce. Returns whether more follow.
    pub fn bounce(&mut self) -> bool {
        let Self { scene, solver, direct, reflectance, light } = self;
        loop {
            match solver.advance(*scene, &lit(direct, reflectance), light, usize::MAX) {
                RadiosityStep::Partial => {}
                step => return step == RadiosityStep::Bounce,
            }
        }
    }

    /// The gathers so far.
    pub fn gathers(&self) -> u64 {
        self.light.gathers
    }

    /// Irradiance of all bounces so far at a point in W/m².
    pub fn at(&self, at: &Surfel) -> Vec3 {
        let vector = self.solver.bases().evaluate(self.scene.owner(at).object, at, &self.light.total);
        irradiance(&vector, at.normal)
    }
}

fn lit<'a>(direct: &'a [Vec3], reflectance: &'a [Vec3]) -> LitFunctions<'a> {
    const DARK: [Vec3; 0] = [];
    LitFunctions { direct, reflectance, emitted: &DARK, sky: None }
}

/// The functions of a basis, each part's own.
fn by_part(basis: &Basis, scene: &Aggregate) -> Result<ObjectBases> {
    let of_level = |level: usize| {
        let points = basis.points()[basis.level(level)].iter();
        let mut owned: Vec<(Surfel, Owner)> = points.map(|point| (*point, scene.owner(point))).collect();
        owned.sort_by_key(|(_, owner)| *owner);
        owned
    };
    let levels: Vec<_> = (0..basis.levels()).map(of_level).collect();
    Ok(ObjectBases::new(&levels, basis.radii().to_vec(), basis.levels().saturating_sub(2))?)
}
