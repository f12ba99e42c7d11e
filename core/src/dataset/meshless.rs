//! The meshless basis and its operator on disk, with settings and report.
//!
//! Tensors (N functions, L levels, K links):
//!
//! | name | type | shape | |
//! |---|---|---|---|
//! | `meshless_positions`, `meshless_normals` | f32 | N, 3 | points of the functions, coarsest first |
//! | `meshless_triangles`, `meshless_barycentrics` | u32, f32 | N and N, 2 | where on the mesh they lie |
//! | `meshless_levels` | u32 | L + 1 | first function of each level, and the end of the last |
//! | `meshless_radii` | f32 | L | radius of support in meters |
//! | `meshless_sender_levels` | u32 | 1 | how many of the first levels send |
//! | `meshless_links` | u16 | K, 4 | receiver in its band, and vector irradiance as three signed steps |
//! | `meshless_link_offsets` | u32 | | first link of each (band of receivers, sender), and the end of the last |
//! | `meshless_link_scale` | f32 | 1 | vector irradiance of one step |

use super::{
    Dataset,
    error::{Damage, SurfelDamage},
    reader::Reader,
    stored::{StoredPart, is_size},
    tensors::{Tensor, owned, surfel_tensors, tensor},
    validate::check_surfel,
};
use crate::meshless::{Basis, BasisError, MeshlessBake, PackedLink, Transport, TransportError};
use safetensors::Dtype;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Largest vector irradiance of one step of a stored link. A sender of unit radiance that fills the sphere gives 4π
/// over 32,767 steps, and children may cancel their parents.
const MOST_LINK_SCALE: f32 = 64.0 / 32_767.0;
/// Largest number of rays in a gather.
const MOST_RAYS: usize = 65_536;

/// Settings of a meshless bake.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshlessSettings {
    /// Levels of functions, 1 to 8; each has about four times as many as the one before.
    pub levels: usize,
    /// Number of leading levels that send, at most `levels`.
    pub sender_levels: usize,
    /// Distance of the coarsest level's points in meters; `None` for a distance that gives about [`Self::COARSEST_FUNCTIONS`].
    pub coarse_radius: Option<f32>,
    /// Rays of each gather, 16 or more; they limit noise.
    pub rays: usize,
    /// Threshold of links, 0 to 1. A link is kept above this share of its sender's irradiance, for a reflectance of
    /// 0.38. Smaller is finer.
    pub epsilon: f32,
}

impl MeshlessSettings {
    /// The paper's scenes have 176 to 339.
    pub const COARSEST_FUNCTIONS: usize = 300;

    /// Estimated number of functions: each level has four times as many as the one before.
    pub fn expected_functions(&self) -> u64 {
        Self::COARSEST_FUNCTIONS as u64 * ((1 << (2 * self.levels)) - 1) / 3
    }
}

impl Default for MeshlessSettings {
    /// The paper's settings. Its table says 3 sender levels, but its links and their share imply some 16,000 senders,
    /// four levels of its sizes.
    fn default() -> Self {
        Self { levels: 6, sender_levels: 4, coarse_radius: None, rays: 512, epsilon: 0.025 }
    }
}

/// Report of a meshless bake.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MeshlessReport {
    /// The viewpoint of the bake.
    pub viewpoint: [f32; 3],
    /// Distance of the coarsest level's points in meters.
    pub coarse_radius: f32,
    /// Functions of each level.
    pub functions: Vec<usize>,
    /// Number of functions in the sending levels.
    pub senders: usize,
    /// Receivers of each level that gathered light; the others have no parent in need of detail.
    pub gathered: Vec<usize>,
    /// Kept links of each level's receivers.
    pub links_of_level: Vec<usize>,
    /// Kept links in total.
    pub links: usize,
    /// Kept links as a share of the product of senders and receivers.
    pub share: f64,
    /// Rays traced.
    pub rays_traced: u64,
    /// Bytes of links.
    pub bytes_links: u64,
    /// Bytes of points.
    pub bytes_points: u64,
}

/// The meshless basis in a dataset.
pub(super) struct StoredBasis;

impl StoredPart for StoredBasis {
    fn is_in(&self, dataset: &Dataset) -> bool {
        dataset.meshless.is_some()
    }

