//! Whether a light lights anything that a camera sees, and whether a picture shows any light.

use crate::{Background, Baked, Illumination, Look, View};
use glam::{Quat, Vec2, Vec3};
use lapidary_core::{
    camera::Projection,
    dataset::Dataset,
    lights::{Emission, Light},
    material::Material,
    ray::Intersector,
    sphere::fibonacci_directions,
};
use std::f32::consts::FRAC_PI_2;

/// Test rays along each side of the picture.
const RAYS: u32 = 12;
/// Points of the light by which it is tested.
const POINTS: [Vec2; 5] =
    [Vec2::splat(0.5), Vec2::new(0.1, 0.1), Vec2::new(0.9, 0.1), Vec2::new(0.1, 0.9), Vec2::new(0.9, 0.9)];
/// Test directions toward the sky.
const SKY: usize = 32;
/// Test rays from a light.
const FROM_LIGHT: usize = 512;
/// Offset from a surface, as a share of its distance from the eye.
const OFF_SURFACE: f32 = 1e-4;

/// A surface that the camera sees.
struct SeenSurface {
    triangle: usize,
    /// A place just before it, in meters.
    point: Vec3,
    /// Its unit normal toward the eye.
    normal: Vec3,
}

/// What the camera sees on a grid of the picture. Backs of one-sided surfaces are black, and left out.
struct Seen {
    surfaces: Vec<SeenSurface>,
    /// Whether a ray meets nothing.
    background: bool,
}

impl Seen {
    fn of(dataset: &Dataset, intersector: &Intersector, view: &View) -> Self {
        let projection = view.projection();
        let size = Vec2::new(view.size[0] as f32, view.size[1] as f32);
        let mut seen = Self { surfaces: Vec::new(), background: false };
        for ray in 0..RAYS * RAYS {
            let share = Vec2::new((ray % RAYS) as f32 + 0.5, (ray / RAYS) as f32 + 0.5) / RAYS as f32;
            let (origin, direction) = projection.ray(share * size);
            let Some(hit) = intersector.closest_hit(origin, direction) else {
                seen.background = true;
                continue;
            };
            if hit.back_face && !dataset.two_sided[hit.triangle as usize] {
                continue;
            }
            let normal = dataset.scene.mesh.area_vector(hit.triangle as usize).normalize_or_zero();
            let normal = normal * -normal.dot(direction).signum();
            let point = origin + direction * hit.distance + normal * (OFF_SURFACE * hit.distance);
            seen.surfaces.push(SeenSurface { triangle: hit.triangle as usize, point, normal });
        }
        seen
    }

    fn is_lit_by(&self, intersector: &Intersector, light: &Light) -> bool {
        let sampler = light.sampler();
        self.surfaces.iter().any(|&SeenSurface { point, normal, .. }| {
            POINTS.iter().any(|&u| {
                let Some(sample) = sampler.sample(point, u) else { return false };
                let is_before = sample.direction.dot(normal) > 0.0;
                is_before && !intersector.occluded_before(point, sample.direction, sample.distance)
            })
        })
    }

    fn sees_the_sky(&self, intersector: &Intersector) -> bool {
        let directions = fibonacci_directions(SKY);
        self.surfaces.iter().any(|&SeenSurface { point, normal, .. }| {
            directions.iter().any(|&direction| direction.dot(normal) > 0.0 && !intersector.occluded(point, direction))
        })
    }
}

/// Whether some light of `light` arrives at a surface in a view; `intersector` is built from the dataset's mesh. Views of the
/// background alone count as lit.
pub fn lights_view(dataset: &Dataset, intersector: &Intersector, light: &Light, view: &View) -> bool {
    let seen = Seen::of(dataset, intersector, view);
    let size = Vec2::new(view.size[0] as f32, view.size[1] as f32);
    let is_lit =
        || seen.is_lit_by(intersector, light) || sees_light_on_a_surface(intersector, light, &view.projection(), size);
    if seen.surfaces.is_empty() { seen.background } else { is_lit() }
}

