//! Datasets of a study: trees, cuts of all of them from one tracing, reports.

use super::{Study, Variant};
use crate::{
    bake::{
        Packed,
        checkpoint::Chunk,
        concatenate, pack, report,
        settings::{Preset, ResolvedBake, resolve},
    },
    errors::{BakeError, CutsOf, SettingsError, cancelled},
    observer::{Event, Observer, Phase},
    vertices::{pilot::sample_pilot, visibility::VisibilitySampler},
};
use lapidary_core::{
    cut::CutSelector,
    dataset::{BakeReport, BakeSettings, Dataset},
    light_tree::{Features, LightTree, PilotVisibility, TreeKind},
    sphere::fibonacci_directions,
};
use std::{collections::BTreeMap, time::Instant};

impl Study {
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

    fn settings(&self, lights: usize, pilot_clusters: usize, variant: Variant) -> Result<ResolvedBake, BakeError> {
        let Variant { tree, beta, criterion } = variant;
        let normal = Preset::Normal.settings();
        let max_vertices = self.max_vertices;
        Ok(resolve(BakeSettings { lights, tree, beta, criterion, pilot_clusters, max_vertices, ..normal })?)
    }

    /// The tree of each settings; equal ones are clustered once.
    fn trees(&self, settings: &[ResolvedBake], observer: &dyn Observer) -> Result<Vec<TimedTree>, BakeError> {
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
            let tree = LightTree::build(&features).map_err(SettingsError::from)?;
            let pilot_secs = if s.tree == TreeKind::Geometric { 0.0 } else { pilot_secs };
            known.push((s.tree, s.beta, TimedTree { tree, pilot_secs, tree_secs: start.elapsed().as_secs_f64() }));
        }
        let of = |s: &ResolvedBake| known.iter().find(|(kind, beta, _)| (*kind, *beta) == (s.tree, s.beta));
        Ok(settings.iter().filter_map(|s| of(s).map(|(.., tree)| tree.clone())).collect())
    }

    /// The cuts of the points, one chunk for each settings.
    fn chunks(
        &self,
        settings: &[ResolvedBake],
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

    fn dataset(
        &self,
        settings: ResolvedBake,
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
        let packed = pack(cuts, std::slice::from_ref(chunk), of_vertex, CutsOf::Environment)?;
        let report = self.report(&settings, &tree, &packed, chunk, visibility_secs);
        let mut dataset = Dataset {
            scene: geometry.scene.clone(),
            two_sided: geometry.sides.two_sided.clone(),
            vertex_valid: geometry.points.of_vertex.iter().map(|&p| !geometry.buried[p as usize]).collect(),
            tree: tree.tree,
            cuts: packed.cuts,
            indirect: None,
            meshless: None,
            settings: settings.into_settings(),
            scene_hash: self.hash.clone(),
            report,
        };
        dataset.report.bytes_total = dataset.tensor_bytes();
        Ok(dataset)
    }

    fn report(
        &self,
        settings: &ResolvedBake,
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
