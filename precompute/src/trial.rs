//! A small trial bake: a few points, traced as in a bake, predict the cost of the whole before it starts.

mod bounces;
mod meshless;
mod sources;

pub use bounces::BounceTrial;
pub use meshless::BasisTrial;
pub use sources::SourcesTrial;

use crate::{
    observer::Silent,
    vertices::{
        points::{BakePoint, BakePoints},
        sidedness::{Sidedness, classify},
        tessellate::{Stored, trace_seconds},
        visibility::{FINEST, USUAL, VisibilitySampler},
        z_order::z_order,
    },
};
use glam::Vec3;
use lapidary_core::{
    cut::{CutCriterion, CutSelector},
    light_tree::{Features, LightTree, PilotVisibility, TreeKind},
    mesh_surface::MeshSurface,
    offset,
    ray::{BoundaryTracer, Intersector},
    scene::{Mesh, Scene},
    sphere::fibonacci_directions,
    threads::{CoreClock, on_threads},
};

/// Lights of the trial, as in a draft.
const LIGHTS: usize = 8192;
/// Number of points at vertices of the scene, and of points spread over its surfaces.
const POINTS: usize = 128;
/// Most triangles of a tried scene: building a larger hierarchy takes many seconds and a gigabyte.
const MOST_TRIANGLES: usize = 1_000_000;
/// Adjacent points traced together.
const RUN: usize = 8;

/// Result of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Number of lights of the trial.
    pub lights: usize,
    /// Error bound of the trial's cuts.
    pub sigma: f32,
    /// Core seconds per point for following boundaries and selecting the cut.
    pub core_secs_per_point: f64,
    /// Mean nodes of a cut.
    pub mean_cut: f64,
    /// Core seconds per point at which tessellation tests whether to split.
    pub core_secs_per_split: f64,
}

impl Trial {
    /// Tries a scene as imported; `None` if none of it is visible, or if it is very large. It takes at most about a second on one
    /// thread.
    pub fn of(scene: &Scene) -> Option<Self> {
        tried(scene, Self::on_this_thread)
    }

    fn on_this_thread(scene: &Scene) -> Option<Self> {
        let sides = classify(scene);
        let intersector = Intersector::of_scene(scene);
        let [of_pilot, points] = some_points(&scene.mesh, &sides, &intersector);
        if points.is_empty() {
            return None;
        }
        let tree = tree(&intersector, &of_pilot)?;
        let criterion = CutCriterion::default();
        let sampler = VisibilitySampler::new(&intersector, &tree, USUAL);
        let (mut tracer, mut visible) = (BoundaryTracer::default(), vec![0; LIGHTS]);
        let mut selector = CutSelector::new(tree.height(), criterion);
        let length = |point: &BakePoint| {
            let mut cut = Vec::new();
            sampler.sample(point, &mut tracer, &mut visible);
            selector.select(&visible, &mut cut);
            cut.len()
        };
        let start = CoreClock::begin();
        let nodes: usize = points.iter().map(length).sum();
        let secs = start.secs();
        let stored = Stored { environment: true, bounces: false };
        let split_secs = trace_seconds(&intersector, stored, &points, &Silent).ok()?;
        let count = points.len() as f64;
        Some(Self {
            lights: LIGHTS,
            sigma: criterion.sigma,
            core_secs_per_point: secs / count,
            mean_cut: nodes as f64 / count,
            core_secs_per_split: split_secs / count,
        })
    }
}

/// A scene for trials of the parts that bounce light.
struct Tried<'a> {
    scene: &'a Scene,
    sides: &'a Sidedness,
    intersector: &'a Intersector,
    surface: &'a MeshSurface<'a>,
    viewpoint: Vec3,
}

/// Runs a trial on one thread, unless the scene is too large.
fn tried<T: Send>(scene: &Scene, on_this_thread: fn(&Scene) -> Option<T>) -> Option<T> {
    let is_small = scene.mesh.triangles.len() <= MOST_TRIANGLES;
    is_small.then(|| on_threads(1, || on_this_thread(scene))).flatten()
}

/// A bake's tree with a pilot at each of the points.
fn tree(intersector: &Intersector, points: &[BakePoint]) -> Option<LightTree> {
    let directions = fibonacci_directions(LIGHTS);
    let sampler = VisibilitySampler::of_directions(intersector, &directions, FINEST);
    let mut fractions = vec![0; LIGHTS * points.len()];
    let mut tracer = BoundaryTracer::default();
    for (point, visible) in points.iter().zip(fractions.chunks_mut(LIGHTS)) {
        sampler.sample(point, &mut tracer, visible);
    }
    let pilot = PilotVisibility { lights: LIGHTS, fractions };
    LightTree::build(&Features::of_kind(TreeKind::Mixed, 0.5, &directions, &pilot)).ok()
}

/// Vertices of the scene, and points spread over its surfaces as tessellation does: one set for the pilot and one for measuring. A
/// tree fits its own pilot better than other points.
fn some_points(mesh: &Mesh, sides: &Sidedness, intersector: &Intersector) -> [Vec<BakePoint>; 2] {
    let black = |_: &_| Vec3::ZERO;
    let surface = MeshSurface::new(mesh, intersector, &sides.two_sided, &black);
    let lift = offset::TRANSPORT * mesh.bounds().diagonal();
    let of_area = surface.uniform_points(64 * POINTS, 1).0.into_iter().map(|surfel| {
        let two_sided = sides.two_sided[surfel.place.triangle as usize];
        BakePoint { two_sided, ..BakePoint::of_surfel(surfel, lift) }
    });
    let of_area: Vec<BakePoint> = of_area.collect();
    let [of_pilot, measured] = runs_of(&BakePoints::new(mesh, sides).points);
    let [of_pilot_too, measured_too] = runs_of(&of_area);
    [[of_pilot, of_pilot_too].concat(), [measured, measured_too].concat()]
}

/// Two sets of [`POINTS`] of the points, in runs of neighbors spread over all.
fn runs_of(points: &[BakePoint]) -> [Vec<BakePoint>; 2] {
    let order = z_order(points);
    let runs: Vec<&[u32]> = order.chunks(RUN).collect();
    let count = (POINTS / RUN).min(runs.len());
    [1, 3].map(|quarter| {
        let spread = (0..count).flat_map(|i| runs[(4 * i + quarter) * runs.len() / (4 * count)]);
        spread.map(|&point| points[point as usize]).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{cuboid, floor, scene_of};

    #[test]
    fn a_trial_tells_the_cuts_of_a_bake() {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.0, 0.6, 0.0), Vec3::splat(0.5)));
        let trial = Trial::of(&scene_of(&triangles)).unwrap();
        assert!(trial.core_secs_per_point > 0.0 && trial.core_secs_per_split > 0.0);
        // Convex pieces over a floor: few boundaries.
        assert!((4.0..60.0).contains(&trial.mean_cut), "{}", trial.mean_cut);
        assert_eq!(Trial::of(&scene_of(&[])), None);
    }
}