    fn tensors<'a>(&self, dataset: &'a Dataset) -> Vec<Tensor<'a>> {
        dataset.meshless.as_deref().map_or_else(Vec::new, tensors)
    }

    fn read(&self, reader: &Reader, dataset: &mut Dataset) -> Result<(), Damage> {
        dataset.meshless = reader.meshless()?.map(Into::into);
        Ok(())
    }

    fn settings(&self, dataset: &Dataset) -> Vec<(&'static str, bool)> {
        let MeshlessSettings { coarse_radius, rays, epsilon, levels: _, sender_levels: _ } = dataset.settings.meshless;
        vec![
            ("coarse radius", coarse_radius.is_none_or(is_size)),
            ("rays", (1..=MOST_RAYS).contains(&rays)),
            ("epsilon", is_size(epsilon)),
        ]
    }

    fn check(&self, dataset: &Dataset) -> Result<(), Damage> {
        let triangles = dataset.scene.mesh.triangles.len();
        dataset.meshless.as_deref().map_or(Ok(()), |bake| check(bake, triangles).map_err(Damage::of_part))
    }
}

/// The tensors of a meshless bake.
fn tensors(bake: &MeshlessBake) -> Vec<Tensor<'_>> {
    let (basis, transport) = (&bake.basis, &bake.transport);
    let mut tensors = Vec::from(surfel_tensors("meshless", basis.points().iter().copied()));
    tensors.extend([
        tensor("meshless_levels", Dtype::U32, [basis.levels() + 1], basis.offsets()),
        tensor("meshless_radii", Dtype::F32, [basis.levels()], basis.radii()),
        owned(tensor("meshless_sender_levels", Dtype::U32, [1], &[basis.sender_levels() as u32])),
        tensor("meshless_links", Dtype::U16, [transport.packed().len(), 4], transport.packed()),
        tensor("meshless_link_offsets", Dtype::U32, [transport.offsets().len()], transport.offsets()),
        owned(tensor("meshless_link_scale", Dtype::F32, [1], &[transport.scale()])),
    ]);
    tensors
}

impl Reader<'_> {
    /// The meshless bake, if there is one.
    fn meshless(&self) -> Result<Option<MeshlessBake>, Damage> {
        if !self.has("meshless_positions") {
            return Ok(None);
        }
        let offsets: Vec<u32> = self.array("meshless_levels", Dtype::U32, &[], None)?;
        let radii: Vec<f32> = self.array("meshless_radii", Dtype::F32, &[], None)?;
        let sender_levels: Vec<u32> = self.array("meshless_sender_levels", Dtype::U32, &[], Some(1))?;
        let basis = Basis::from_parts(self.surfels("meshless")?, offsets, radii, sender_levels[0] as usize);
        let basis = basis.map_err(|e| Damage::of_part(MeshlessDamage::Basis(e)))?;
        let links: Vec<PackedLink> = self.array("meshless_links", Dtype::U16, &[4], None)?;
        let offsets: Vec<u32> = self.array("meshless_link_offsets", Dtype::U32, &[], None)?;
        let scale: Vec<f32> = self.array("meshless_link_scale", Dtype::F32, &[], Some(1))?;
        let transport = Transport::from_parts([basis.len(), basis.senders().len()], scale[0], offsets, links);
        let transport = transport.map_err(|e| Damage::of_part(MeshlessDamage::Transport(e)))?;
        Ok(Some(MeshlessBake { basis, transport }))
    }
}

fn check(bake: &MeshlessBake, triangles: usize) -> Result<(), MeshlessDamage> {
    let (basis, transport) = (&bake.basis, &bake.transport);
    for (function, point) in basis.points().iter().enumerate() {
        check_surfel(point, triangles).map_err(|source| MeshlessDamage::Function { function, source })?;
    }
    let [receivers, senders] = [basis.len(), basis.senders().len()];
    if [transport.receivers(), transport.senders()] != [receivers, senders] {
        return Err(MeshlessDamage::Transport(TransportError { receivers, senders }));
    }
    if (0.0..=MOST_LINK_SCALE).contains(&transport.scale()) {
        Ok(())
    } else {
        Err(MeshlessDamage::Scale(transport.scale()))
    }
}

/// Errors of a stored meshless basis.
#[derive(Debug, Error, PartialEq)]
enum MeshlessDamage {
    /// Its points or levels are invalid.
    #[error(transparent)]
    Basis(BasisError),
    /// Its links are invalid.
    #[error(transparent)]
    Transport(TransportError),
    /// The place of a function is invalid.
    #[error("function {function} of the meshless basis {source}")]
    Function {
        /// Index of the function.
        function: usize,
        /// The problem.
        source: SurfelDamage,
    },
    /// Links carry more light than possible.
    #[error("the links of the meshless basis have a scale of {0}, which is not between 0 and {MOST_LINK_SCALE}")]
    Scale(f32),
}
