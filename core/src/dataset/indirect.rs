//! Surface sources and their cuts on disk.

use super::{
    error::{Damage, SourceDamage},
    tensors::{Reader, Tensor, cut_tensors, owned, tensor},
};
use crate::{
    light_tree::height_of,
    sources::{IndirectBake, Source},
    surfel::{MeshPlace, Surfel},
};
use glam::{Vec2, Vec3};
use safetensors::Dtype;

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
    tensors.extend(cut_tensors("source_cuts", "source_cut_offsets", &bake.cuts));
    let environment = &bake.environment_cuts;
    tensors.extend(cut_tensors("source_environment_cuts", "source_environment_cut_offsets", environment));
    tensors
}

impl Reader<'_> {
    /// The indirect bake, if there is one. `height` is that of the tree of the environment's lights, `reported` the
    /// spacing of sources that store none.
    pub(super) fn indirect(
        &self,
        height: u32,
        vertices: usize,
        triangles: usize,
        reported: f32,
    ) -> Result<Option<IndirectBake>, Damage> {
        if !self.has("source_positions") {
            return Ok(None);
        }
        let sources = self.sources(triangles, reported)?;
        let source_height = height_of(sources.len()).map_err(|_| SourceDamage::Count(sources.len()))?;
        let cuts = self.cuts(["source_cuts", "source_cut_offsets"], source_height, vertices)?;
        let names = ["source_environment_cuts", "source_environment_cut_offsets"];
        let environment_cuts = self.cuts(names, height, sources.len())?;
        Ok(Some(IndirectBake { sources, cuts, environment_cuts }))
    }

    fn sources(&self, triangles: usize, reported: f32) -> Result<Vec<Source>, Damage> {
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
            let finite = surfel.position.is_finite() && surfel.normal.is_finite() && place.barycentric.is_finite();
            let is_size = |x: f32| x.is_finite() && x >= 0.0;
            if !(finite && is_size(areas[i]) && is_size(spacings[i])) {
                return Err(SourceDamage::NotFinite(i).into());
            }
            if place.triangle as usize >= triangles {
                return Err(
                    SourceDamage::Triangle { source_index: i, triangle: place.triangle, count: triangles }.into()
                );
            }
            Ok(Source { surfel, area: areas[i], spacing: spacings[i] })
        };
        (0..positions.len()).map(source).collect()
    }
}

/// Spacing of sources that store none: the reported one, or else the side of a square of their mean area, which is
/// about as long.
fn even_spacing(reported: f32, areas: &[f32]) -> f32 {
    let mean_area = areas.iter().sum::<f32>() / areas.len().max(1) as f32;
    if reported > 0.0 { reported } else { mean_area.sqrt() }
}
