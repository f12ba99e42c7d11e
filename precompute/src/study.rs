//! Many bakes of one scene that share what they have in common, to compare trees, bounds and numbers of lights.
//!
//! A scene is tessellated once. Every point is traced once for a number of lights, whatever the number of trees and bounds: what
//! it sees does not depend on how the lights are clustered, and rearranging and selecting take a hundredth of the tracing.
//! A study may also bake some points only, as those that a picture shows.

use crate::{
    bake::{BakeError, Geometry, Packed, cancelled, concatenate, pack, report},
    bake_points::BakePoint,
    checkpoint::{Chunk, Series},
    observer::{Event, Observer, Phase},
    pilot::{pilot_of, sample_pilot},
    settings::{Preset, resolve},
    visibility::VisibilitySampler,
};
use glam::Vec3;
use lapidary_core::{
    cut::{CutCriterion, CutSelector},
    dataset::{BakeMode, BakeReport, BakeSettings, Dataset, scene_hash},
    light_tree::{Features, LightTree, PilotVisibility, TreeKind},
    ray::Intersector,
    scene::Scene,
    sphere::fibonacci_directions,
};
use rayon::prelude::*;
use std::{
    collections::BTreeMap,
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
        let geometry = Geometry::new(scene, BakeMode::Environment, max_vertices, observer)?;
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

    /// A dataset for each of `variants`, with cuts for `points` and cuts that see nothing for all others. Reports are about
    /// `points` alone; seconds of tracing are those of all variants together, which each of them would take.
    ///
    /// # Errors
    /// Settings out of range, cuts beyond what a texture holds, and [`BakeError::Cancelled`].
    pub fn bake(
        &self,
        lights: usize,
        pilot_clusters: usize,
        variants: &[Variant],
        points: &[u32],
        observer: &dyn Observer,
    ) -> Result<Vec<Dataset>, BakeError> {
        let settings = variants.iter().map(|&variant| self.settings(lights, pilot_clusters, variant));
        let settings = settings.collect::<Result<Vec<_>, BakeError>>()?;
        let trees = self.trees(&settings, observer)?;
        let start = Instant::now();
        let chunks = self.chunks(&settings, &trees, points, observer)?;
        let visibility_secs = start.elapsed().as_secs_f64();
        let made = settings.into_iter().zip(trees).zip(chunks);
        made.map(|((settings, tree), chunk)| self.dataset(settings, tree, &chunk, points, visibility_secs)).collect()
    }

    fn settings(&self, lights: usize, pilot_clusters: usize, variant: Variant) -> Result<BakeSettings, BakeError> {
        let Variant { tree, beta, criterion } = variant;
        let normal = Preset::Normal.settings();
        let max_vertices = self.max_vertices;
        Ok(resolve(BakeSettings { lights, tree, beta, criterion, pilot_clusters, max_vertices, ..normal })?)
    }

    /// The tree of each settings; equal ones are clustered once.
    fn trees(&self, settings: &[BakeSettings], observer: &dyn Observer) -> Result<Vec<TimedTree>, BakeError> {
        let Some(first) = settings.first() else { return Ok(Vec::new()) };
        let directions = fibonacci_directions(first.lights);
        let mut pilot = PilotVisibility { lights: first.lights, fractions: Vec::new() };
        let mut pilot_secs = 0.0;
        if settings.iter().any(|s| s.tree != TreeKind::Geometric) {
            let clusters = first.pilot_clusters;
            observer.event(Event::Started { phase: Phase::Pilot, total: clusters as u64, unit: "clusters" });
            let (geometry, start) = (&self.geometry, Instant::now());
            let (points, scene) = (&geometry.points, &geometry.intersector);
            pilot = sample_pilot(points, scene, self.diagonal(), first.lights, clusters, observer)?;
            pilot_secs = start.elapsed().as_secs_f64();
        }
        let mut known: Vec<(TreeKind, f32, TimedTree)> = Vec::new();
        for s in settings {
            if known.iter().any(|(kind, beta, _)| (*kind, *beta) == (s.tree, s.beta)) {
                continue;
            }
            cancelled(observer)?;
            let start = Instant::now();
            let features = Features::of_kind(s.tree, s.beta, &directions, &pilot);
            let tree = LightTree::build(&features).map_err(crate::SettingsError::from)?;
            let pilot_secs = if s.tree == TreeKind::Geometric { 0.0 } else { pilot_secs };
            known.push((s.tree, s.beta, TimedTree { tree, pilot_secs, tree_secs: start.elapsed().as_secs_f64() }));
        }
        let of = |s: &BakeSettings| known.iter().find(|(kind, beta, _)| (*kind, *beta) == (s.tree, s.beta));
        Ok(settings.iter().filter_map(|s| of(s).map(|(.., tree)| tree.clone())).collect())
    }

    /// The cuts of the points, one chunk for each settings.
    fn chunks(
        &self,
        settings: &[BakeSettings],
        trees: &[TimedTree],
        points: &[u32],
        observer: &dyn Observer,
    ) -> Result<Vec<Chunk>, BakeError> {
        let Some(lights) = settings.first().map(|s| s.lights) else { return Ok(Vec::new()) };
        let sampler = VisibilitySampler::of_directions(&self.geometry.intersector, &fibonacci_directions(lights));
        let height = lights.ilog2();
        let scratch = || {
            let selectors = settings.iter().map(|s| CutSelector::new(height, s.criterion)).collect::<Vec<_>>();
            (vec![0; lights], vec![0; lights], selectors)
        };
        let cuts = self.in_steps(points, observer, scratch, |point, (visible, leaves, selectors)| {
            let rays = sampler.sample(point, visible);
            let select = |(selector, tree): (&mut CutSelector, &TimedTree)| {
                leaves.iter_mut().zip(tree.tree.order()).for_each(|(leaf, &s)| *leaf = visible[s as usize]);
                let mut cut = Vec::new();
                let squared_error = selector.select(leaves, &mut cut);
                (cut, squared_error)
            };
            (rays, selectors.iter_mut().zip(trees).map(select).collect::<Vec<_>>())
        })?;
        let mut chunks = vec![Chunk::default(); settings.len()];
        for (rays, cuts) in cuts {
            for (chunk, (cut, squared_error)) in chunks.iter_mut().zip(cuts) {
                chunk.lengths.push(cut.len() as u32);
                chunk.nodes.extend(cut);
                chunk.squared_error += squared_error;
                chunk.rays += rays;
            }
        }
        Ok(chunks)
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

    fn dataset(
        &self,
        settings: BakeSettings,
        tree: TimedTree,
        chunk: &Chunk,
        points: &[u32],
        visibility_secs: f64,
    ) -> Result<Dataset, BakeError> {
        let geometry = &self.geometry;
        // The last cut is that of all points that are not baked: one node that sees nothing.
        let mut cuts = concatenate(std::slice::from_ref(chunk));
        let mut cut_of_point = vec![cuts.len() as u32; self.points()];
        points.iter().enumerate().for_each(|(i, &point)| cut_of_point[point as usize] = i as u32);
        if points.len() < self.points() {
            cuts.push(vec![0]);
        }
        let of_vertex = geometry.points.of_vertex.iter().map(|&p| cut_of_point[p as usize]);
        let packed = pack(cuts, std::slice::from_ref(chunk), of_vertex, Series::Environment)?;
        let report = self.report(&settings, &tree, &packed, chunk, visibility_secs);
        let mut dataset = Dataset {
            scene: geometry.scene.clone(),
            two_sided: geometry.sides.two_sided.clone(),
            vertex_valid: geometry.points.of_vertex.iter().map(|&p| !geometry.buried[p as usize]).collect(),
            tree: tree.tree,
            cuts: packed.cuts,
            indirect: None,
            meshless: None,
            settings,
            scene_hash: self.hash.clone(),
            report,
        };
        dataset.report.bytes_total = dataset.tensor_bytes();
        Ok(dataset)
    }

    fn report(
        &self,
        settings: &BakeSettings,
        tree: &TimedTree,
        packed: &Packed,
        chunk: &Chunk,
        visibility_secs: f64,
    ) -> BakeReport {
        let points = chunk.lengths.len();
        let pairs = points as u64 * settings.lights as u64;
        let phases = [
            (Phase::Tessellate, self.tessellate_secs),
            (Phase::Pilot, tree.pilot_secs),
            (Phase::Tree, tree.tree_secs),
            (Phase::Visibility, visibility_secs),
        ];
        let mut seconds: BTreeMap<String, f64> = phases.map(|(phase, secs)| (phase.name().into(), secs)).into();
        seconds.insert("total".into(), phases.iter().map(|(_, secs)| secs).sum());
        BakeReport {
            mean_cut: chunk.nodes.len() as f64 / points.max(1) as f64,
            sigma: settings.criterion.sigma,
            rms_visibility: (chunk.squared_error / pairs.max(1) as f64).sqrt(),
            samples_resolved: pairs,
            samples_per_second: pairs as f64 / visibility_secs.max(1e-9),
            bake_points: points,
            seconds,
            ..report(&self.geometry, settings, packed, Vec::new())
        }
    }
}

/// A light tree, and what it took.
#[derive(Clone)]
struct TimedTree {
    tree: LightTree,
    pilot_secs: f64,
    tree_secs: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        BakeJob, bake,
        observer::Silent,
        sidedness::tests::{cuboid, floor, scene_of},
    };

    fn scene() -> Scene {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
        scene_of(&triangles)
    }

    fn variant(tree: TreeKind, sigma: f32) -> Variant {
        Variant { tree, beta: 0.5, criterion: CutCriterion { sigma, ..Default::default() } }
    }

    #[test]
    fn each_variant_is_the_bake_with_its_settings() {
        let variants =
            [variant(TreeKind::Mixed, 1.0), variant(TreeKind::Geometric, 1.0), variant(TreeKind::Mixed, 3.0)];
        let study = Study::new(scene(), Some(300), &Silent).unwrap();
        let all = study.some_points(usize::MAX);
        let made = study.bake(512, 16, &variants, &all, &Silent).unwrap();
        let folder = tempfile::tempdir().unwrap();
        for (dataset, variant) in made.iter().zip(variants) {
            let job = BakeJob {
                settings: dataset.settings.clone(),
                output: folder.path().join("a.cuts"),
                chunks: None,
                resume: false,
                import_secs: 0.0,
                warnings: Vec::new(),
            };
            let baked = bake(scene(), &job, &Silent).unwrap();
            assert_eq!(dataset.cuts, baked.cuts, "{variant:?}");
            assert_eq!((&dataset.tree, &dataset.scene_hash), (&baked.tree, &baked.scene_hash));
            let (a, b) = (&dataset.report, &baked.report);
            assert_eq!((a.mean_cut, a.rms_visibility, a.bytes_cuts), (b.mean_cut, b.rms_visibility, b.bytes_cuts));
            assert_eq!((a.bake_points, a.rays_traced, a.sigma), (b.bake_points, b.rays_traced, b.sigma));
        }
        assert_ne!(made[0].cuts, made[1].cuts, "negative control: another tree");
        assert_ne!(made[0].cuts, made[2].cuts, "negative control: another bound");
    }

    #[test]
    fn points_that_are_left_out_see_nothing_and_do_not_count() {
        let study = Study::new(scene(), Some(300), &Silent).unwrap();
        let all = study.some_points(usize::MAX);
        let some = study.points_of([0, 1, 2, 1]);
        assert!(!some.is_empty() && some.len() <= 3);
        let bake = |points: &[u32]| study.bake(256, 8, &[variant(TreeKind::Geometric, 1.0)], points, &Silent).unwrap();
        let (whole, part) = (&bake(&all)[0], &bake(&some)[0]);
        let cut = |dataset: &Dataset, vertex| dataset.cuts.cut(8, vertex).to_vec();
        assert_eq!(cut(whole, 1), cut(part, 1));
        let other = (0..part.cuts.len() as u32).find(|&v| study.points_of([v]).iter().all(|p| !some.contains(p)));
        assert_eq!(cut(part, other.unwrap()), [0]);
        assert_ne!(cut(whole, other.unwrap()), [0], "negative control");
        let lengths = some.iter().map(|p| {
            let vertex = (0..whole.cuts.len() as u32).find(|&v| study.points_of([v]) == [*p]).unwrap();
            cut(whole, vertex).len() as f64
        });
        assert!((part.report.mean_cut - lengths.sum::<f64>() / some.len() as f64).abs() < 1e-9);
        assert_eq!(study.some_points(10).len(), 10);
    }

    #[test]
    fn visibility_and_pilot_take_any_directions() {
        let study = Study::new(scene(), None, &Silent).unwrap();
        let directions = [Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.8, 0.0)];
        let all = study.some_points(usize::MAX);
        let seen = study.visibility(&directions, &all, &Silent, <[u8]>::to_vec).unwrap();
        assert_eq!(seen.len(), study.points());
        assert!(seen.iter().any(|v| v[0] == 1) && seen.iter().any(|v| v[0] == 0));
        let pilot = study.pilot(&directions, 4, &Silent).unwrap();
        assert_eq!((pilot.lights, pilot.clusters()), (3, 4));
    }
}
