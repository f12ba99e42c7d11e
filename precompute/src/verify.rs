//! Verification: retraces a random set of vertices and surface sources ray by ray, and compares with the stored cuts. It also
//! recomputes the links of some meshless functions, and looks where the functions of objects lie. Each part of a bake has its file.

mod environment;
mod meshless;
mod object_bases;
mod sources;
mod wavelet;

pub use environment::EnvironmentVerification;
pub use meshless::MeshlessVerification;
pub use object_bases::ObjectBasesVerification;
pub use sources::SourcesVerification;
pub use wavelet::WaveletVerification;

use crate::vertices::{points::BakePoints, sampler::bake_points, visibility::VisibilitySampler};
use glam::Vec3;
use lapidary_core::{dataset::Dataset, mesh_surface::MeshSurface, ray::Intersector};
use serde::Serialize;

/// Largest root mean square of stored minus traced visibility, relative to an exhaustive bake's. The bake's audit allows 1 % over
/// more vertices.
const MOST_ERROR_OF_FEW: f64 = 1.1;
/// Results of a verification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// Results for the vertices' cuts over the environment.
    #[serde(flatten)]
    pub environment: EnvironmentVerification,
    /// Results for the surface sources.
    #[serde(flatten)]
    pub sources: SourcesVerification,
    /// Results for the meshless basis, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meshless: Option<MeshlessVerification>,
    /// Results for the bases of objects, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object_bases: Option<ObjectBasesVerification>,
    /// Results for wavelet transport, if there is any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelet: Option<WaveletVerification>,
    /// Whether anything was recomputed, all cuts and links agree, and cuts are hardly worse than an exhaustive bake's.
    pub passed: bool,
}

impl Verification {
    /// The result in sentences, one per line.
    pub fn text(&self) -> String {
        let is_of_others = self.sources.source_vertices > 0
            || self.meshless.is_some()
            || self.object_bases.is_some()
            || self.wavelet.is_some();
        let has_environment = self.environment.vertices > 0 || !is_of_others;
        let environment = if has_environment { self.environment.text() } else { String::new() };
        let meshless = self.meshless.as_ref().map_or(String::new(), MeshlessVerification::text);
        let object_bases = self.object_bases.as_ref().map_or(String::new(), ObjectBasesVerification::text);
        let wavelet = self.wavelet.as_ref().map_or(String::new(), WaveletVerification::text);
        environment + &self.sources.text() + &meshless + &object_bases + &wavelet
    }
}

/// Inputs of a verification.
struct Again<'a> {
    dataset: &'a Dataset,
    points: BakePoints,
    intersector: &'a Intersector,
    surface: MeshSurface<'a>,
    sampler: VisibilitySampler<'a>,
    /// Vertices to retrace.
    vertices: Vec<usize>,
    /// Most items of each kind to recompute.
    count: usize,
}

impl Again<'_> {
    /// Random numbers from the scene's hash: the same scene is verified at the same places.
    fn random(&self) -> fastrand::Rng {
        let hash = self.dataset.scene_hash.get(..16).unwrap_or("0");
        fastrand::Rng::with_seed(u64::from_str_radix(hash, 16).unwrap_or(0))
    }
}

/// Retraces `count` vertices without packets, chosen by a seed from the scene's hash, and at most as many surface sources.
/// Recomputes the links of at most as many functions.
pub fn verify(dataset: &Dataset, count: usize) -> Verification {
    let mesh = &dataset.scene.mesh;
    let intersector = Intersector::of_scene(&dataset.scene);
    let black = |_: &_| Vec3::ZERO;
    let mut again = Again {
        dataset,
        points: bake_points(dataset),
        intersector: &intersector,
        surface: MeshSurface::new(mesh, &intersector, &dataset.two_sided, &black),
        sampler: VisibilitySampler::new(&intersector, &dataset.tree, dataset.report.lights_per_probe()),
        vertices: Vec::new(),
        count,
    };
    again.vertices = again.random().choose_multiple(0..mesh.positions.len(), count.min(mesh.positions.len()));
    let (environment, sources) = (EnvironmentVerification::of(&again), SourcesVerification::of(&again));
    let meshless = MeshlessVerification::of(&again);
    let (object_bases, wavelet) = (ObjectBasesVerification::of(&again), WaveletVerification::of(&again));
    let functions =
        meshless.as_ref().map_or(0, |m| m.functions) + object_bases.as_ref().map_or(0, |o| o.object_functions);
    let pairs = wavelet.as_ref().map_or(0, |wavelet| wavelet.pairs);
    let made = environment.vertices + sources.source_vertices + sources.sources + functions + pairs;
    let agrees = environment.agrees
        && sources.agrees
        && meshless.as_ref().is_none_or(MeshlessVerification::agrees)
        && object_bases.as_ref().is_none_or(ObjectBasesVerification::agrees)
        && wavelet.as_ref().is_none_or(WaveletVerification::agrees);
    Verification { environment, sources, meshless, object_bases, wavelet, passed: made > 0 && agrees }
}

#[cfg(test)]
mod tests;
