//! The meshless hierarchical basis: light on surfaces as a sum of smooth functions around scattered points, coarse to
//! fine.
//!
//! The method is from Lehtinen et al., *A Meshless Hierarchical Representation for Light Transport* (SIGGRAPH 2008),
//! cited here as "the meshless paper". Its input is only points with normals, of any kind of surface.
//!
//! * [`Functions`]: functions, range queries, normalized values (meshless paper, 2.1 and 2.2)
//! * [`Basis`]: those of a scene, of which some send light
//! * [`FunctionGrid`]: the functions that reach a point, in arrays that shaders can read
//! * [`Projection`]: coefficients of a function sampled at the points (2.1)
//! * [`SenderSamples`]: direct light on the senders, from the points of the next level
//! * [`Transport`]: the single-bounce operator (3.1) as `precompute` refined it
//! * [`Solver`]: direct light to indirect light at run time, bounce by bounce (3.3)
//! * [`Flattening`]: the solution at fixed points
//!
//! [`ObjectBases`] and [`Radiosity`] are from Zollhöfer and Stamminger, *Meshless Radiosity on the GPU* (2011), "meshless radiosity":
//! a basis that moves with its objects, and a solution without links.

mod basis;
mod flatten;
mod function_tree;
mod functions;
mod grid;
mod object_bases;
mod projection;
mod radiosity;
mod sampling;
mod solve;
mod transport;

pub use basis::{Basis, BasisError, MOST_LEVELS};
pub use flatten::Flattening;
pub use function_tree::FunctionTree;
pub use functions::{FunctionPlace, Functions};
pub use grid::{Cell, FunctionGrid};
pub use object_bases::{Carrier, ObjectBases, Owner, RayEnd};
pub use projection::Projection;
pub use radiosity::{
    ActiveFunctions, LitFunctions, Radiosity, RadiosityLight, RadiositySettings, RadiosityStep, ReceiverRays,
    TransportDevice,
};
pub use sampling::SenderSamples;
pub use solve::{Solution, SolveSettings, Solver};
pub use transport::{PackedLink, Transport, TransportError, irradiance};

/// A baked basis and its operator. Neither depends on reflectance.
#[derive(Clone, Debug)]
pub struct MeshlessBake {
    /// The functions; functions of the first levels are also senders.
    pub basis: Basis,
    /// One bounce from senders to receivers.
    pub transport: Transport,
}

impl MeshlessBake {
    /// Bytes of points and links, as stored.
    pub fn bytes(&self) -> u64 {
        self.basis.bytes() + self.transport.bytes()
    }
}

#[cfg(test)]
mod tests;
