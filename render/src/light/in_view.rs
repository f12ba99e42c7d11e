//! Whether a light lights anything that a camera sees.

use crate::View;
use glam::Vec2;
use lapidary_core::{dataset::Dataset, lights::Light, ray::Intersector};

/// Test rays along each side of the picture.
const RAYS: u32 = 12;
/// Points of the light by which it is tested.
const POINTS: [Vec2; 5] =
    [Vec2::splat(0.5), Vec2::new(0.1, 0.1), Vec2::new(0.9, 0.1), Vec2::new(0.1, 0.9), Vec2::new(0.9, 0.9)];
/// Offset from a surface, as a share of its distance from the eye.
const OFF_SURFACE: f32 = 1e-4;

/// Whether some light of `light` arrives at a surface in a view; `intersector` is built from the dataset's mesh. Views of the
/// background alone count as lit.
pub fn lights_view(dataset: &Dataset, intersector: &Intersector, light: &Light, view: &View) -> bool {
    let projection = view.projection();
    let size = Vec2::new(view.size[0] as f32, view.size[1] as f32);
    let mesh = &dataset.scene.mesh;
    let sampler = light.sampler();
    let mut has_surface = false;
    for ray in 0..RAYS * RAYS {
        let share = Vec2::new((ray % RAYS) as f32 + 0.5, (ray / RAYS) as f32 + 0.5) / RAYS as f32;
        let (origin, direction) = projection.ray(share * size);
        let Some(hit) = intersector.closest_hit(origin, direction) else { continue };
        let normal = mesh.area_vector(hit.triangle as usize).normalize_or_zero();
        let normal = normal * -normal.dot(direction).signum();
        let point = origin + direction * hit.distance + normal * (OFF_SURFACE * hit.distance);
        has_surface = true;
        let arrives = |u: &Vec2| {
            let Some(sample) = sampler.sample(point, *u) else { return false };
            let is_before = sample.direction.dot(normal) > 0.0;
            is_before && !intersector.occluded_before(point, sample.direction, sample.distance)
        };
        if POINTS.iter().any(arrives) {
            return true;
        }
    }
    !has_surface
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{dataset, from_above, light, mesh, white};
    use glam::Vec3;
    use lapidary_core::lights::Emission;

    #[test]
    fn a_light_under_the_floor_or_aimed_away_lights_nothing_in_view() {
        let mesh = mesh(4, true);
        let (dataset, intersector) = (dataset(mesh.clone(), white()), Intersector::new(&mesh));
        let lit = |light: Light| lights_view(&dataset, &intersector, &light, &from_above(48));
        let at = |emission, y: f32, target: Vec3| light(emission, Vec3::new(0.2, y, 0.1), target, 3.0);
        let spot = Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 };
        let panel = Emission::Rectangle { width: 0.3, height: 0.3 };
        for emission in [Emission::Point, spot, panel, Emission::PARALLEL] {
            assert!(lit(at(emission, 3.0, Vec3::ZERO)), "negative control: {emission:?}");
            assert!(!lit(at(emission, -1.0, Vec3::ZERO)), "under the floor: {emission:?}");
        }
        for emission in [spot, panel] {
            assert!(!lit(at(emission, 3.0, Vec3::new(0.2, 9.0, 0.1))), "aimed at the sky: {emission:?}");
        }
        assert!(!lit(Light { enabled: false, ..at(Emission::Point, 3.0, Vec3::ZERO) }));
    }
}
