//! Verification: traces a random set of vertices and surface sources again, ray by ray, and compares with the stored
//! cuts. It also recomputes the links of some functions of the meshless basis.

mod meshless;

pub use meshless::MeshlessVerification;

use crate::{
    mesh_surface::MeshSurface,
    sources::{
        error::{relative_rms, squared_norm},
        sampler::SourceSampler,
    },
    vertices::{
        points::{BakePoint, BakePoints},
        sampler::bake_points,
        visibility::{EXHAUSTIVE, VisibilitySampler},
    },
};
use glam::Vec3;
use lapidary_core::{
    cut::{CutSelector, SourceCutSelector, prune_sources, solid_angle_error, squared_error},
    dataset::{Dataset, IndirectReport},
    ray::Intersector,
    surfel::Surface,
};
use rayon::prelude::*;
use serde::Serialize;

/// Largest share of rays that may fall to another side of an edge on a device; ten times what was seen in tests.
const ALONG_EDGES: f64 = 1e-4;
/// Largest number of vertices whose cuts over the sources are recomputed: each takes some 30 ms.
const SOURCE_VERTICES: usize = 64;
/// Largest root mean square of stored minus traced visibility, as a multiple of that of an exhaustive bake. The audit of
/// the bake allows 1 % over more vertices.
const MOST_ERROR_OF_FEW: f64 = 1.1;
/// Largest number of sources whose cuts over the environment are recomputed.
const SOURCES: usize = 64;

/// Results of a verification.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// Vertices traced again.
    pub vertices: usize,
    /// Root mean square of stored minus traced visibility over their lights.
    pub rms_visibility: f64,
    /// The same error of the whole bake, from its report.
    pub expected_rms: f64,
    /// The same of cuts that are selected from what was traced: what an exhaustive bake would have.
    pub exhaustive_rms: f64,
    /// Share of the lights of these vertices that the bake takes for seen and are blocked, or the reverse; 0 to 1.
    pub leaves_wrong: f64,
    /// Vertices whose cut, made again as the bake does, differs from the stored one.
    pub different_cuts: usize,
    /// Largest root mean square of one vertex.
    pub worst_rms: f64,
    /// Vertices whose cut over the surface sources was traced and selected again, segment by segment.
    pub source_vertices: usize,
    /// Number of these whose cut, made again as the bake does, differs from the stored one.
    pub different_source_cuts: usize,
    /// Share of the sources that the bake takes for seen and are hidden, or the reverse; 0 to 1.
    pub sources_wrong: f64,
    /// Root mean square over these vertices of `||stored - traced||` for solid angles, as a share of `||traced||`, or of its mean
    /// where that is larger.
    pub source_error: f64,
    /// The same of cuts that are selected from what was traced: what an exhaustive bake would have.
    pub exhaustive_source_error: f64,
    /// Surface sources whose cut over the environment was traced and selected again.
    pub sources: usize,
    /// Number of these whose cut differs from the stored one.
    pub different_source_environment_cuts: usize,
    /// Results for the meshless basis, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meshless: Option<MeshlessVerification>,
    /// Whether anything was recomputed, all cuts and links agree, and cuts are hardly worse than those of an exhaustive bake.
    /// A byte budget coarsens cuts over the environment afterwards, so of these only the errors are compared.
    pub passed: bool,
}

