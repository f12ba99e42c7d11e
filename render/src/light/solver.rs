//! How bounced light is computed: by one solver for each [`solutions::Solution`]. A new one is a file beside these and its line in
//! [`solutions`].
//!
//! A solver takes the [`Situation`] and what has changed of it since its last step, and keeps the light that the changes leave. What
//! pixels evaluate of it is one of few kinds ([`BounceLight`]), so that a renderer knows no solver.
//!
//! Implicit visibility ([`super::implicit`]) is none of them: it also changes the light of the environment, and what it changes of
//! bounced light is added to that of any solver as it was baked.

mod cuts;
mod cuts_over_meshless;
#[cfg(test)]
mod even;
mod meshless;
pub(crate) mod rigs;
pub(crate) mod solutions;

use super::{
    bounce::{MeshlessLight, SourceLighting},
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
    /// Functions of the meshless basis.
    Functions(Arc<MeshlessLight>),
}

/// Computes bounced light. It works when it is asked to, so that a solver that is not shown costs nothing.
pub trait BounceSolver: Send {
    /// Does the next step, such as one bounce, in a situation of which `changes` are new since the last step; the first time all
    /// are. Returns whether more is left to do. Between steps a caller may look at the clock, and show what there is.
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool;

    /// The light so far.
    fn light(&self) -> Option<BounceLight>;

    /// How its bounces decrease, if it has several.
    fn energy(&self) -> Option<BounceEnergy> {
        None
    }
}
