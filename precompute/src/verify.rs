//! Verification: traces a random set of vertices again, ray by ray, and compares with the stored cuts.

use crate::{bake_points::BakePoints, sidedness::Sidedness, visibility::VisibilitySampler};
use lapidary_core::{
    cut::{
        CutSelector,
        packed::{depth, value},
    },
    dataset::Dataset,
    ray::Intersector,
};
use rayon::prelude::*;
use serde::Serialize;

/// What a verification found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// Vertices traced again.
    pub vertices: usize,
    /// Root mean square of stored minus traced visibility over their lights.
    pub rms_visibility: f64,
    /// That of the whole bake, from its report.
    pub expected_rms: f64,
    /// Vertices whose cut, selected again from what was traced, differs from the stored one.
    pub different_cuts: usize,
    /// Largest root mean square of one vertex.
    pub worst_rms: f64,
    /// Whether all cuts agree. A byte budget coarsens cuts afterwards, so then the errors alone are compared.
    pub passed: bool,
}

/// Traces `count` vertices, picked by a seed from the scene's hash, without packets.
pub fn verify(dataset: &Dataset, count: usize) -> Verification {
    let mesh = &dataset.scene.mesh;
    let closed = vec![true; mesh.triangles.len()]; // only burial needs it, and that is stored
    let sides = Sidedness { two_sided: dataset.two_sided.clone(), closed };
    let points = BakePoints::new(mesh, &sides);
    let intersector = Intersector::new(mesh);
    let sampler = VisibilitySampler::new(&intersector, &dataset.tree);
    let count = count.min(mesh.positions.len());
    let check = |vertex: &usize| check_vertex(dataset, &points, &sampler, *vertex);
    let results: Vec<(f64, bool)> = picked_vertices(dataset, count).par_iter().map(check).collect();
    let lights = dataset.tree.len() as f64;
    let total: f64 = results.iter().map(|r| r.0).sum();
    let worst = results.iter().map(|r| r.0).fold(0.0, f64::max);
    let different_cuts = results.iter().filter(|r| !r.1).count();
    let rms = (total / (count.max(1) as f64 * lights)).sqrt();
    let coarsened = dataset.report.sigma != dataset.settings.criterion.sigma;
    Verification {
        vertices: count,
        rms_visibility: rms,
        expected_rms: dataset.report.rms_visibility,
        different_cuts,
        worst_rms: (worst / lights).sqrt(),
        passed: if coarsened { rms < 4.0 * dataset.report.rms_visibility.max(0.02) } else { different_cuts == 0 },
    }
}

fn picked_vertices(dataset: &Dataset, count: usize) -> Vec<usize> {
    let seed = u64::from_str_radix(dataset.scene_hash.get(..16).unwrap_or("0"), 16).unwrap_or(0);
    fastrand::Rng::with_seed(seed).choose_multiple(0..dataset.scene.mesh.positions.len(), count)
}

/// Sum of squared differences over the lights, and whether selecting again gives the stored cut.
fn check_vertex(dataset: &Dataset, points: &BakePoints, sampler: &VisibilitySampler, vertex: usize) -> (f64, bool) {
    let height = dataset.tree.height();
    let mut visible = vec![0; dataset.tree.len()];
    let point = &points.points[points.of_vertex[vertex] as usize];
    sampler.sample_singly(&dataset.tree, point, &mut visible);
    let stored = dataset.cuts.cut(height, vertex as u32);
    let mut again = Vec::new();
    CutSelector::new(height, dataset.settings.criterion).select(&visible, &mut again);
    let mut leaf = 0;
    let mut squared_error = 0.0;
    for &node in stored {
        let end = leaf + (1 << (height - depth(node)));
        squared_error +=
            visible[leaf..end].iter().map(|&v| (f64::from(v) - f64::from(value(node))).powi(2)).sum::<f64>();
        leaf = end;
    }
    (squared_error, again == stored)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        BakeJob, Preset, Silent, bake,
        sidedness::tests::{cuboid, floor, scene_of},
    };
    use glam::Vec3;
    use lapidary_core::{cut::packed::PackedCuts, dataset::BakeSettings};

    #[test]
    fn a_fresh_bake_passes_and_a_swapped_cut_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
        let job = BakeJob {
            settings: BakeSettings { lights: 256, max_vertices: Some(300), ..Preset::Draft.settings() },
            output: folder.path().join("a.cuts"),
            chunks: None,
            resume: false,
            import_secs: 0.0,
            warnings: Vec::new(),
        };
        let mut dataset = bake(scene_of(&triangles), &job, &Silent).unwrap();
        let all = dataset.scene.mesh.positions.len();
        let good = verify(&dataset, all);
        assert!(good.passed, "{good:?}");
        assert!((good.rms_visibility - good.expected_rms).abs() < 0.02, "{good:?}");
        let mut offsets = dataset.cuts.offsets().to_vec();
        offsets.rotate_left(1);
        dataset.cuts = PackedCuts::from_parts(8, dataset.cuts.nodes().to_vec(), offsets).unwrap();
        let bad = verify(&dataset, all);
        assert!(!bad.passed && bad.rms_visibility > 1.7 * good.rms_visibility, "{bad:?}");
    }
}