/// Traces `count` vertices without packets, chosen by a seed from the scene's hash, and at most as many surface
/// sources. Recomputes the links of at most as many functions.
pub fn verify(dataset: &Dataset, count: usize) -> Verification {
    let mesh = &dataset.scene.mesh;
    let points = bake_points(dataset);
    let intersector = Intersector::of_scene(&dataset.scene);
    let sampler = VisibilitySampler::new(&intersector, &dataset.tree, dataset.report.lights_per_probe());
    let check = |vertex: &usize| {
        let stored = dataset.cuts.cut(dataset.tree.height(), *vertex as u32);
        check_cut(dataset, &sampler, &points.points[points.of_vertex[*vertex] as usize], stored)
    };
    let picked = picked_vertices(dataset, count.min(mesh.positions.len()));
    let environment = if dataset.settings.mode.environment() { &picked[..] } else { &[] };
    let results: Vec<Checked> = environment.par_iter().map(check).collect();
    let source_vertices = &picked[..picked.len().min(SOURCE_VERTICES)];
    let of_sources = check_sources(dataset, &points, &intersector, source_vertices);
    let sources = check_source_environments(dataset, &intersector, &sampler, count);
    let meshless = meshless::verify(dataset, &intersector, count);
    let made = results.len() + of_sources.vertices + sources.len() + meshless.as_ref().map_or(0, |m| m.functions);
    let different_links = meshless.as_ref().is_some_and(|m| m.different_functions > 0);
    let lights = dataset.tree.len() as f64;
    let pairs = results.len().max(1) as f64 * lights;
    let rms = mean(&results, |r| r.squared_error, lights).sqrt();
    let worst = results.iter().map(|r| r.squared_error).fold(0.0, f64::max);
    let on_device = dataset.report.on_device;
    let coarsened = dataset.report.sigma != dataset.settings.criterion.sigma;
    Verification {
        vertices: results.len(),
        source_vertices: of_sources.vertices,
        different_source_cuts: of_sources.different,
        sources_wrong: of_sources.wrong,
        source_error: of_sources.errors[0],
        exhaustive_source_error: of_sources.errors[1],
        sources: sources.len(),
        different_source_environment_cuts: different(&sources),
        rms_visibility: rms,
        expected_rms: dataset.report.rms_visibility,
        exhaustive_rms: mean(&results, |r| r.squared_error_exhaustive, lights).sqrt(),
        leaves_wrong: results.iter().map(|r| r.wrong).sum::<u64>() as f64 / pairs,
        different_cuts: different(&results),
        worst_rms: (worst / lights).sqrt(),
        meshless,
        passed: made > 0
            && of_sources.agree()
            && agree(&sources, lights, on_device)
            && !different_links
            && if coarsened {
                rms < 4.0 * dataset.report.rms_visibility.max(0.02)
            } else {
                agree(&results, lights, on_device)
            },
    }
}

/// Cuts over the sources that were made again.
#[derive(Default)]
struct CheckedSources {
    vertices: usize,
    /// Number of these whose cut differs from the stored one.
    different: usize,
    /// Share of the sources that the bake is wrong about.
    wrong: f64,
    /// [`relative_rms`] of the stored cuts and of those of an exhaustive bake.
    errors: [f64; 2],
}

impl CheckedSources {
    /// Whether the cuts are the stored ones and hardly worse than those of an exhaustive bake. Of a few vertices one may see
    /// hardly anything, and decide the error.
    fn agree(&self) -> bool {
        const ENOUGH: usize = 16;
        let [stored, exhaustive] = self.errors;
        self.different == 0 && (self.vertices < ENOUGH || stored <= MOST_ERROR_OF_FEW * exhaustive)
    }
}

/// One of them.
struct CheckedSourceCut {
    is_equal: bool,
    wrong: usize,
    /// Of the stored cut and of that of an exhaustive bake.
    squared_errors: [f64; 2],
    squared_norm: f64,
}

fn check_sources(
    dataset: &Dataset,
    points: &BakePoints,
    intersector: &Intersector,
    vertices: &[usize],
) -> CheckedSources {
    let Some(indirect) = &dataset.indirect else { return CheckedSources::default() };
    let report = dataset.report.indirect.as_ref();
    let (count, height) = (indirect.sources.len(), indirect.sources.len().ilog2());
    let offset = MeshSurface::new(&dataset.scene.mesh, intersector, &dataset.two_sided, &|_| Vec3::ZERO).offset();
    let sampler = SourceSampler::new(
        intersector,
        &indirect.sources,
        offset,
        report.map_or(EXHAUSTIVE, IndirectReport::sources_per_probe),
    );
    let asked = dataset.settings.indirect.criterion;
    let kept = report.map_or(asked, |report| report.criterion(asked));
    let places = points.for_sources(&dataset.scene.mesh, intersector, &dataset.settings.shots);
    let check = |&vertex: &usize| {
        let place = &places[points.of_vertex[vertex] as usize];
        let (mut traced, mut seen) = (vec![0.0; count], vec![0.0; count]);
        sampler.sample_singly(place, &mut traced);
        sampler.sample_again(place, &mut seen);
        let cut_of = |leaves: &[f32]| {
            let mut cut = Vec::new();
            SourceCutSelector::new(height, asked).select(leaves, &mut cut);
            if kept == asked { cut } else { prune_sources(height, kept, &cut) }
        };
        let stored = indirect.cuts.cut(height, vertex as u32);
        CheckedSourceCut {
            is_equal: cut_of(&seen) == stored,
            wrong: traced.iter().zip(&seen).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).count(),
            squared_errors: [stored, &cut_of(&traced)].map(|cut| solid_angle_error(height, cut, &traced)),
            squared_norm: squared_norm(&traced),
        }
    };
    let checked: Vec<CheckedSourceCut> = vertices.par_iter().map(check).collect();
    let rms =
        |of: usize| relative_rms(&checked.iter().map(|c| (c.squared_errors[of], c.squared_norm)).collect::<Vec<_>>());
    CheckedSources {
        vertices: vertices.len(),
        different: checked.iter().filter(|c| !c.is_equal).count(),
        wrong: checked.iter().map(|c| c.wrong).sum::<usize>() as f64 / (vertices.len() * count).max(1) as f64,
        errors: [0, 1].map(rms),
    }
}

