//! Everything that decides the result of a bake.

use super::{BakeParts, IndirectSettings, MeshlessSettings};
use crate::{cut::CutCriterion, ground::Ground, light_tree::TreeKind, shot::Shot};
use serde::{Deserialize, Serialize};

/// Everything that decides the result of a bake. Threads and chunks do not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BakeSettings {
    /// Number of light samples, `2^H`, at most 32,768.
    pub lights: usize,
    /// Clustering metric of the light tree.
    pub tree: TreeKind,
    /// Weight of the geometric metric in a mixed tree, 0 to 1.
    pub beta: f32,
    /// How fine the visibility cuts are.
    pub criterion: CutCriterion,
    /// Vertex clusters of the pilot visibility, `M`.
    pub pilot_clusters: usize,
    /// The ground under the scene. It gets a fifth of [`Self::max_vertices`] beside those of the scene.
    #[serde(default)]
    pub ground: Ground,
    /// Most vertices after tessellation; `None` leaves the mesh as it is.
    pub max_vertices: Option<usize>,
    /// Whether further vertices are spread evenly, without asking where visibility varies: for a first look.
    #[serde(default)]
    pub even_vertices: bool,
    /// Pictures for which most vertices are placed; empty for a bake that serves all views alike.
    #[serde(default)]
    pub shots: Vec<Shot>,
    /// Largest size in bytes of the vertices' cuts over the environment, which are coarsened by a common `sigma` until
    /// they fit. It does not limit surface sources and the meshless basis.
    pub max_bytes: Option<u64>,
    /// Whether every light and surface source is traced from every vertex, where otherwise boundaries are followed
    /// ([`crate::ray::BoundarySet`], [`crate::ray::SegmentSet`]).
    #[serde(default = "before_boundaries")]
    pub exhaustive: bool,
    /// Which parts are baked.
    #[serde(default)]
    pub mode: BakeParts,
    /// How the parts that bounce light are baked, if they are.
    #[serde(default)]
    pub indirect: IndirectSettings,
    /// How the meshless basis is baked, if it is.
    #[serde(default)]
    pub meshless: MeshlessSettings,
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
        }
    }
}

impl BakeSettings {
    /// Those of all bakes with the same contents: how a ground is shown is not baked.
    pub fn of_content(&self) -> Self {
        let ground = if self.ground == Ground::Off { Ground::Off } else { Ground::Shadow };
        Self { ground, ..self.clone() }
    }
}

/// Datasets before version 5 do not say how they were traced.
fn before_boundaries() -> bool {
    true
}
