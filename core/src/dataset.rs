//! The `.cuts` dataset: everything that relighting needs, in one file of the safetensors layout.
//!
//! Tensors (little endian; V vertices, T triangles, N lights):
//!
//! | name | type | shape | |
//! |---|---|---|---|
//! | `positions`, `normals` | f32 | V, 3 | tessellated mesh, meters |
//! | `tangents` | f32 | V, 4 | xyz and handedness |
//! | `uvs` | f32 | V, 2 | (0, 0) is the top left corner |
//! | `second_uvs` | f32 | V, 2 | where the scene has a second set |
//! | `colors` | f32 | V, 3 | where its vertices have colors, linear Rec. 709 |
//! | `triangles` | u32 | T, 3 | vertex indices |
//! | `triangle_material`, `triangle_object` | u32 | T | indices into the metadata's lists |
//! | `triangle_two_sided` | u8 | T | 1 if lit and seen from both sides |
//! | `vertex_valid` | u8 | V | 0 if the vertex lies inside other geometry and does not count in interpolation |
//! | `tree_order` | u32 | N | sample index of each leaf; samples are spherical Fibonacci points |
//! | `cuts` | u32 | texels, 4 | packed nodes, see [`crate::cut::packed`] |
//! | `cut_offsets` | u32 | V | first texel of each vertex's cut |
//! | `source_positions`, `source_normals` | f32 | S, 3 | surface sources in the order of their tree's leaves, meters |
//! | `source_areas` | f32 | S | area of each, m² |
//! | `source_spacings` | f32 | S | spacing of each, meters |
//! | `source_triangles` | u32 | S | triangle that each lies on |
//! | `source_barycentrics` | f32 | S, 2 | weights of its second and third corner |
//! | `source_cuts` | u32 | texels, 4 | solid angles of the sources seen from the vertices, see [`crate::sources`] |
//! | `source_cut_offsets` | u32 | V | first texel of each vertex's cut |
//! | `source_environment_cuts` | u32 | texels, 4 | visibility of the N lights from the sources |
//! | `source_environment_cut_offsets` | u32 | S | first texel of each source's cut |
//! | `texture.0`, ... | u8 | bytes | image files as they were imported |
//! | `brdf.0`, ... | u8 | bytes | files of BRDFs, packed: see [`Content::packed`](crate::brdf::Content::packed) |
//!
//! Surface sources are present for `--mode indirect`, `cuts` and `all`; the tensors `meshless_*` of
//! `dataset/meshless.rs` for `--mode meshless` and `all`; the tensors `radiosity_*` of `dataset/object_bases.rs` for
//! `--mode radiosity`; the tensors `wavelet_*` of `dataset/wavelet.rs` for `--mode wavelet`.
//!
//! The metadata holds JSON under `lapidary`: format version, settings, hashes, a checksum per tensor, the bake report,
//! and the scene's lists. A file is written under a temporary name and renamed. [`Dataset::validate`] checks all contents
//! before they are written and before they are used.

mod audit;
mod brdfs;
mod error;
mod header;
mod meshless;
mod object_bases;
mod parts;
mod read;
mod reader;
mod report;
mod settings;
mod sources;
mod stored;
mod tensors;
mod validate;
mod wavelet;
mod write;

pub use audit::BakeAudit;
pub use error::{Damage, DatasetError};
pub use meshless::{MeshlessReport, MeshlessSettings};
pub use object_bases::{ObjectBasesReport, ObjectBasesSettings};
pub use parts::{BakePart, BakeParts, PartsError};
pub use report::{BakeReport, BakeRun, sigma_text};
pub use settings::BakeSettings;
pub use sources::{IndirectReport, IndirectSettings};
#[cfg(any(test, feature = "test-scenes"))]
pub(crate) use tensors::METADATA_KEY;
pub use wavelet::{WaveletReport, WaveletSettings};

use crate::{
    camera::Camera,
    cut::packed::PackedCuts,
    image::ImageError,
    light_tree::LightTree,
    material::NORMAL,
    mesh::Mesh,
    meshless::{MeshlessBake, ObjectBases},
    scene::{
        Scene, placed,
        pose::{ClipTime, Poses},
    },
    shot::Shot,
    sources::IndirectBake,
    texture::{Texture, UvSet},
    wavelet::WaveletTransport,
};
use glam::Vec2;
use std::{path::Path, sync::Arc};

/// Version of the layout that this program writes, and the newest that it reads; it also reads older ones.
/// Version 2 added the maps of anisotropy and index of refraction; materials of version 1 have none.
/// Version 3 added lights, modes, surface sources and the meshless basis.
/// Version 4 added the spacing of each source; sources of version 3 all have the reported spacing.
/// Version 5 added bakes that follow boundaries; bakes of version 4 are exhaustive.
/// Version 6 added boundaries between surface sources; bakes of version 5 trace every source.
/// Version 7 added the ground; scenes of version 6 have none.
/// Version 8 added BRDF files, and `ward` became Ward's model of 1992; the former `ward` is now `ward-duer`.
/// Version 9 added the bases of objects.
/// Version 10 added wavelet transport.
pub const FORMAT_VERSION: u32 = 10;

/// First version whose `ward` is the model of 1992.
const WARD_OF_1992: u32 = 8;

/// Decodes the bytes of a picture file. The file name gives the format where the bytes alone do not.
pub type DecodePicture = fn(&[u8], &Path) -> Result<Texture, ImageError>;

