//! Scene and settings to dataset: everything that happens before an artist can relight (paper, 4.1; meshless paper, 3.1).
//!
//! [`bake()`] runs the phases in order: tessellate where visibility varies, sample pilot visibility, build the light tree,
//! trace every bake point against every light and select its cut. Then, if bounced light is asked for: place surface sources
//! and cluster them, trace every bake point against every source and every source against the environment; place the points
//! of the meshless basis and compute the light transport between its functions. Last, pack. It reports through an
//! [`Observer`], can be cancelled at any time, leaves a checkpoint, and gives the same bits for any number of threads and
//! chunks.

mod bake;
mod bake_points;
mod checkpoint;
pub mod cli;
mod errors;
mod memory;
mod mesh_surface;
mod meshless;
mod observer;
mod pilot;
mod settings;
mod sidedness;
mod sources;
mod spread;
mod study;
mod surface_points;
mod tessellate;
mod threads;
mod transport;
mod verify;
mod vertex_sampler;
mod visibility;

pub use bake::{BakeJob, bake};
pub use checkpoint::{Leftover, leftover};
pub use errors::{BakeError, CheckpointError, PointsError, SettingsError};
pub use memory::available as available_memory;
pub use mesh_surface::MeshSurface;
pub use meshless::meshless_bake;
pub use observer::{Event, Observer, Phase, Silent};
pub use settings::{Preset, resolve, with_room};
pub use sidedness::{Sidedness, classify};
pub use study::{Study, Variant};
pub use surface_points::{Candidates, Darts, find_viewpoint, poisson_disk};
pub use threads::on_threads;
pub use verify::{MeshlessVerification, Verification, verify};
pub use vertex_sampler::VertexSampler;
