//! Many bakes of one scene that share their common work, to compare trees, bounds and numbers of lights.
//!
//! A scene is tessellated once. Every point is traced once for a number of lights, because its visibility does not depend on the
//! clustering; only reordering and cut selection differ between variants. A bake may be limited to some points, such as those in a
//! picture.

mod datasets;

use glam::Vec3;
use lapidary_core::{
    cut::CutCriterion,
    dataset::{BakeParts, scene_hash},
    light_tree::TreeKind,
    scene::Scene,
};
use lapidary_precompute::{BakeError, Event, Geometry, Observer, Phase, Stored, tessellation_units};
use std::time::Instant;

/// A tree and the precision of its cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// Clustering metric.
    pub tree: TreeKind,
    /// Weight of the geometric metric in a mixed tree.
    pub beta: f32,
    /// When a node of a cut is fine enough.
    pub criterion: CutCriterion,
}

/// A tessellated scene for baking variants.
pub struct VariantBaker {
    /// The scene and its bake points.
    pub geometry: Geometry,
    hash: String,
    max_vertices: Option<usize>,
    tessellate_secs: f64,
}

impl VariantBaker {
    /// Tessellates for distant light within a budget of vertices; `None` adds no vertices.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`].
    pub fn new(scene: Scene, max_vertices: Option<usize>, observer: &dyn Observer) -> Result<Self, BakeError> {
        let vertices = scene.mesh.positions.len().max(max_vertices.unwrap_or(0));
        let total = tessellation_units(vertices);
        observer.event(Event::Started { phase: Phase::Tessellate, total, unit: "points" });
        let start = Instant::now();
        let hash = scene_hash(&scene);
        let geometry = Geometry::new(scene, Stored::of(BakeParts::ENVIRONMENT), max_vertices, &[], None, observer)?;
        Ok(Self { geometry, hash, max_vertices, tessellate_secs: start.elapsed().as_secs_f64() })
    }

    /// All bake points, or `count` of them spread evenly over the mesh if there are more.
    pub fn some_points(&self, count: usize) -> Vec<u32> {
        let all = self.geometry.bake_points();
        let count = count.min(all);
        (0..count).map(|i| ((2 * i + 1) * all / (2 * count)) as u32).collect()
    }

    /// The distinct bake points of these vertices.
    pub fn points_of(&self, vertices: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let mut points: Vec<u32> = vertices.into_iter().map(|vertex| self.geometry.bake_point_of(vertex)).collect();
        points.sort_unstable();
        points.dedup();
        points
    }

    /// Applies `each` to the visibility (0 or 1) of `directions` from each of `points`.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`].
    pub fn visibility<T: Send>(
        &self,
        directions: &[Vec3],
        points: &[u32],
        observer: &dyn Observer,
        each: impl Fn(&[u8]) -> T + Sync,
    ) -> Result<Vec<T>, BakeError> {
        self.geometry.visibility(directions, points, observer, || (), |visible, _, ()| each(visible))
    }
}

#[cfg(test)]
mod tests;