/// A baked scene.
#[derive(Clone, Debug)]
pub struct Dataset {
    /// The scene with its mesh as tessellated for the bake.
    pub scene: Scene,
    /// Per triangle: lit and seen from both sides.
    pub two_sided: Vec<bool>,
    /// Per vertex: may be used for interpolation.
    pub vertex_valid: Vec<bool>,
    /// The light tree.
    pub tree: LightTree,
    /// One visibility cut per vertex.
    pub cuts: PackedCuts,
    /// Surface sources and their cuts, if they were baked.
    pub indirect: Option<IndirectBake>,
    /// The meshless basis and its light transport, if baked; shared, because they are large and unaffected by poses.
    pub meshless: Option<Arc<MeshlessBake>>,
    /// The functions of each object, if baked; shared likewise.
    pub object_bases: Option<Arc<ObjectBases>>,
    /// Wavelet transport, if baked; shared likewise.
    pub wavelet: Option<Arc<WaveletTransport>>,
    /// Settings of the bake.
    pub settings: BakeSettings,
    /// Hash of the scene as imported, in hexadecimal.
    pub scene_hash: String,
    /// Report of the bake.
    pub report: BakeReport,
}

impl Dataset {
    /// The same dataset with another mesh of as many vertices and triangles.
    #[must_use]
    pub fn with_mesh(&self, mesh: Mesh) -> Self {
        Self {
            scene: self.scene.with_mesh(mesh),
            two_sided: self.two_sided.clone(),
            vertex_valid: self.vertex_valid.clone(),
            tree: self.tree.clone(),
            cuts: self.cuts.clone(),
            indirect: self.indirect.clone(),
            meshless: self.meshless.clone(),
            object_bases: self.object_bases.clone(),
            wavelet: self.wavelet.clone(),
            settings: self.settings.clone(),
            scene_hash: self.scene_hash.clone(),
            report: self.report.clone(),
        }
    }

    /// The baked parts of bounced light.
    pub fn bounces(&self) -> BakeParts {
        let stored = BakePart::ALL.iter().filter(|part| part.bounces() && stored::stored(**part).is_in(self));
        stored.fold(BakeParts::NONE, |all, part| all.with(BakeParts::only(*part)))
    }

    /// Whether any part of bounced light was baked.
    pub fn has_bounces(&self) -> bool {
        self.bounces() != BakeParts::NONE
    }

    /// Interpolation weights of three vertices. `barycentric` holds the weights of the second and third; the other
    /// vertices take the shares of buried ones.
    pub fn interpolation_weights(&self, vertices: [u32; 3], barycentric: Vec2) -> [f32; 3] {
        let weights = [1.0 - barycentric.x - barycentric.y, barycentric.x, barycentric.y];
        let is_valid = vertices.map(|v| self.vertex_valid[v as usize]);
        let kept: [f32; 3] = std::array::from_fn(|i| if is_valid[i] { weights[i].max(0.0) } else { 0.0 });
        let sum: f32 = kept.iter().sum();
        if sum > 1e-6 { kept.map(|w| w / sum) } else { weights }
    }

    /// The cameras of the shots it was baked for. Unnamed shots are called "Shot 1" and so on.
    pub fn shot_views(&self) -> Vec<Camera> {
        let named = |(index, shot): (usize, &Shot)| match shot.camera.name.is_empty() {
            true => Camera { name: format!("Shot {}", index + 1), ..shot.camera.clone() },
            false => shot.camera.clone(),
        };
        self.settings.shots.iter().enumerate().map(named).collect()
    }
}

/// Hash of a scene's geometry and of the sides of its materials, in hexadecimal. Visibility also depends on opacity, which is
/// edited without the file. Objects, cameras and local lights are left out, so moving a light makes no bake stale. They are hints
/// for the viewpoint of surface sources and meshless basis; a checkpoint records the resulting points itself.
pub fn scene_hash(scene: &Scene) -> String {
    let mesh = &scene.mesh;
    let mut hasher = blake3::Hasher::new();
    let mut add = |part: &[u8]| {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    };
    for part in [
        bytemuck::cast_slice::<_, u8>(&mesh.positions),
        bytemuck::cast_slice(&mesh.normals),
        bytemuck::cast_slice(&mesh.uvs),
        bytemuck::cast_slice(&mesh.triangles),
        bytemuck::cast_slice(&mesh.triangle_material),
    ] {
        add(part);
    }
    // Scenes without them keep the hash that they had before there were any.
    let optional = [bytemuck::cast_slice::<_, u8>(&mesh.second_uvs), bytemuck::cast_slice(&mesh.colors)];
    for (kind, part) in (0u8..).zip(optional).filter(|(_, part)| !part.is_empty()) {
        add(&[kind]);
        add(part);
    }
    for material in &scene.materials {
        hasher.update(&[u8::from(material.double_sided)]);
        // Tangents are along these coordinates.
        if material.maps.get(NORMAL).is_some_and(|slot| slot.uv_set == UvSet::Second) {
            hasher.update(NORMAL.as_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}

/// Hash of all that a bake depends on except its settings and the keyframes (see [`placed::deformed_hash`]): the scene
/// of the file, opacities, poses and animation time. `scene` needs no mesh.
pub fn bake_hash(scene_hash: &str, scene: &Scene, poses: &Poses, time: Option<&ClipTime>) -> String {
    let parts =
        [Some(scene_hash.into()), scene.opacity_hash(), placed::hash(poses, time).map(|hash| format!("posed-{hash}"))];
    parts.into_iter().flatten().collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests;
