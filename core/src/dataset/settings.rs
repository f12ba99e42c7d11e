//! Settings that determine the result of a bake.

use super::{BakeParts, IndirectSettings, MeshlessSettings, ObjectBasesSettings, WaveletSettings};
use crate::{cut::CutCriterion, ground::Ground, light_tree::TreeKind, shot::Shot};
use serde::{Deserialize, Serialize};

/// Settings that determine the result of a bake. Threads and chunks do not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BakeSettings {
    /// Number of light samples, `2^H`, at most 32,768.
    pub lights: usize,
    /// Clustering metric of the light tree.
    pub tree: TreeKind,
    /// Weight of the geometric metric in a mixed tree, 0 to 1.
    pub beta: f32,
    /// Accuracy of the visibility cuts.
    pub criterion: CutCriterion,
    /// Vertex clusters of the pilot visibility, `M`.
    pub pilot_clusters: usize,
    /// The ground under the scene. It gets a fifth of [`Self::max_vertices`] in addition to the scene's.
    #[serde(default)]
    pub ground: Ground,
    /// Largest number of vertices after tessellation; `None` leaves the mesh unchanged.
    pub max_vertices: Option<usize>,
    /// Whether added vertices are spread evenly, regardless of visibility, for a first look.
    #[serde(default)]
    pub even_vertices: bool,
    /// Shots that get most vertices; empty for a bake that serves all views alike.
    #[serde(default)]
    pub shots: Vec<Shot>,
    /// Largest size in bytes of the vertices' cuts over the environment, which are coarsened by a common `sigma` until
    /// they fit. It does not limit surface sources and the meshless basis.
    pub max_bytes: Option<u64>,
    /// Whether every light and surface source is traced from every vertex, instead of following boundaries
    /// ([`crate::ray::BoundarySet`], [`crate::ray::SegmentSet`]).
    #[serde(default = "before_boundaries")]
    pub exhaustive: bool,
    /// The parts to bake.
    #[serde(default)]
    pub mode: BakeParts,
    /// Settings of bounced light by surface sources, if baked.
    #[serde(default)]
    pub indirect: IndirectSettings,
    /// Settings of the meshless basis, if baked.
    #[serde(default)]
    pub meshless: MeshlessSettings,
    /// Settings of the bases of objects, if baked.
    #[serde(default)]
    pub object_bases: ObjectBasesSettings,
    /// Settings of wavelet transport, if baked.
    #[serde(default)]
    pub wavelet: WaveletSettings,
}

impl Default for BakeSettings {
    /// The paper's 32,768 lights and sigma 2, a mixed tree, visibility of the environment alone.
    fn default() -> Self {
        Self {
            lights: 32_768,
            tree: TreeKind::Mixed,
            beta: 0.5,
            criterion: CutCriterion::default(),
            pilot_clusters: 1024,
            ground: Ground::Off,
            max_vertices: Some(100_000),
            even_vertices: false,
            shots: Vec::new(),
            max_bytes: None,
            exhaustive: false,
            mode: BakeParts::default(),
            indirect: IndirectSettings::default(),
            meshless: MeshlessSettings::default(),
            object_bases: ObjectBasesSettings::default(),
            wavelet: WaveletSettings::default(),
        }
    }
}

impl BakeSettings {
    /// The settings common to all bakes with the same contents: the look of the ground is not baked.
    pub fn of_content(&self) -> Self {
        let ground = if self.ground == Ground::Off { Ground::Off } else { Ground::Shadow };
        Self { ground, ..self.clone() }
    }
}

/// Datasets before version 5 do not record how they were traced.
fn before_boundaries() -> bool {
    true
}