/// Whether a picture of a look shows any light: a background, or a surface that the environment or a lamp reaches, or one that shines.
/// Without, as behind a wall, it is black.
pub fn shows_light(baked: &Baked, look: &Look) -> bool {
    let (dataset, intersector) = (&baked.dataset, baked.intersector());
    let seen = Seen::of(dataset, intersector, &look.view);
    let Illumination { environment, intensity, .. } = &look.illumination;
    let shines_above = *intensity > 0.0 && environment.map.pixels.iter().any(|pixel| pixel.max_element() > 0.0);
    let has_sky = look.components.environment && shines_above;
    let is_behind = match look.view.background {
        Background::Environment | Background::Blurred(_) => has_sky,
        Background::Flat(color) => color != Vec3::ZERO,
        Background::Transparent => true,
    };
    let lamps = || look.components.direct && look.lights.iter().any(|light| seen.is_lit_by(intersector, light));
    let material = |triangle: usize| {
        let own = dataset.scene.mesh.triangle_material[triangle];
        let index = look.appearance.assigned.as_ref().map_or(own, |assigned| assigned[triangle]);
        look.appearance.materials.get(index as usize)
    };
    let is_bright = |surface: &SeenSurface| material(surface.triangle).is_some_and(Material::shines);
    let shines = || look.components.direct && seen.surfaces.iter().any(is_bright);
    seen.background && is_behind || has_sky && seen.sees_the_sky(intersector) || lamps() || shines()
}

/// Whether a ray of the light meets a surface that the camera sees: the pool of a narrow lamp may lie between all rays of the camera.
fn sees_light_on_a_surface(intersector: &Intersector, light: &Light, projection: &Projection, size: Vec2) -> bool {
    let Some(rays) = rays_of(light) else { return false };
    rays.into_iter().any(|direction| {
        let Some(hit) = intersector.closest_hit(light.position, direction) else { return false };
        let point = light.position + direction * hit.distance * (1.0 - OFF_SURFACE);
        let seen = projection.pixel_of(point).map(|(pixel, _)| pixel);
        seen.is_some_and(|pixel| pixel.cmpge(Vec2::ZERO).all() && pixel.cmplt(size).all())
            && !intersector.occluded_between(projection.eye, point)
    })
}

/// Directions in which a light shines; `None` for parallel light and while it is off.
fn rays_of(light: &Light) -> Option<Vec<Vec3>> {
    let most = match light.emission {
        _ if !light.shines() => return None,
        Emission::Directional { .. } => return None,
        Emission::Point => return Some(fibonacci_directions(FROM_LIGHT)),
        Emission::Spot { cone_degrees, .. } => cone_degrees.to_radians(),
        Emission::Rectangle { .. } => FRAC_PI_2,
    };
    let around = Quat::from_rotation_arc(Vec3::Z, light.forward()?);
    // Equal solid angles of the cone, along a spiral.
    let ray = |i: usize| {
        let cos = 1.0 - (1.0 - most.cos()) * (i as f32 + 0.5) / FROM_LIGHT as f32;
        let flat = Vec2::from_angle(i as f32 * GOLDEN_ANGLE) * (1.0 - cos * cos).max(0.0).sqrt();
        around * flat.extend(cos)
    };
    Some((0..FROM_LIGHT).map(ray).collect())
}

/// Turn from a point of a spiral to the next, in radians.
const GOLDEN_ANGLE: f32 = 2.399_963_2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{dataset, from_above, light, mesh, white};

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
        let narrow = Emission::Spot { cone_degrees: 0.4, penumbra_degrees: 0.1 };
        let pool = Light {
            position: Vec3::new(0.33, 3.0, 1.21),
            target: Vec3::new(0.33, 0.0, 1.21),
            ..at(narrow, 3.0, Vec3::ZERO)
        };
        assert!(lit(pool), "a pool between the rays of the camera");
        assert!(!lit(Light { enabled: false, ..at(Emission::Point, 3.0, Vec3::ZERO) }));
    }
}
