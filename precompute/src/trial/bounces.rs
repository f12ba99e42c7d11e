//! The parts that bounce light, in small.

use super::{some_points, tried};
use crate::{
    bake::settings::Preset,
    errors::BakeError,
    mesh_surface::MeshSurface,
    meshless::{points::place_basis, transport::transport_operator},
    observer::Silent,
    sources::{
        order::order_sources,
        placement::place_sources,
        sampler::{SourceSampler, SourceScratch},
        viewpoint::find_viewpoint,
    },
    vertices::{
        points::{BakePoint, BakePoints},
        sidedness::classify,
        visibility::USUAL,
    },
};
use glam::Vec3;
use lapidary_core::{
    cut::{SourceCriterion, SourceCutSelector},
    dataset::{BakeSettings, MeshlessSettings},
    light_tree::TreeKind,
    ray::Intersector,
    scene::Scene,
    sources::Source,
    surfel::Surface,
    threads::CoreClock,
};

/// Sources of the trial.
const SOURCES: usize = 1024;
/// Levels and rays of its basis.
const BASIS: MeshlessSettings =
    MeshlessSettings { levels: 2, sender_levels: 2, coarse_radius: None, rays: 64, epsilon: 0.025 };

/// What a trial of the bounces found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BounceTrial {
    /// Sources that it holds for.
    pub sources: usize,
    /// Core seconds for each source of placing it.
    pub core_secs_per_source: f64,
    /// Core seconds for each point of following segments to the sources and selecting the cut.
    pub core_secs_per_point: f64,
    /// Mean nodes of a cut, and the error bound that it holds for.
    pub mean_cut: (f64, f32),
    /// Functions of the first two levels of the meshless basis.
    pub functions: usize,
    /// Core seconds for each ray by which a function gathers light.
    pub core_secs_per_gather_ray: f64,
}

impl BounceTrial {
    /// Of a scene as imported; `None` if light bounces nowhere in it, or if it is very large. It takes a second or two, by one
    /// thread.
    pub fn of(scene: &Scene) -> Option<Self> {
        tried(scene, |scene| Self::on_this_thread(scene).ok())
    }

    fn on_this_thread(scene: &Scene) -> Result<Self, BakeError> {
        let sides = classify(scene);
        let intersector = Intersector::of_scene(scene);
        let black = |_: &_| Vec3::ZERO;
        let surface = MeshSurface::new(&scene.mesh, &intersector, &sides.two_sided, &black);
        let viewpoint = find_viewpoint(&surface, None, &scene.cameras, &scene.lights)?;
        let start = CoreClock::begin();
        let sources = place_sources(&surface, viewpoint, SOURCES, &[], &Silent)?;
        let placing = start.secs();
        let settings = BakeSettings { tree: TreeKind::Geometric, ..Preset::Draft.settings() };
        let points = BakePoints::new(&scene.mesh, &sides);
        let sources = order_sources(sources, &points, &intersector, &surface, &settings, &Silent)?;
        let [_, points] = some_points(&scene.mesh, &sides, &intersector);
        let criterion = settings.indirect.criterion;
        let (secs, nodes) = traced(&points, &intersector, &sources, surface.offset(), criterion);
        let (basis, _) = place_basis(&surface, viewpoint, &BASIS, &Silent)?;
        let start = CoreClock::begin();
        let (_, report) = transport_operator(&surface, &basis, &BASIS, &Silent)?;
        let gathering = start.secs();
        let count = points.len().max(1) as f64;
        Ok(Self {
            sources: SOURCES,
            core_secs_per_source: placing / SOURCES as f64,
            core_secs_per_point: secs / count,
            mean_cut: (nodes as f64 / count, criterion.sigma),
            functions: basis.len(),
            core_secs_per_gather_ray: gathering / report.rays_traced.max(1) as f64,
        })
    }
}

/// Seconds in which the cuts of points over sources are made, and the number of their nodes.
fn traced(
    points: &[BakePoint],
    intersector: &Intersector,
    sources: &[Source],
    offset: f32,
    criterion: SourceCriterion,
) -> (f64, usize) {
    let sampler = SourceSampler::new(intersector, sources, offset, USUAL);
    let (mut scratch, mut seen) = (SourceScratch::default(), vec![0.0; sources.len()]);
    let mut selector = SourceCutSelector::new(sources.len().ilog2(), criterion);
    let length = |point: &BakePoint| {
        let mut cut = Vec::new();
        sampler.sample(point, &mut scratch, &mut seen);
        selector.select(&seen, &mut cut);
        cut.len()
    };
    let start = CoreClock::begin();
    let nodes = points.iter().map(length).sum();
    (start.secs(), nodes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{cuboid, room, scene_of};

    #[test]
    fn a_trial_tells_of_all_parts_that_bounce_light() {
        let mut triangles = room(Vec3::ZERO, Vec3::splat(2.0)).to_vec();
        triangles.extend(cuboid(Vec3::new(1.0, 0.3, 1.2), Vec3::splat(0.25)));
        let trial = BounceTrial::of(&scene_of(&triangles)).unwrap();
        let BounceTrial { core_secs_per_source, core_secs_per_point, core_secs_per_gather_ray, .. } = trial;
        assert!([core_secs_per_source, core_secs_per_point, core_secs_per_gather_ray].iter().all(|secs| *secs > 0.0));
        assert!((10.0..1024.0).contains(&trial.mean_cut.0) && (500..5000).contains(&trial.functions), "{trial:?}");
        assert_eq!(BounceTrial::of(&scene_of(&[])), None);
    }
}
