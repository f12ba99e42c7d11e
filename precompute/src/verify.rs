//! Verification: traces a random set of vertices and surface sources again, ray by ray, and compares with the stored
//! cuts. It also recomputes the links of some functions of the meshless basis.

mod meshless;

pub use meshless::MeshlessVerification;

use crate::{
    mesh_surface::MeshSurface,
    sources::sampler::SourceSampler,
    vertices::{
        points::{BakePoint, BakePoints},
        sampler::bake_points,
        visibility::VisibilitySampler,
    },
};
use glam::Vec3;
use lapidary_core::{
    cut::{CutSelector, SourceCutSelector, prune_sources, squared_error},
    dataset::Dataset,
    ray::Intersector,
    surfel::Surface,
};
use rayon::prelude::*;
use serde::Serialize;

/// Largest number of vertices whose cuts over the sources are recomputed: each takes some 30 ms.
const SOURCE_VERTICES: usize = 64;
/// Largest root mean square of stored minus traced visibility, as a multiple of that of an exhaustive bake. The audit of
/// the bake allows 1 % over more vertices.
const MOST_ERROR: f64 = 1.1;
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
    /// Number of these whose cut differs from the stored one.
    pub different_source_cuts: usize,
    /// Surface sources whose cut over the environment was traced and selected again.
    pub sources: usize,
    /// Number of these whose cut differs from the stored one.
    pub different_source_environment_cuts: usize,
    /// Results for the meshless basis, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meshless: Option<MeshlessVerification>,
    /// Whether anything was recomputed and all cuts and links agree. A byte budget coarsens cuts afterwards, so then
    /// only the errors are compared.
    pub passed: bool,
}

/// Traces `count` vertices without packets, chosen by a seed from the scene's hash, and at most as many surface
/// sources. Recomputes the links of at most as many functions.
pub fn verify(dataset: &Dataset, count: usize) -> Verification {
    let mesh = &dataset.scene.mesh;
    let points = bake_points(dataset);
    let intersector = Intersector::new(mesh);
    let sampler = VisibilitySampler::new(&intersector, &dataset.tree, dataset.report.lights_per_probe());
    let check = |vertex: &usize| check_vertex(dataset, &points, &sampler, *vertex);
    let picked = picked_vertices(dataset, count.min(mesh.positions.len()));
    let environment = if dataset.settings.mode.environment() { &picked[..] } else { &[] };
    let results: Vec<Checked> = environment.par_iter().map(check).collect();
    let source_vertices = &picked[..picked.len().min(SOURCE_VERTICES)];
    let (source_vertices, different_source_cuts) = check_sources(dataset, &points, &intersector, source_vertices);
    let (sources, different_source_environment_cuts) =
        check_source_environments(dataset, &intersector, &sampler, count);
    let meshless = meshless::verify(dataset, &intersector, count);
    let made = results.len() + source_vertices + sources + meshless.as_ref().map_or(0, |m| m.functions);
    let different_links = meshless.as_ref().is_some_and(|m| m.different_functions > 0);
    let lights = dataset.tree.len() as f64;
    let pairs = results.len().max(1) as f64 * lights;
    let rms_of = |error: fn(&Checked) -> f64| (results.iter().map(error).sum::<f64>() / pairs).sqrt();
    let (rms, exhaustive_rms) = (rms_of(|r| r.squared_error), rms_of(|r| r.squared_error_exhaustive));
    let worst = results.iter().map(|r| r.squared_error).fold(0.0, f64::max);
    let different_cuts = results.iter().filter(|r| !r.is_equal).count();
    let coarsened = dataset.report.sigma != dataset.settings.criterion.sigma;
    Verification {
        vertices: results.len(),
        source_vertices,
        different_source_cuts,
        sources,
        different_source_environment_cuts,
        rms_visibility: rms,
        expected_rms: dataset.report.rms_visibility,
        exhaustive_rms,
        leaves_wrong: results.iter().map(|r| r.wrong).sum::<u64>() as f64 / pairs,
        different_cuts,
        worst_rms: (worst / lights).sqrt(),
        meshless,
        passed: made > 0
            && different_source_cuts == 0
            && different_source_environment_cuts == 0
            && !different_links
            && if coarsened {
                rms < 4.0 * dataset.report.rms_visibility.max(0.02)
            } else {
                different_cuts == 0 && rms <= MOST_ERROR * exhaustive_rms
            },
    }
}

/// How many of the vertices' cuts over the sources were recomputed, and how many of these differ.
fn check_sources(
    dataset: &Dataset,
    points: &BakePoints,
    intersector: &Intersector,
    vertices: &[usize],
) -> (usize, usize) {
    let Some(indirect) = &dataset.indirect else { return (0, 0) };
    let height = indirect.sources.len().ilog2();
    let offset = MeshSurface::new(&dataset.scene.mesh, intersector, &dataset.two_sided, &|_| Vec3::ZERO).offset();
    let sampler = SourceSampler::new(intersector, &indirect.sources, offset);
    let asked = dataset.settings.indirect.criterion;
    let kept = dataset.report.indirect.as_ref().map_or(asked, |report| report.criterion(asked));
    let places = points.for_sources(&dataset.scene.mesh, intersector, &dataset.settings.shots);
    let differs = |vertex: &&usize| {
        let mut seen = vec![0.0; indirect.sources.len()];
        sampler.sample_singly(&places[points.of_vertex[**vertex] as usize], &mut seen);
        let mut again = Vec::new();
        SourceCutSelector::new(height, asked).select(&seen, &mut again);
        let again = if kept == asked { again } else { prune_sources(height, kept, &again) };
        again != indirect.cuts.cut(height, **vertex as u32)
    };
    (vertices.len(), vertices.par_iter().filter(differs).count())
}

