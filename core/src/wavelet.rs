//! Wavelet radiance transport (Kontkanen, Turquin, Holzschuch and Sillion, *Wavelet Radiance Transport for Interactive
//! Indirect Lighting*, EGSR 2006), cited as "the wavelet paper".
//!
//! Incident radiance lies on quads ([`patch`]). A point of a quad and a direction of its hemisphere are each a point of a
//! unit square, so radiance is a function of two squares. Its basis is the product of Haar wavelets of both ([`square`],
//! 4.1). Light transport is a sparse matrix between such functions ([`operator`], 4.2 and 4.3), and all bounces are the
//! Neumann series of that matrix ([`series`], 4.4). At run time direct light is projected to the basis ([`direct`], 5.1), sent through
//! the matrices, and synthesized as textures of the quads ([`picture`], 5.4).

pub mod direct;
pub mod operator;
pub mod patch;
pub mod picture;
pub mod reflecting;
pub mod series;
pub mod square;

use glam::Vec3;
use operator::{Operator, RadianceBasis};
use reflecting::ReflectingPatch;

/// Transport between the patches of a scene: of one bounce and of all.
#[derive(Clone, Debug)]
pub struct WaveletTransport {
    /// The patches.
    pub patches: Vec<ReflectingPatch>,
    /// Functions of radiance on them.
    pub basis: RadianceBasis,
    /// One bounce, as fine as it was computed.
    pub direct: Operator,
    /// All bounces, compressed.
    pub global: Operator,
}

impl WaveletTransport {
    /// Radiance that arrives after one bounce or more, for radiance that arrives from lamps. The last bounce is as fine as it was
    /// computed ("gathered", 4.4).
    pub fn indirect(&self, direct: &[Vec3]) -> Vec<Vec3> {
        self.direct.apply(&self.global.apply(direct))
    }
}
