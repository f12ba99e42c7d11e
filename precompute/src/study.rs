//! Many bakes of one scene that share what they have in common, to compare trees, bounds and numbers of lights.
//!
//! A scene is tessellated once. Every point is traced once for a number of lights, whatever the number of trees and bounds: what
//! it sees does not depend on how the lights are clustered; only rearranging and selecting are done for each.
//! A study may also bake some points only, as those that a picture shows.

mod variants;

use crate::{
    bake::Geometry,
    errors::{BakeError, cancelled},
    observer::{Event, Observer, Phase},
    vertices::{pilot::pilot_of, points::BakePoint, visibility::VisibilitySampler},
};
use glam::Vec3;
use lapidary_core::{
    cut::CutCriterion,
    dataset::{BakeParts, scene_hash},
    light_tree::{PilotVisibility, TreeKind},
    ray::Intersector,
    scene::Scene,
};
use rayon::prelude::*;
use std::{
    sync::atomic::{AtomicU64, Ordering},
    time::Instant,
};

/// Points between two looks at the observer.
const POINTS_PER_STEP: usize = 256;

/// A tree and how fine its cuts are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// Clustering metric.
    pub tree: TreeKind,
    /// Weight of the geometric metric in a mixed tree.
    pub beta: f32,
    /// When a node of a cut is fine enough.
    pub criterion: CutCriterion,
}

/// A tessellated scene under study.
pub struct Study {
    geometry: Geometry,
    hash: String,
    max_vertices: Option<usize>,
    tessellate_secs: f64,
}

impl Study {
    /// Tessellates for distant light within a budget of vertices; `None` leaves the mesh as it is.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`].
    pub fn new(scene: Scene, max_vertices: Option<usize>, observer: &dyn Observer) -> Result<Self, BakeError> {
        let vertices = scene.mesh.positions.len().max(max_vertices.unwrap_or(0)) as u64;
        observer.event(Event::Started { phase: Phase::Tessellate, total: vertices, unit: "vertices" });
        let start = Instant::now();
        let hash = scene_hash(&scene);
        let geometry = Geometry::new(scene, BakeParts::ENVIRONMENT, max_vertices, &[], observer)?;
        Ok(Self { geometry, hash, max_vertices, tessellate_secs: start.elapsed().as_secs_f64() })
    }

    /// The scene with its tessellated mesh.
    pub fn scene(&self) -> &Scene {
        &self.geometry.scene
    }

    /// Casts rays on it.
    pub fn intersector(&self) -> &Intersector {
        &self.geometry.intersector
    }

    /// Number of bake points: vertices that agree in position and normal share one.
    pub fn points(&self) -> usize {
        self.geometry.points.points.len()
    }

    /// All bake points, or `count` of them evenly through the mesh if there are more.
    pub fn some_points(&self, count: usize) -> Vec<u32> {
        let all = self.points();
        let count = count.min(all);
        (0..count).map(|i| ((2 * i + 1) * all / (2 * count)) as u32).collect()
    }

    /// The bake points of these vertices, each once.
    pub fn points_of(&self, vertices: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let of = |vertex: u32| self.geometry.points.of_vertex[vertex as usize];
        let mut points: Vec<u32> = vertices.into_iter().map(of).collect();
        points.sort_unstable();
        points.dedup();
        points
    }

    /// What `each` makes of the visibility (0 or 1) of `directions` from each of `points`.
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
        let sampler = VisibilitySampler::of_directions(&self.geometry.intersector, directions);
        let scratch = || vec![0; directions.len()];
        self.in_steps(points, observer, scratch, |point, visible: &mut Vec<u8>| {
            sampler.sample(point, visible);
            each(visible)
        })
    }

    /// Pilot visibility of any directions, averaged over members of clusters of all bake points.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`].
    pub fn pilot(
        &self,
        directions: &[Vec3],
        clusters: usize,
        observer: &dyn Observer,
    ) -> Result<PilotVisibility, BakeError> {
        observer.event(Event::Started { phase: Phase::Pilot, total: clusters as u64, unit: "clusters" });
        let sampler = VisibilitySampler::of_directions(&self.geometry.intersector, directions);
        let sample = |point: &BakePoint, visible: &mut [u8]| {
            sampler.sample(point, visible);
        };
        pilot_of(&self.geometry.points, self.diagonal(), directions.len(), clusters, observer, sample)
    }

    fn diagonal(&self) -> f32 {
        self.geometry.scene.mesh.bounds().diagonal()
    }

    /// `work` at each of `points` on all cores, in their order.
    fn in_steps<S, T: Send>(
        &self,
        points: &[u32],
        observer: &dyn Observer,
        scratch: impl Fn() -> S + Sync + Send,
        work: impl Fn(&BakePoint, &mut S) -> T + Sync,
    ) -> Result<Vec<T>, BakeError> {
        observer.event(Event::Started { phase: Phase::Visibility, total: points.len() as u64, unit: "points" });
        let done = AtomicU64::new(0);
        let mut results = Vec::with_capacity(points.len());
        for step in points.chunks(POINTS_PER_STEP) {
            cancelled(observer)?;
            let one = |scratch: &mut S, &point: &u32| {
                let result = work(&self.geometry.points.points[point as usize], scratch);
                observer.event(Event::Advanced { done: done.fetch_add(1, Ordering::Relaxed) + 1 });
                result
            };
            results.extend(step.par_iter().map_init(&scratch, one).collect::<Vec<T>>());
        }
        Ok(results)
    }
}

#[cfg(test)]
mod tests;
