//! From scene and settings to dataset: everything that happens before an artist can relight (paper, 4.1; meshless
//! paper, 3.1).
//!
//! [`bake()`] runs the phases in order:
//!
//! * For the environment: tessellate where visibility varies, sample pilot visibility, and build the light tree. Trace
//!   from every bake point to the lights along the boundaries of visibility, and select its cut.
//! * For cuts over surface sources: place and cluster the sources. Trace from every bake point to the sources, and
//!   from every source to the lights.
//! * For the meshless basis: place its points, and compute the light transport between its functions.
//! * For light that is solved anew after a move: place functions on each object.
//! * For wavelet transport: find the quads, and compute the light transport between them.
//! * Pack everything.
//!
//! It reports through an [`Observer`], can be cancelled at any time, and leaves a checkpoint. It gives the same bits
//! for any number of threads and chunks.

mod bake;
mod errors;
mod meshless;
mod object_bases;
mod observer;
mod setting;
mod shard;
mod sources;
#[cfg(test)]
mod test_devices;
#[cfg(test)]
mod test_scenes;
mod trial;
mod unshadowed;
mod verify;
mod vertices;
mod warning;
pub mod wavelet;

pub use bake::{
    BakeJob, Geometry, bake, bake_on, bake_shard,
    checkpoint::{Chunk, Leftover, leftover},
    merge,
    settings::{Preset, ResolvedBake, resolve, with_room},
    update::{update, update_file},
};
pub use bake::{most_vertices, tessellation_units};
pub use errors::{BakeError, CheckpointError, CutsOf, ManifestError, PointsError, SettingsError, ShardError};
pub use meshless::{meshless_bake, points::place_basis};
pub use object_bases::place_object_bases;
pub use observer::{Event, Observer, Phase, Silent};
pub use setting::{Naming, Setting};
pub use shard::Shard;
pub use sources::{
    candidates::Candidates,
    disk::{Darts, poisson_disk},
    viewpoint::find_viewpoint,
};
pub use trial::{BasisTrial, BounceTrial, SourcesTrial, Trial};
pub use unshadowed::unshadowed;
pub use verify::{
    EnvironmentVerification, MeshlessVerification, ObjectBasesVerification, SourcesVerification, Verification,
    WaveletVerification, verify,
};
pub use vertices::{
    sampler::VertexSampler,
    sidedness::{Sidedness, classify},
    tessellate::{POINTS_PER_VERTEX, Stored},
};
pub use warning::{BasisWarning, SourcesWarning, Warning};