/// How many of the sources' cuts over the environment were recomputed, and how many of these differ.
fn check_source_environments(
    dataset: &Dataset,
    intersector: &Intersector,
    sampler: &VisibilitySampler,
    count: usize,
) -> (usize, usize) {
    let Some(indirect) = dataset.indirect.as_ref().filter(|_| dataset.settings.mode.environment()) else {
        return (0, 0);
    };
    let height = dataset.tree.height();
    let offset = MeshSurface::new(&dataset.scene.mesh, intersector, &dataset.two_sided, &|_| Vec3::ZERO).offset();
    let differs = |source: &&usize| {
        let mut visible = vec![0; dataset.tree.len()];
        sampler.sample_again(
            &dataset.tree,
            &BakePoint::of_surfel(indirect.sources[**source].surfel, offset),
            &mut visible,
        );
        let mut again = Vec::new();
        CutSelector::new(height, dataset.settings.criterion).select(&visible, &mut again);
        again != indirect.environment_cuts.cut(height, **source as u32)
    };
    let count = count.min(SOURCES).min(indirect.sources.len());
    let picked = fastrand::Rng::with_seed(seed(dataset)).choose_multiple(0..indirect.sources.len(), count);
    (picked.len(), picked.par_iter().filter(differs).count())
}

fn picked_vertices(dataset: &Dataset, count: usize) -> Vec<usize> {
    fastrand::Rng::with_seed(seed(dataset)).choose_multiple(0..dataset.scene.mesh.positions.len(), count)
}

/// From the scene's hash: the same scene is verified at the same places.
fn seed(dataset: &Dataset) -> u64 {
    u64::from_str_radix(dataset.scene_hash.get(..16).unwrap_or("0"), 16).unwrap_or(0)
}

/// A vertex that was traced again.
struct Checked {
    /// Sum over the lights of squared differences between stored and traced visibility.
    squared_error: f64,
    squared_error_exhaustive: f64,
    /// Lights that the bake is wrong about.
    wrong: u64,
    /// Whether its cut, made again, is the stored one.
    is_equal: bool,
}

fn check_vertex(dataset: &Dataset, points: &BakePoints, sampler: &VisibilitySampler, vertex: usize) -> Checked {
    let height = dataset.tree.height();
    let (mut traced, mut seen) = (vec![0; dataset.tree.len()], vec![0; dataset.tree.len()]);
    let point = &points.points[points.of_vertex[vertex] as usize];
    sampler.sample_singly(&dataset.tree, point, &mut traced);
    sampler.sample_again(&dataset.tree, point, &mut seen);
    let stored = dataset.cuts.cut(height, vertex as u32);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bake::{
            BakeJob, bake,
            settings::{Preset, resolve},
        },
        observer::Silent,
        test_scenes::{cuboid, floor, scene_of},
    };
    use lapidary_core::{
        cut::{SourceCriterion, packed::PackedCuts},
        dataset::{BakeParts, BakeSettings, IndirectSettings},
    };

    fn box_over_floor(settings: BakeSettings) -> Dataset {
        let folder = tempfile::tempdir().unwrap();
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
        let job = BakeJob::new(resolve(settings).unwrap(), folder.path().join("a.cuts"));
        bake(scene_of(&triangles), &job, &Silent).unwrap()
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
        offsets.rotate_left(1);
        dataset.cuts = PackedCuts::from_parts(8, dataset.cuts.nodes().to_vec(), offsets).unwrap();
        let bad = verify(&dataset, all);
        assert!(!bad.passed && bad.rms_visibility > 1.7 * good.rms_visibility, "{bad:?}");
        assert!(!verify(&dataset, 0).passed, "nothing was checked");
    }

    #[test]
    fn what_boundaries_tell_is_made_again_and_its_error_told() {
        let settings = BakeSettings { lights: 2048, max_vertices: Some(300), ..Preset::Draft.settings() };
        let mut dataset = box_over_floor(settings);
        let all = dataset.scene.mesh.positions.len();
        let good = verify(&dataset, all);
        let mut audit = dataset.report.audit.unwrap();
        assert!(audit.lights_per_probe > 1 && good.passed && good.different_cuts == 0, "{good:?}");
        assert!(good.leaves_wrong < 1e-3 && good.rms_visibility <= 1.02 * good.exhaustive_rms, "{good:?}");
        // Probes so far apart that shadows are missed: the cuts are other ones.
        audit.lights_per_probe = 512;
        dataset.report.audit = Some(audit);
        let bad = verify(&dataset, all);
        assert!(!bad.passed && bad.different_cuts > 0 && bad.leaves_wrong > good.leaves_wrong, "{bad:?}");
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
