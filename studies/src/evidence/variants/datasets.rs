//! Datasets of the variants: trees, all cuts from one tracing, reports.

use super::{Variant, VariantBaker};
use lapidary_core::{
    cut::CutSelector,
    dataset::{BakeRun, BakeSettings, Dataset},
    light_tree::{Features, LightTree, PilotVisibility, TreeKind},
    sphere::fibonacci_directions,
};
use lapidary_precompute::{BakeError, Chunk, Observer, Phase, Preset, ResolvedBake, SettingsError, resolve};
use std::{collections::BTreeMap, time::Instant};

impl VariantBaker {
    /// A dataset for each of `variants`, with cuts for `points` and fully occluded cuts for all others. Reports cover `points`
    /// alone; the seconds of tracing are shared by all variants, and each alone would take as long.
    ///
    /// # Errors
    /// Settings out of range, cuts too large for a texture, or [`BakeError::Cancelled`].
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
        // All variants share one tracing of every light in its own order.
        let of_variant = BakeSettings { lights, tree, beta, criterion, exhaustive: true, ..normal };
        Ok(resolve(BakeSettings { pilot_clusters, max_vertices, ..of_variant })?)
    }

    /// The tree of each settings entry; equal ones are built once.
    fn trees(&self, settings: &[ResolvedBake], observer: &dyn Observer) -> Result<Vec<TimedTree>, BakeError> {
        let Some(first) = settings.first() else { return Ok(Vec::new()) };
        let directions = fibonacci_directions(first.lights);
        let mut pilot = PilotVisibility { lights: first.lights, fractions: Vec::new() };
        let mut pilot_secs = 0.0;
        if settings.iter().any(|s| s.tree != TreeKind::Geometric) {
            let start = Instant::now();
            pilot = self.geometry.pilot(&directions, first.pilot_clusters, observer)?;
            pilot_secs = start.elapsed().as_secs_f64();
        }
        let mut known: Vec<(TreeKind, f32, TimedTree)> = Vec::new();
        for s in settings {
            if known.iter().any(|(kind, beta, _)| (*kind, *beta) == (s.tree, s.beta)) {
                continue;
            }
            if observer.cancelled() {
                return Err(BakeError::Cancelled);
            }
            let start = Instant::now();
            let features = Features::of_kind(s.tree, s.beta, &directions, &pilot);
            let tree = LightTree::build(&features).map_err(SettingsError::from)?;
            let pilot_secs = if s.tree == TreeKind::Geometric { 0.0 } else { pilot_secs };
            known.push((s.tree, s.beta, TimedTree { tree, pilot_secs, tree_secs: start.elapsed().as_secs_f64() }));
        }
        let of = |s: &ResolvedBake| known.iter().find(|(kind, beta, _)| (*kind, *beta) == (s.tree, s.beta));
        Ok(settings.iter().filter_map(|s| of(s).map(|(.., tree)| tree.clone())).collect())
    }

    /// The cuts of the points, one chunk per settings entry.
    fn chunks(
        &self,
        settings: &[ResolvedBake],
        trees: &[TimedTree],
        points: &[u32],
        observer: &dyn Observer,
    ) -> Result<Vec<Chunk>, BakeError> {
        let Some(lights) = settings.first().map(|s| s.lights) else { return Ok(Vec::new()) };
        let height = lights.ilog2();
        let scratch = || {
            let selectors = settings.iter().map(|s| CutSelector::new(height, s.criterion)).collect::<Vec<_>>();
            (vec![0; lights], selectors)
        };
        let select = |visible: &[u8], rays, (leaves, selectors): &mut (Vec<u8>, Vec<CutSelector>)| {
            let select = |(selector, tree): (&mut CutSelector, &TimedTree)| {
                leaves.iter_mut().zip(tree.tree.order()).for_each(|(leaf, &s)| *leaf = visible[s as usize]);
                let mut cut = Vec::new();
                let squared_error = selector.select(leaves, &mut cut);
                (cut, squared_error)
            };
            (rays, selectors.iter_mut().zip(trees).map(select).collect::<Vec<_>>())
        };
        let directions = fibonacci_directions(lights);
        let cuts = self.geometry.visibility(&directions, points, observer, scratch, select)?;
        let mut chunks = vec![Chunk::default(); settings.len()];
        for (rays, cuts) in cuts {
            for (chunk, (cut, squared_error)) in chunks.iter_mut().zip(cuts) {
                chunk.push(&cut, squared_error, rays);
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
        let TimedTree { tree, pilot_secs, tree_secs } = tree;
        let mut dataset = self.geometry.environment_dataset(settings, tree, points, chunk)?;
        dataset.scene_hash.clone_from(&self.hash);
        let phases = [
            (Phase::Tessellate, self.tessellate_secs),
            (Phase::Pilot, pilot_secs),
            (Phase::Tree, tree_secs),
            (Phase::Visibility, visibility_secs),
        ];
        let mut seconds: BTreeMap<String, f64> = phases.map(|(phase, secs)| (phase.name().into(), secs)).into();
        seconds.insert("total".into(), phases.iter().map(|(_, secs)| secs).sum());
        let samples_per_second = dataset.report.samples_resolved as f64 / visibility_secs.max(1e-9);
        dataset.report.run = Some(BakeRun { seconds, samples_per_second, ..Default::default() });
        Ok(dataset)
    }
}

/// A light tree and the time to build it.
#[derive(Clone)]
struct TimedTree {
    tree: LightTree,
    pilot_secs: f64,
    tree_secs: f64,
}
