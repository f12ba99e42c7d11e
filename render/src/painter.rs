//! What a surface point gives a pixel in each view mode: radiance, or one of the quantities behind it.

use crate::{
    lighting::SceneLighting,
    shade::{BrdfSampling, Shader, Work},
    surface::SurfacePoint,
    view_mode::ViewMode,
};
use glam::Vec3;
use lapidary_core::dataset::Dataset;

/// Values of surface points; keeps its buffers between them.
pub(crate) struct Painter<'a> {
    mode: ViewMode,
    dataset: &'a Dataset,
    /// `None` without a light: what depends on it is black.
    shader: Option<Shader<'a>>,
    points: u64,
}

impl<'a> Painter<'a> {
    pub fn new(
        mode: ViewMode,
        dataset: &'a Dataset,
        lighting: Option<&'a SceneLighting>,
        sampling: BrdfSampling,
    ) -> Self {
        let height = dataset.tree.height();
        let shader = lighting.map(|lighting| Shader::new(lighting, &dataset.cuts, height, sampling));
        Self { mode, dataset, shader, points: 0 }
    }

    /// Scene-linear radiance or albedo, a normal from 0 to 1, a roughness, or a count.
    pub fn value(&mut self, point: &SurfacePoint) -> Vec3 {
        self.points += 1;
        match self.mode {
            ViewMode::Shaded => self.shader.as_mut().map_or(Vec3::ZERO, |shader| shader.shade(point)),
            ViewMode::Normals => 0.5 * point.world_from_local.z_axis + 0.5,
            ViewMode::Albedo => point.parameters.base_color,
            ViewMode::Roughness => Vec3::splat(point.parameters.roughness),
            ViewMode::VisibilityCut => Vec3::splat(self.visibility_nodes(point)),
            ViewMode::MergedCut => Vec3::splat(self.work_at(point).merged_nodes as f32),
            ViewMode::BrdfEvaluations => Vec3::splat(self.work_at(point).brdf_evaluations as f32),
        }
    }

    /// Work since the last call.
    pub fn take_work(&mut self) -> Work {
        let shaded = self.shader.as_mut().map(|shader| std::mem::take(&mut shader.work));
        Work { points: std::mem::take(&mut self.points), ..shaded.unwrap_or_default() }
    }

    fn work_at(&mut self, point: &SurfacePoint) -> Work {
        let Some(shader) = &mut self.shader else { return Work::default() };
        let before = shader.work;
        shader.shade(point);
        Work {
            merged_nodes: shader.work.merged_nodes - before.merged_nodes,
            brdf_evaluations: shader.work.brdf_evaluations - before.brdf_evaluations,
            points: 1,
        }
    }

    /// Sizes of the vertices' cuts, interpolated as their visibility is.
    fn visibility_nodes(&self, point: &SurfacePoint) -> f32 {
        let height = self.dataset.tree.height();
        let nodes = |vertex: u32| self.dataset.cuts.cut(height, vertex).len() as f32;
        point.vertices.iter().zip(point.weights).map(|(&vertex, weight)| weight * nodes(vertex)).sum()
    }
}
