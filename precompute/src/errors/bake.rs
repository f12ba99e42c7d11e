//! Errors of a bake.

use super::{checkpoint::CheckpointError, points::PointsError, settings::SettingsError};
use crate::shard::ShardError;
use crate::{
    observer::Observer,
    setting::{Naming, Setting},
};
use lapidary_core::{
    dataset::DatasetError, lock::LockError, meshless::BasisError, output::OutputError, scene::MeshError,
    wavelet::patch::NotAQuad,
};
use std::fmt;
use thiserror::Error;

/// Why a bake did not finish.
#[derive(Debug, Error)]
pub enum BakeError {
    /// The observer cancelled it.
    Cancelled,
    /// No surface for sources, or no viewpoint to find it from.
    Points(#[source] PointsError),
    /// The placed points form no meshless basis.
    Basis(#[from] BasisError),
    /// Objects are posed out of range.
    Pose(#[source] MeshError),
    /// Wavelet transport of a scene that does not consist of quads.
    Quads(#[from] NotAQuad),
    /// Settings out of range.
    Settings(#[from] SettingsError),
    /// Another bake writes the same output, or it cannot be written.
    Lock(#[from] LockError),
    /// The checkpoint cannot be used or written.
    Checkpoint(#[from] CheckpointError),
    /// The shards form no dataset.
    Shard(#[from] ShardError),
    /// The output path is not writable.
    Output(#[from] OutputError),
    /// The dataset cannot be written.
    Dataset(#[from] DatasetError),
    /// Not enough memory.
    Memory {
        /// Settings that reduce its size, besides the number of vertices.
        sizes: Vec<Setting>,
        /// Whether it has cuts; larger bounds reduce them.
        has_cuts: bool,
        /// Estimated need in MB.
        needed: u64,
        /// Free now, in MB.
        available: u64,
    },
    /// Cuts with more texels than a texture holds.
    TooManyTexels {
        /// The cuts.
        cuts: CutsOf,
        /// Texels needed.
        texels: usize,
        /// Texels of an 8192 x 8192 texture.
        limit: usize,
    },
}

/// Cuts that may exceed a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutsOf {
    /// Cuts of the vertices over the environment.
    Environment,
    /// Cuts of the vertices over the surface sources.
    Sources,
    /// Cuts of the surface sources over the environment.
    SourceEnvironment,
}

impl BakeError {
    /// The message, with settings named by `name`.
    pub fn text(&self, name: Naming) -> String {
        match self {
            Self::Cancelled => format!(
                "the bake was cancelled; bake again with {} to resume from the last finished chunk",
                name(Setting::Resume)
            ),
            Self::Points(error) => error.text(name),
            Self::Basis(error) => format!("the points on the surfaces form no meshless basis: {error}"),
            Self::Pose(error) => format!("the objects cannot be posed this way: {error}"),
            Self::Quads(error) => format!("{error}; leave wavelet transport out with {}", name(Setting::Mode)),
            Self::Settings(error) => error.text(name),
            Self::Lock(error) => error.to_string(),
            Self::Checkpoint(error) => error.text(name),
            Self::Shard(error) => error.to_string(),
            Self::Output(error) => error.to_string(),
            Self::Dataset(error) => error.to_string(),
            Self::Memory { sizes, has_cuts, needed, available } => format!(
                "the bake needs about {needed} MB of memory, {available} MB are free; {}, or close other programs",
                memory_remedy(sizes, *has_cuts, name)
            ),
            Self::TooManyTexels { cuts, texels, limit } => {
                let (cuts, remedy) = cuts.told(name);
                format!("{cuts} take {texels} texels, a texture holds {limit}; {remedy}")
            }
        }
    }
}

impl CutsOf {
    /// Description of these cuts, and the remedy for their size.
    fn told(self, name: Naming) -> (&'static str, String) {
        let [sigma, source_sigma] = [Setting::Sigma, Setting::SourceSigma].map(name);
        let [max_cut, vertices, sources] = [Setting::MaxCut, Setting::MaxVertices, Setting::Sources].map(name);
        match self {
            Self::Environment => {
                ("the cuts over the environment", format!("raise {sigma}, set {max_cut} or lower {vertices}"))
            }
            Self::Sources => ("the cuts over the surface sources", format!("raise {source_sigma} or lower {vertices}")),
            Self::SourceEnvironment => {
                ("the sources' cuts over the environment", format!("raise {sigma}, set {max_cut} or lower {sources}"))
            }
        }
    }
}

/// Remedy for the size of a bake with these size settings.
fn memory_remedy(sizes: &[Setting], has_cuts: bool, name: Naming) -> String {
    let vertices = name(Setting::MaxVertices);
    let sizes = sizes.iter().copied().map(name).collect::<Vec<_>>().join(" or ");
    match (has_cuts, sizes.is_empty()) {
        (_, true) => format!("lower {vertices} or raise the sigmas"),
        (false, false) => format!("lower {sizes} or {vertices}"),
        (true, false) => {
            format!("lower {vertices} or {sizes}, raise the sigmas, or leave a part out with {}", name(Setting::Mode))
        }
    }
}

impl fmt::Display for BakeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Setting::name))
    }
}

impl From<PointsError> for BakeError {
    fn from(error: PointsError) -> Self {
        match error {
            PointsError::Cancelled => Self::Cancelled,
            error => Self::Points(error),
        }
    }
}

/// An error if the job should stop.
pub fn cancelled(observer: &dyn Observer) -> Result<(), BakeError> {
    if observer.cancelled() { Err(BakeError::Cancelled) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_many_texels_are_told_with_the_settings_of_their_cuts() {
        for (cuts, setting, foreign) in [
            (CutsOf::Environment, "max cut", "source sigma"),
            (CutsOf::Sources, "source sigma", "max cut"),
            (CutsOf::SourceEnvironment, "lower sources", "source sigma"),
        ] {
            let text = BakeError::TooManyTexels { cuts, texels: 2, limit: 1 }.to_string();
            assert!(text.contains(setting) && !text.contains(foreign), "{text}");
        }
    }
}