/// Some of the sources' cuts over the environment, made again.
fn check_source_environments(
    dataset: &Dataset,
    intersector: &Intersector,
    sampler: &VisibilitySampler,
    count: usize,
) -> Vec<Checked> {
    let Some(indirect) = dataset.indirect.as_ref().filter(|_| dataset.settings.mode.environment()) else {
        return Vec::new();
    };
    let offset = MeshSurface::new(&dataset.scene.mesh, intersector, &dataset.two_sided, &|_| Vec3::ZERO).offset();
    let check = |source: &usize| {
        let point = BakePoint::of_surfel(indirect.sources[*source].surfel, offset);
        check_cut(dataset, sampler, &point, indirect.environment_cuts.cut(dataset.tree.height(), *source as u32))
    };
    let count = count.min(SOURCES).min(indirect.sources.len());
    let picked = fastrand::Rng::with_seed(seed(dataset)).choose_multiple(0..indirect.sources.len(), count);
    picked.par_iter().map(check).collect()
}

fn picked_vertices(dataset: &Dataset, count: usize) -> Vec<usize> {
    fastrand::Rng::with_seed(seed(dataset)).choose_multiple(0..dataset.scene.mesh.positions.len(), count)
}

/// From the scene's hash: the same scene is verified at the same places.
fn seed(dataset: &Dataset) -> u64 {
    u64::from_str_radix(dataset.scene_hash.get(..16).unwrap_or("0"), 16).unwrap_or(0)
}

/// A cut over the environment that was made again.
struct Checked {
    /// Sum over the lights of squared differences between stored and traced visibility.
    squared_error: f64,
    squared_error_exhaustive: f64,
    /// Lights that the bake is wrong about.
    wrong: u64,
    /// Whether the cut, made again, is the stored one.
    is_equal: bool,
}

fn check_cut(dataset: &Dataset, sampler: &VisibilitySampler, point: &BakePoint, stored: &[u16]) -> Checked {
    let height = dataset.tree.height();
    let (mut traced, mut seen) = (vec![0; dataset.tree.len()], vec![0; dataset.tree.len()]);
    sampler.sample_singly(&dataset.tree, point, &mut traced);
    sampler.sample_again(&dataset.tree, point, &mut seen);
    let mut selector = CutSelector::new(height, dataset.settings.criterion);
    let (mut again, mut exhaustive) = (Vec::new(), Vec::new());
    selector.select(&seen, &mut again);
    Checked {
        squared_error: squared_error(height, stored, &traced),
        squared_error_exhaustive: selector.select(&traced, &mut exhaustive),
        wrong: traced.iter().zip(&seen).filter(|(a, b)| a != b).count() as u64,
        is_equal: again == stored,
    }
}

/// Whether the cuts are the stored ones and hardly worse than those of an exhaustive bake. What a device traced need not be
/// equal: one ray along an edge makes another cut. It must be as good.
fn agree(cuts: &[Checked], lights: f64, on_device: bool) -> bool {
    let along_edges = if on_device { ALONG_EDGES } else { 0.0 };
    let least = MOST_ERROR_OF_FEW * MOST_ERROR_OF_FEW * mean(cuts, |c| c.squared_error_exhaustive, lights);
    (on_device || different(cuts) == 0) && mean(cuts, |c| c.squared_error, lights) <= least + along_edges
}

fn different(cuts: &[Checked]) -> usize {
    cuts.iter().filter(|cut| !cut.is_equal).count()
}

