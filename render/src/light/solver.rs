//! Bounced light: one solver for each [`solutions::Solution`]. Add a solver as a file beside these, with a line in [`solutions`].
//!
//! A solver takes the [`Situation`] and its changes since the last step, and keeps the light that they leave valid. Pixels evaluate
//! one of a few kinds of light ([`BounceLight`]), so a renderer knows no solver.
//!
//! Implicit visibility ([`super::implicit`]) is not a solver: it also changes the environment's light, and it adds its change of
//! bounced light to any solver's light as baked.

mod cuts;
mod cuts_over_gloss;
mod cuts_over_meshless;
mod cuts_over_radiosity;
#[cfg(test)]
mod even;
mod meshless;
mod radiosity;
pub(crate) mod rigs;
pub(crate) mod solutions;
mod wavelet;

use super::{
    bounce::{MeshlessLight, PatchLight, SourceLighting},
    implicit::Sides,
    situation::{Changes, Situation},
};
use lapidary_core::transport::BounceEnergy;
use rigs::Rigs;
use std::sync::Arc;

/// Bounced light as pixels evaluate it.
#[derive(Clone, Debug)]
pub enum BounceLight {
    /// Irradiance at the vertices in W/m², interpolated between them.
    Vertices(Arc<Sides>),
    /// Surface sources, which cuts gather (paper, 4.1).
    Sources(Arc<SourceLighting>),
    /// Meshless functions.
    Functions(Arc<MeshlessLight>),
    /// Radiance by directions on quads.
    Patches(Arc<PatchLight>),
}

impl BounceLight {
    /// Whether two lights share their values.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Vertices(a), Self::Vertices(b)) => Arc::ptr_eq(a, b),
            (Self::Sources(a), Self::Sources(b)) => Arc::ptr_eq(a, b),
            (Self::Functions(a), Self::Functions(b)) => Arc::ptr_eq(a, b),
            (Self::Patches(a), Self::Patches(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// Computes bounced light on request, so a solver that is not shown costs nothing.
pub trait BounceSolver: Send {
    /// Computes the next step, such as one bounce. `changes` are all changes of `situation` since the last step; the first time
    /// everything is new. Returns whether more steps remain. Between steps a caller may check the time and show the current light.
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool;

    /// Light computed so far.
    fn light(&self) -> Option<BounceLight>;

    /// Energy of the successive bounces, if the solver has several.
    fn energy(&self) -> Option<BounceEnergy> {
        None
    }
}
