//! The tessellated scene of a bake.

use crate::{
    bake::settings::with_room,
    errors::{BakeError, cancelled},
    observer::{Event, Observer, Phase},
    vertices::{
        pilot::sample_pilot,
        points::{BakePoint, BakePoints},
        sampler::bake_points,
        sidedness::{Sidedness, classify},
        tessellate::{POINTS_PER_VERTEX, Stored, Wanted, tessellate},
        tracing::{ManySampler, POINTS_AT_A_TIME, Tracing},
        visibility::{EXHAUSTIVE, VisibilitySampler},
    },
    warning::Warning,
};
use glam::Vec3;
use lapidary_core::{
    dataset::Dataset,
    ground::LEAST_VERTICES,
    light_tree::PilotVisibility,
    ray::{BoundaryTracer, Intersector, RayDevices},
    scene::Scene,
    shot::Shot,
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// The tessellated scene with its bake points. [`crate::bake()`] creates its own; bakes of one scene that differ only in tree and
/// error bound may share one with its visibility: see [`Self::visibility`] and [`Self::environment_dataset`].
pub struct Geometry {
    /// The scene with its tessellated mesh.
    pub scene: Scene,
    /// Casts rays on the scene.
    pub intersector: Intersector,
    pub(crate) source_vertices: usize,
    pub(crate) sides: Sidedness,
    pub(crate) points: BakePoints,
    pub(crate) buried: Vec<bool>,
}

impl Geometry {
    /// Tessellates for the vertices' stored functions within a budget of vertices, most finely in the view of `shots`; `None` adds
    /// no vertices. A ground gets additional vertices. `devices` trace instead of the cores if given.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`].
    pub fn new(
        mut scene: Scene,
        stored: Option<Stored>,
        budget: Option<usize>,
        shots: &[Shot],
        devices: Option<&dyn RayDevices>,
        observer: &dyn Observer,
    ) -> Result<Self, BakeError> {
        let source_vertices = scene.mesh.vertices_of_scene();
        let mut sides = classify(&scene);
        let source = Intersector::of_scene(&scene);
        if let Some(budget) = budget {
            remark_on_budget(source_vertices, budget, observer);
        }
        let most = budget.unwrap_or(0).max(source_vertices);
        let traced = AtomicU64::new(0);
        let ground = scene.mesh.split_off_ground().map(|ground| (ground, sides.split_off(scene.mesh.triangles.len())));
        if let Some(budget) = budget {
            let wanted = Wanted { stored, budget, shots, around: None, devices, traced: &traced };
            tessellate(&mut scene.mesh, &mut sides, &source, wanted, observer)?;
        }
        let is_split = budget.is_some() || ground.is_some();
        if let Some((mut ground, mut sides_of_ground)) = ground {
            let around = Some(scene.mesh.bounds());
            let wanted = Wanted { stored, budget: ground_budget(most), shots: &[], around, devices, traced: &traced };
            tessellate(&mut ground, &mut sides_of_ground, &source, wanted, observer)?;
            scene.mesh.append_ground(ground);
            sides.append(sides_of_ground);
        }
        let intersector = if is_split { Intersector::of_scene(&scene) } else { source };
        let points = BakePoints::new(&scene.mesh, &sides);
        let buried = points.buried(&intersector, &sides, observer)?;
        Ok(Self { scene, intersector, source_vertices, sides, points, buried })
    }

    /// The geometry of a dataset with a tessellated mesh.
    pub(crate) fn of_dataset(dataset: Dataset) -> Self {
        let intersector = Intersector::of_scene(&dataset.scene);
        let points = bake_points(&dataset);
        let mut buried = vec![false; points.points.len()];
        points.of_vertex.iter().zip(&dataset.vertex_valid).for_each(|(&p, valid)| buried[p as usize] = !valid);
        let closed = vec![true; dataset.scene.mesh.triangles.len()]; // only burial needs it, and that is stored
        Self {
            sides: Sidedness { two_sided: dataset.two_sided, closed },
            source_vertices: dataset.report.source_vertices,
            scene: dataset.scene,
            intersector,
            points,
            buried,
        }
    }

    /// Number of bake points: vertices with equal position and normal share one.
    pub fn bake_points(&self) -> usize {
        self.points.points.len()
    }

    /// The bake point of a vertex.
    pub fn bake_point_of(&self, vertex: u32) -> u32 {
        self.points.of_vertex[vertex as usize]
    }

    /// Whether each vertex lies outside all objects.
    pub(crate) fn vertex_valid(&self) -> Vec<bool> {
        self.points.of_vertex.iter().map(|&p| !self.buried[p as usize]).collect()
    }

    /// Applies `each` to the visibility (0 to [`lapidary_core::ray::OPEN`]), traced exhaustively, of `directions` from each of
    /// `points`, and to the number of traced rays; on all cores, in point order. `scratch` creates buffers that are reused.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`].
    pub fn visibility<S, T: Send>(
        &self,
        directions: &[Vec3],
        points: &[u32],
        observer: &dyn Observer,
        scratch: impl Fn() -> S + Sync + Send,
        each: impl Fn(&[u8], u64, &mut S) -> T + Sync,
    ) -> Result<Vec<T>, BakeError> {
        observer.event(Event::Started { phase: Phase::Visibility, total: points.len() as u64, unit: "points" });
        let sampler = VisibilitySampler::of_directions(&self.intersector, directions, EXHAUSTIVE);
        let scratch = || (vec![0; directions.len()], BoundaryTracer::default(), scratch());
        let done = AtomicU64::new(0);
        let mut results = Vec::with_capacity(points.len());
        for step in points.chunks(POINTS_AT_A_TIME) {
            cancelled(observer)?;
            let one = |(visible, tracer, scratch): &mut (Vec<u8>, BoundaryTracer, S), &point: &u32| {
                let point: &BakePoint = &self.points.points[point as usize];
                let rays = sampler.sample(point, tracer, visible);
                let result = each(visible, rays, scratch);
                observer.event(Event::Advanced { done: done.fetch_add(1, Ordering::Relaxed) + 1 });
                result
            };
            results.extend(step.par_iter().map_init(&scratch, one).collect::<Vec<T>>());
        }
        Ok(results)
    }

    /// Pilot visibility of `directions`, averaged over members of clusters of all bake points.
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
        let diagonal = self.scene.mesh.bounds().diagonal();
        let tracing = Tracing { lights_per_probe: EXHAUSTIVE, devices: None, observer };
        let sampler = ManySampler::new(&self.intersector, directions, tracing);
        sample_pilot(&self.points, &sampler, diagonal, clusters, observer)
    }
}

/// Units of progress of [`Geometry::new`] for at most this many vertices: points that the pilot traces.
pub fn tessellation_units(vertices: usize) -> u64 {
    POINTS_PER_VERTEX * vertices as u64
}

/// Vertices of the ground under a scene with this many: at most a fifth as many, but enough for a ground at all.
pub(crate) fn ground_budget(vertices: usize) -> usize {
    (vertices / 5).max(LEAST_VERTICES)
}

/// Warns of a mesh that already has as many vertices as its budget allows.
fn remark_on_budget(vertices: usize, budget: usize, observer: &dyn Observer) {
    if budget <= vertices {
        let message = Warning::NoRoomForVertices { vertices, enough: with_room(0, vertices) };
        observer.event(Event::Warning { message });
    }
}
