//! Visibility of a dataset's vertices toward every light, retraced from their bake points.

use crate::vertices::{
    points::BakePoints,
    sidedness::Sidedness,
    visibility::{EXHAUSTIVE, VisibilitySampler},
};
use lapidary_core::{
    dataset::Dataset,
    ray::{BoundaryTracer, Intersector},
};

/// Retraces vertices of a dataset.
pub struct VertexSampler<'a> {
    points: BakePoints,
    lights: VisibilitySampler<'a>,
}

/// The points where a dataset's vertices were sampled.
pub fn bake_points(dataset: &Dataset) -> BakePoints {
    let mesh = &dataset.scene.mesh;
    let closed = vec![true; mesh.triangles.len()]; // only burial needs it, and that is stored
    BakePoints::new(mesh, &Sidedness { two_sided: dataset.two_sided.clone(), closed })
}

impl<'a> VertexSampler<'a> {
    /// For a dataset and the rays of its mesh.
    pub fn new(dataset: &Dataset, intersector: &'a Intersector) -> Self {
        Self { points: bake_points(dataset), lights: VisibilitySampler::new(intersector, &dataset.tree, EXHAUSTIVE) }
    }

    /// Sets `visible[leaf]` to 1 for every light visible from a vertex and to 0 for all others, as before cut selection.
    pub fn sample(&self, vertex: u32, visible: &mut [u8]) {
        let point = self.points.of_vertex[vertex as usize];
        self.lights.sample(&self.points.points[point as usize], &mut BoundaryTracer::default(), visible);
    }
}