/// Mean over cuts and lights.
fn mean(cuts: &[Checked], error: fn(&Checked) -> f64, lights: f64) -> f64 {
    cuts.iter().map(error).sum::<f64>() / (cuts.len().max(1) as f64 * lights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bake::{
            BakeJob, bake,
            settings::{Preset, resolve},
        },
        observer::Silent,
        test_scenes::{cuboid, floor, room, scene_of},
    };
    use lapidary_core::{
        cut::{
            CutCriterion, SourceCriterion,
            packed::{PackedCuts, depth, value},
        },
        dataset::{BakeParts, BakeSettings, IndirectSettings},
        ray::OPEN,
    };

    fn box_over_floor(settings: BakeSettings) -> Dataset {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
        baked(&triangles, settings)
    }

    fn baked(triangles: &[[Vec3; 3]], settings: BakeSettings) -> Dataset {
        let folder = tempfile::tempdir().unwrap();
        let job = BakeJob::new(resolve(settings).unwrap(), folder.path().join("a.cuts"));
        bake(scene_of(triangles), &job, &Silent).unwrap()
    }

    #[test]
    fn vertices_are_traced_as_the_bake_did() {
        let settings = BakeSettings { lights: 256, max_vertices: Some(300), ..Preset::Draft.settings() };
        let dataset = box_over_floor(settings);
        let intersector = Intersector::new(&dataset.scene.mesh);
        let sampler = crate::VertexSampler::new(&dataset, &intersector);
        let mut selector = CutSelector::new(8, dataset.settings.criterion);
        let mut selected = |vertex: u32| {
            let (mut visible, mut cut) = (vec![0; 256], Vec::new());
            sampler.sample(vertex, &mut visible);
            selector.select(&visible, &mut cut);
            cut
        };
        let vertices = dataset.scene.mesh.positions.len() as u32;
        assert!((0..vertices).all(|vertex| selected(vertex) == dataset.cuts.cut(8, vertex)));
        assert!((1..vertices).any(|vertex| selected(vertex - 1) != dataset.cuts.cut(8, vertex)), "negative control");
    }

    #[test]
    fn a_fresh_bake_passes_and_a_swapped_cut_does_not() {
        let settings = BakeSettings { lights: 256, max_vertices: Some(300), ..Preset::Draft.settings() };
        let mut dataset = box_over_floor(settings);
        let all = dataset.scene.mesh.positions.len();
        let good = verify(&dataset, all);
        assert!(good.passed, "{good:?}");
        assert!((good.rms_visibility - good.expected_rms).abs() < 0.02, "{good:?}");
        let mut offsets = dataset.cuts.offsets().to_vec();
        offsets.rotate_left(all / 2);
        dataset.cuts = PackedCuts::from_parts(8, dataset.cuts.nodes().to_vec(), offsets).unwrap();
        let bad = verify(&dataset, all);
        assert!(!bad.passed && bad.rms_visibility > 1.7 * good.rms_visibility, "{bad:?}");
        dataset.report.on_device = true;
        assert!(!verify(&dataset, all).passed, "a device is no excuse");
        assert!(!verify(&dataset, 0).passed, "nothing was checked");
    }

    #[test]
    fn a_ray_along_an_edge_may_fall_to_the_other_side_on_a_device_alone() {
        let criterion = CutCriterion { sigma: 0.0, ..Default::default() };
        let settings = BakeSettings { lights: 256, criterion, exhaustive: true, ..Preset::Draft.settings() };
        let mut dataset = box_over_floor(BakeSettings { max_vertices: Some(300), ..settings });
        let all = dataset.scene.mesh.positions.len();
        // One light of one vertex is seen and was blocked, or the reverse: less than a ray in 10,000 of all.
        let mut cuts = PackedCuts::default();
        for vertex in 0..all as u32 {
            let mut leaves: Vec<u8> = Vec::new();
            for &node in dataset.cuts.cut(8, vertex) {
                leaves.extend(std::iter::repeat_n(OPEN * u8::from(value(node) > 0.5), 256 >> depth(node)));
            }
            leaves[100] ^= OPEN * u8::from(vertex == 7);
            let mut cut = Vec::new();
            CutSelector::new(8, criterion).select(&leaves, &mut cut);
            let offset = cuts.push_cut(&cut);
            cuts.push_vertex(offset);
        }
        dataset.cuts = cuts;
        let bad = verify(&dataset, all);
        assert!(!bad.passed && bad.different_cuts == 1, "{bad:?}");
        dataset.report.on_device = true;
        assert!(verify(&dataset, all).passed);
    }

    #[test]
    fn what_boundaries_tell_is_made_again_and_its_error_told() {
        let settings = BakeSettings { lights: 2048, max_vertices: Some(300), ..Preset::Draft.settings() };
        let mut dataset = box_over_floor(settings);
        let all = dataset.scene.mesh.positions.len();
        let good = verify(&dataset, all);
        let mut audit = dataset.report.audit.unwrap();
        assert!(audit.leaves_per_probe > 1 && good.passed && good.different_cuts == 0, "{good:?}");
        assert!(good.leaves_wrong < 1e-3 && good.rms_visibility <= 1.02 * good.exhaustive_rms, "{good:?}");
        // Probes so far apart that shadows are missed: the cuts are other ones.
        audit.leaves_per_probe = 512;
        dataset.report.audit = Some(audit);
        let bad = verify(&dataset, all);
        assert!(!bad.passed && bad.different_cuts > 0 && bad.leaves_wrong > good.leaves_wrong, "{bad:?}");
    }

    #[test]
    fn what_boundaries_tell_of_sources_is_made_again_and_its_error_told() {
        let indirect = IndirectSettings { sources: 4096, ..Default::default() };
        let settings = BakeSettings { mode: BakeParts::INDIRECT, indirect, lights: 256, ..Preset::Draft.settings() };
        let mut triangles = room(Vec3::ZERO, Vec3::ONE);
        triangles.extend(cuboid(Vec3::new(0.2, -0.5, 0.1), Vec3::splat(0.3)));
        let mut dataset = baked(&triangles, BakeSettings { max_vertices: Some(300), pilot_clusters: 16, ..settings });
        let good = verify(&dataset, 64);
        assert!(good.passed && good.source_vertices > 0 && good.different_source_cuts == 0, "{good:?}");
        assert!(good.sources_wrong < 5e-3 && good.source_error <= 1.02 * good.exhaustive_source_error, "{good:?}");
        // Probes so far apart that shadows are missed: the cuts are other ones.
        let audit = dataset.report.indirect.as_mut().unwrap().audit.as_mut().unwrap();
        assert!(audit.leaves_per_probe > 1);
        audit.leaves_per_probe = 1024;
        let bad = verify(&dataset, 64);
        assert!(!bad.passed && bad.different_source_cuts > 0 && bad.sources_wrong > good.sources_wrong, "{bad:?}");
    }

    #[test]
    fn source_cuts_that_were_coarsened_to_fit_agree() {
        let criterion = SourceCriterion { sigma: 0.25, contrast: 0.05, ..Default::default() };
        let indirect = IndirectSettings { sources: 256, criterion, ..Default::default() };
        let settings = BakeSettings { mode: BakeParts::INDIRECT, indirect, lights: 256, ..Preset::Draft.settings() };
        let mut dataset = box_over_floor(BakeSettings { max_vertices: None, pilot_clusters: 16, ..settings });
        let coarser = dataset.settings.indirect.criterion.coarser(8.0);
        let baked = dataset.indirect.as_mut().unwrap();
        let mut coarsened = PackedCuts::default();
        for vertex in 0..dataset.scene.mesh.positions.len() as u32 {
            let offset = coarsened.push_cut(&prune_sources(8, coarser, baked.cuts.cut(8, vertex)));
            coarsened.push_vertex(offset);
        }
        assert!(coarsened.nodes().len() < baked.cuts.nodes().len());
        baked.cuts = coarsened;
        assert!(!verify(&dataset, 64).passed, "negative control: nothing says that they were");
        dataset.report.indirect.as_mut().unwrap().coarsened = Some(8.0);
        let good = verify(&dataset, 64);
        assert!(good.passed && good.source_vertices > 0, "{good:?}");
    }

    #[test]
    fn what_sources_see_of_the_environment_is_traced_again() {
        let indirect = IndirectSettings { sources: 256, ..Default::default() };
        let settings = BakeSettings { mode: BakeParts::CUTS, indirect, lights: 256, ..Preset::Draft.settings() };
        let mut dataset = box_over_floor(BakeSettings { max_vertices: None, pilot_clusters: 16, ..settings });
        let good = verify(&dataset, 64);
        assert!(good.passed && good.sources == 64, "{good:?}");
        let indirect = dataset.indirect.as_mut().unwrap();
        let mut offsets = indirect.environment_cuts.offsets().to_vec();
        offsets.rotate_left(1);
        let nodes = indirect.environment_cuts.nodes().to_vec();
        indirect.environment_cuts = PackedCuts::from_parts(8, nodes, offsets).unwrap();
        let bad = verify(&dataset, 64);
        assert!(!bad.passed && bad.different_source_environment_cuts > 8 && bad.different_cuts == 0, "{bad:?}");
    }
}
