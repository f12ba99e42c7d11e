//! Trials of the parts that bounce light.

use super::{Tried, meshless::BasisTrial, sources::SourcesTrial, tried};
use crate::{errors::BakeError, sources::viewpoint::find_viewpoint, vertices::sidedness::classify};
use glam::Vec3;
use lapidary_core::{mesh_surface::MeshSurface, ray::Intersector, scene::Scene};

/// Result of a trial of the bounces, by part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BounceTrial {
    /// Trial of the surface sources.
    pub sources: SourcesTrial,
    /// Trial of the meshless basis.
    pub basis: BasisTrial,
}

impl BounceTrial {
    /// Tries a scene as imported; `None` if no light bounces in it, or if it is very large. It takes one or two seconds on one
    /// thread.
    pub fn of(scene: &Scene) -> Option<Self> {
        tried(scene, |scene| Self::on_this_thread(scene).ok())
    }

    fn on_this_thread(scene: &Scene) -> Result<Self, BakeError> {
        let (sides, intersector) = (classify(scene), Intersector::of_scene(scene));
        let black = |_: &_| Vec3::ZERO;
        let surface = MeshSurface::new(&scene.mesh, &intersector, &sides.two_sided, &black);
        let viewpoint = find_viewpoint(&surface, None, &scene.cameras, &scene.lights)?;
        let tried = Tried { scene, sides: &sides, intersector: &intersector, surface: &surface, viewpoint };
        Ok(Self { sources: SourcesTrial::of(&tried)?, basis: BasisTrial::of(&tried)? })
    }
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
        let BounceTrial { sources, basis } = trial;
        let secs = [sources.core_secs_per_source, sources.core_secs_per_point, basis.core_secs_per_gather_ray];
        assert!(secs.iter().all(|secs| *secs > 0.0));
        assert!((10.0..1024.0).contains(&sources.mean_cut.0) && (500..5000).contains(&basis.functions), "{trial:?}");
        assert_eq!(BounceTrial::of(&scene_of(&[])), None);
    }
}
