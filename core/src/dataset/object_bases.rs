//! The bases of objects on disk, with settings and report.
//!
//! Tensors (N functions, L levels):
//!
//! | name | type | shape | |
//! |---|---|---|---|
//! | `radiosity_positions`, `radiosity_normals` | f32 | N, 3 | points of the functions as baked, coarsest first |
//! | `radiosity_triangles`, `radiosity_barycentrics` | u32, f32 | N and N, 2 | where on the mesh they lie |
//! | `radiosity_levels` | u32 | L + 1 | first function of each level, and the end of the last |
//! | `radiosity_radii` | f32 | L | radius of support in meters |
//! | `radiosity_sender_level` | u32 | 1 | the level that sends, from 0 |

use super::{
    Dataset,
    error::{Damage, SurfelDamage},
    reader::Reader,
    stored::StoredPart,
    tensors::{Tensor, owned, surfel_tensors, tensor},
    validate::check_surfel,
};
use crate::{
    meshless::{BasisError, ObjectBases, Owner},
    scene::Scene,
    surfel::Surfel,
};
use safetensors::Dtype;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Most functions that a bake can ask for.
const MOST_FUNCTIONS: u32 = 10_000_000;

/// Settings of the bases of objects.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectBasesSettings {
    /// About how many functions all levels have.
    pub functions: u32,
    /// Number of levels; each has about four times as many functions as the one before.
    pub levels: usize,
    /// The level that sends light, from 0.
    pub sender_level: usize,
}

impl Default for ObjectBasesSettings {
    /// The levels of the paper (Table 1), of which the fourth sends.
    fn default() -> Self {
        Self { functions: 150_000, levels: 6, sender_level: 3 }
    }
}

/// Report of the bases of objects.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ObjectBasesReport {
    /// Objects with functions.
    pub objects: usize,
    /// Functions of each level.
    pub functions: Vec<usize>,
    /// Distance of the finest level's points in meters.
    pub finest_spacing: f32,
    /// Bytes of the points.
    pub bytes_points: u64,
}

/// The bases of objects in a dataset.
pub(super) struct StoredObjectBases;

impl StoredPart for StoredObjectBases {
    fn is_in(&self, dataset: &Dataset) -> bool {
        dataset.object_bases.is_some()
    }

    fn tensors<'a>(&self, dataset: &'a Dataset) -> Vec<Tensor<'a>> {
        dataset.object_bases.as_deref().map_or_else(Vec::new, tensors)
    }

    fn read(&self, reader: &Reader, dataset: &mut Dataset) -> Result<(), Damage> {
        dataset.object_bases = reader.object_bases(&dataset.scene)?.map(Into::into);
        Ok(())
    }

    fn settings(&self, dataset: &Dataset) -> Vec<(&'static str, bool)> {
        let ObjectBasesSettings { functions, levels, sender_level } = dataset.settings.object_bases;
        vec![("functions", (1..=MOST_FUNCTIONS).contains(&functions)), ("sender level", sender_level < levels)]
    }

    fn check(&self, dataset: &Dataset) -> Result<(), Damage> {
        let points = dataset.object_bases.as_ref().map_or(&[][..], |bases| bases.points());
        check(points, dataset.scene.mesh.triangles.len())
    }
}

/// The tensors of bases.
fn tensors(bases: &ObjectBases) -> Vec<Tensor<'_>> {
    let mut tensors = Vec::from(surfel_tensors("radiosity", bases.points().iter().copied()));
    tensors.extend([
        tensor("radiosity_levels", Dtype::U32, [bases.levels() + 1], bases.offsets()),
        tensor("radiosity_radii", Dtype::F32, [bases.levels()], bases.radii()),
        owned(tensor("radiosity_sender_level", Dtype::U32, [1], &[bases.sender_level() as u32])),
    ]);
    tensors
}

impl Reader<'_> {
    /// The bases of the objects of a scene, if there are any.
    fn object_bases(&self, Scene { mesh, materials, objects, .. }: &Scene) -> Result<Option<ObjectBases>, Damage> {
        if !self.has("radiosity_positions") {
            return Ok(None);
        }
        // Owners are those of the triangles.
        mesh.validate(materials.len(), objects.len())?;
        let points = self.surfels("radiosity")?;
        check(&points, mesh.triangles.len())?;
        let offsets: Vec<u32> = self.array("radiosity_levels", Dtype::U32, &[], None)?;
        let radii: Vec<f32> = self.array("radiosity_radii", Dtype::F32, &[], None)?;
        let sender_level: Vec<u32> = self.array("radiosity_sender_level", Dtype::U32, &[], Some(1))?;
        let owners = points.iter().map(|point| Owner::on(mesh, point)).collect();
        let bases = ObjectBases::from_parts(points, owners, offsets, radii, sender_level[0] as usize);
        bases.map(Some).map_err(|e| Damage::of_part(ObjectBasesDamage::Basis(e)))
    }
}

fn check(points: &[Surfel], triangles: usize) -> Result<(), Damage> {
    points.iter().enumerate().try_for_each(|(function, point)| {
        check_surfel(point, triangles)
            .map_err(|source| Damage::of_part(ObjectBasesDamage::Function { function, source }))
    })
}

/// Errors of stored bases of objects.
#[derive(Debug, Error, PartialEq)]
enum ObjectBasesDamage {
    /// Points or levels are invalid.
    #[error(transparent)]
    Basis(BasisError),
    /// The place of a function is invalid.
    #[error("function {function} of the bases of objects {source}")]
    Function {
        /// Index of the function.
        function: usize,
        /// The problem.
        source: SurfelDamage,
    },
}
