//! Surface sources and their cuts on disk.

use super::{
    error::Damage,
    reader::Reader,
    tensors::{Tensor, cut_tensors, owned, tensor},
};
use crate::{
    sources::{IndirectBake, Source},
    surfel::{MeshPlace, Surfel},
};
use glam::{Vec2, Vec3};
use safetensors::Dtype;

/// Names of the tensors of the vertices' cuts over the sources.
pub(super) const SOURCE_CUTS: [&str; 2] = ["source_cuts", "source_cut_offsets"];
/// Names of the tensors of the sources' cuts over the environment.
pub(super) const SOURCE_ENVIRONMENT_CUTS: [&str; 2] = ["source_environment_cuts", "source_environment_cut_offsets"];

/// The tensors of an indirect bake.
pub(super) fn tensors(bake: &IndirectBake) -> Vec<Tensor<'_>> {
    let n = bake.sources.len();
    let surfels = || bake.sources.iter().map(|s| s.surfel);
    let positions: Vec<Vec3> = surfels().map(|s| s.position).collect();
    let normals: Vec<Vec3> = surfels().map(|s| s.normal).collect();
    let areas: Vec<f32> = bake.sources.iter().map(|s| s.area).collect();
    let spacings: Vec<f32> = bake.sources.iter().map(|s| s.spacing).collect();
    let triangles: Vec<u32> = surfels().map(|s| s.place.triangle).collect();
    let barycentrics: Vec<Vec2> = surfels().map(|s| s.place.barycentric).collect();
    let mut tensors = vec![
        owned(tensor("source_positions", Dtype::F32, [n, 3], &positions)),
        owned(tensor("source_normals", Dtype::F32, [n, 3], &normals)),
        owned(tensor("source_areas", Dtype::F32, [n], &areas)),
        owned(tensor("source_spacings", Dtype::F32, [n], &spacings)),
        owned(tensor("source_triangles", Dtype::U32, [n], &triangles)),
        owned(tensor("source_barycentrics", Dtype::F32, [n, 2], &barycentrics)),
    ];
    tensors.extend(cut_tensors(SOURCE_CUTS, &bake.cuts));
    tensors.extend(cut_tensors(SOURCE_ENVIRONMENT_CUTS, &bake.environment_cuts));
    tensors
}

impl Reader<'_> {
    /// The indirect bake, if there is one. `reported` is the spacing of sources that store none.
    pub(super) fn indirect(&self, vertices: usize, reported: f32) -> Result<Option<IndirectBake>, Damage> {
        if !self.has("source_positions") {
            return Ok(None);
        }
        let sources = self.sources(reported)?;
        let cuts = self.cuts(SOURCE_CUTS, vertices)?;
        let environment_cuts = self.cuts(SOURCE_ENVIRONMENT_CUTS, sources.len())?;
        Ok(Some(IndirectBake { sources, cuts, environment_cuts }))
    }

    fn sources(&self, reported: f32) -> Result<Vec<Source>, Damage> {
        let positions: Vec<Vec3> = self.array("source_positions", Dtype::F32, &[3], None)?;
        let n = Some(positions.len());
        let normals: Vec<Vec3> = self.array("source_normals", Dtype::F32, &[3], n)?;
        let areas: Vec<f32> = self.array("source_areas", Dtype::F32, &[], n)?;
        let spacings = match self.has("source_spacings") {
            true => self.array("source_spacings", Dtype::F32, &[], n)?,
            false => vec![even_spacing(reported, &areas); positions.len()],
        };
        let of_triangle: Vec<u32> = self.array("source_triangles", Dtype::U32, &[], n)?;
        let barycentrics: Vec<Vec2> = self.array("source_barycentrics", Dtype::F32, &[2], n)?;
        let source = |i: usize| {
            let place = MeshPlace { triangle: of_triangle[i], barycentric: barycentrics[i] };
            let surfel = Surfel { position: positions[i], normal: normals[i], place };
            Source { surfel, area: areas[i], spacing: spacings[i] }
        };
        Ok((0..positions.len()).map(source).collect())
    }
}

/// Spacing of sources that store none: the reported one, or else the side of a square of their mean area, which is
/// about as long.
fn even_spacing(reported: f32, areas: &[f32]) -> f32 {
    let mean_area = areas.iter().sum::<f32>() / areas.len().max(1) as f32;
    if reported > 0.0 { reported } else { mean_area.sqrt() }
}
