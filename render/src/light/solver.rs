//! How bounced light is computed: by one solver for each [`solutions::Solution`]. A new one is a file beside these and its line in
//! [`solutions`].
//!
//! A solver is told what lights the scene ([`Lit`]), each part only when it has changed, and keeps its light until then. What
//! pixels evaluate of it is one of few kinds ([`BounceLight`]), so that a renderer knows no solver.
//!
//! Implicit visibility ([`super::implicit`]) is none of them: it also changes the light of the environment, and what it changes of
//! bounced light is added to that of any solver as it was baked.

mod cuts;
mod cuts_over_meshless;
#[cfg(test)]
mod even;
mod lit_by;
mod meshless;
pub(crate) mod shared;
pub(crate) mod solutions;

use super::{
    bounce::{MeshlessLight, SourceLighting},
    environment::SceneLighting,
    implicit::Sides,
};
use crate::appearance::Appearance;
use lapidary_core::{lights::Light, scene::pose::Poses, transport::BounceEnergy};
use std::sync::Arc;

pub(super) use lit_by::{LitBy, Told};

/// Bounced light as pixels evaluate it.
#[derive(Clone, Debug)]
pub enum BounceLight {
    /// Irradiance at the vertices in W/m², interpolated between them.
    Vertices(Arc<Sides>),
    /// Surface sources, which cuts gather (paper, 4.1).
    Sources(Arc<SourceLighting>),
    /// Functions of the meshless basis.
    Functions(Arc<MeshlessLight>),
}

impl BounceLight {
    /// Whether both are the same light, not only equal.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Vertices(a), Self::Vertices(b)) => Arc::ptr_eq(a, b),
            (Self::Sources(a), Self::Sources(b)) => Arc::ptr_eq(a, b),
            (Self::Functions(a), Self::Functions(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// How cuts gather light from the trees of solvers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathering {
    /// Most nodes of an illumination cut.
    pub illum_cut: u32,
    /// Of lit cuts, see [`SourceLighting::with_tau`].
    pub tau: f32,
}

/// What is lit. It is told only what has changed since it was told last; at first, all that differs from the bake without light.
pub trait Lit {
    /// Poses the objects. What was baked stays as it was baked: implicit visibility adds what that changes.
    fn set_poses(&mut self, _poses: &Arc<Poses>) {}

    /// Gives the scene other materials.
    fn set_appearance(&mut self, appearance: &Arc<Appearance>);

    /// Sets the lights that bounce: local ones and suns.
    fn set_lights(&mut self, lights: &Arc<[Light]>);

    /// Shines the environment, or none.
    fn set_environment(&mut self, environment: Option<&Arc<SceneLighting>>);

    /// Sets how cuts gather its light.
    fn set_gathering(&mut self, _gathering: Gathering) {}
}

/// Computes bounced light. It works when it is asked to and not when it is told something, so that a solver that is not shown
/// costs nothing.
pub trait BounceSolver: Lit + Send {
    /// Does the next step of what is left to do, such as one bounce. Returns whether more is left. Between steps a caller may look
    /// at the clock, and show what there is.
    fn advance(&mut self) -> bool;

    /// The light so far; `None` before the first step after a change.
    fn light(&self) -> Option<BounceLight>;

    /// How its bounces decrease, if it has several.
    fn energy(&self) -> Option<BounceEnergy> {
        None
    }
}
