//! Lights without extent, from the brightest at a point to the faintest. Shadow rays stop once the remaining lights, even
//! unblocked, could not change the sum.

use crate::shade::surface::SurfacePoint;
use glam::Vec3;
use lapidary_core::{
    lights::{LightSample, LightSampler},
    simd::Vec3x8,
};
use wide::f32x8;

/// Largest neglected share of the light from lights without extent, in each channel.
pub(crate) const NEGLIGIBLE: f32 = 1e-4;

/// Unoccluded light of one lamp, reflected toward the eye.
struct Unshadowed {
    /// Index among all lights.
    number: usize,
    radiance: Vec3,
    direction: Vec3,
    distance: f32,
    /// Radiance of this and all fainter lights.
    with_fainter: Vec3,
}

/// Radiance that a point reflects of `lights`, within [`NEGLIGIBLE`]. `arriving` returns the share of the light that arrives, by
/// index, direction and distance.
pub(super) fn delta_light<'a>(
    point: &SurfacePoint,
    lights: impl Iterator<Item = (usize, &'a LightSampler<'a>)>,
    mut arriving: impl FnMut(usize, Vec3, f32) -> f32,
) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for light in from_brightest(unshadowed(point, lights)).iter() {
        if light.with_fainter.cmple(NEGLIGIBLE * sum).all() {
            break;
        }
        sum += light.radiance * arriving(light.number, light.direction, light.distance);
    }
    sum
}

fn unshadowed<'a>(
    point: &SurfacePoint,
    lights: impl Iterator<Item = (usize, &'a LightSampler<'a>)>,
) -> Vec<Unshadowed> {
    let samples = lights.filter_map(|(i, light)| Some((i, light.sample(point.ray_origin, Default::default())?)));
    let samples: Vec<(usize, LightSample)> = samples.filter(|(_, s)| point.receives(s.direction)).collect();
    let local_from_world = point.world_from_local.transpose();
    let mut out = Vec::with_capacity(samples.len());
    for eight in samples.chunks(8) {
        let wi = |i: usize| eight.get(i).map_or(Vec3::Z, |(_, s)| local_from_world * s.direction);
        let wi = Vec3x8::from_array(std::array::from_fn(wi));
        let reflected = point.reflect(wi, f32x8::ZERO);
        out.extend(eight.iter().enumerate().map(|(i, &(number, s))| Unshadowed {
            number,
            radiance: reflected.lane(i) * s.irradiance,
            direction: s.direction,
            distance: s.distance,
            with_fainter: Vec3::ZERO,
        }));
    }
    out
}

/// Sorts the lights and drops dark ones. Sums start at the faintest, so rounding loses none of them.
fn from_brightest(mut lights: Vec<Unshadowed>) -> Vec<Unshadowed> {
    lights.retain(|light| light.radiance.max_element() > 0.0);
    lights.sort_unstable_by(|a, b| b.radiance.element_sum().total_cmp(&a.radiance.element_sum()));
    let mut sum = Vec3::ZERO;
    for light in lights.iter_mut().rev() {
        sum += light.radiance;
        light.with_fainter = sum;
    }
    lights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Renderer,
        shade::direct::arriving_share,
        test_scenes::{dataset, from_above, light, plates, surface_at, white},
    };
    use lapidary_core::{
        camera::Camera,
        lights::{Emission, Light},
    };

    /// Lamps above and below the plates, with very different brightness.
    fn lamps(count: usize, spread: i32) -> Vec<Light> {
        let mut random = fastrand::Rng::with_seed(5);
        let mut lamp = || {
            let position = Vec3::new(2.0 * random.f32(), 3.0 * random.f32() - 0.5, 2.0 * random.f32() - 1.0);
            let mut lamp = light(Emission::Point, position, Vec3::ZERO, 2.0_f32.powi(-random.i32(0..=spread)));
            lamp.intensity *= Vec3::new(1.0, random.f32(), random.f32());
            lamp
        };
        (0..count).map(|_| lamp()).collect()
    }

    /// Radiance and number of rays.
    fn counted(renderer: &Renderer, point: &SurfacePoint, lights: &[Light]) -> (Vec3, usize) {
        let mut rays = 0;
        let samplers: Vec<LightSampler> = lights.iter().map(Light::sampler).collect();
        let sum = delta_light(point, samplers.iter().enumerate(), |_, direction, distance| {
            rays += 1;
            arriving_share(renderer.intersector(), point, direction, distance)
        });
        (sum, rays)
    }

    #[test]
    fn what_is_left_out_is_below_the_bound_and_saves_rays() {
        let renderer = Renderer::new(dataset(plates(), white()));
        let mut view = from_above(8);
        view.camera = Camera::look_at(Vec3::new(1.8, 1.5, 0.9), Vec3::new(0.5, 0.1, 0.0), 40.0);
        let point = surface_at(&renderer, &view);
        for (count, spread) in [(1, 0), (3, 2), (40, 30), (2000, 40)] {
            let lamps = lamps(count, spread);
            let (sum, rays) = counted(&renderer, &point, &lamps);
            let all: Vec3 = lamps.chunks(1).map(|lamp| counted(&renderer, &point, lamp).0).sum();
            let lost = all - sum;
            // Sums of thousands in another order differ by rounding.
            assert!(lost.cmple(1.05 * NEGLIGIBLE * all + 1e-9).all(), "{count}: {lost} of {all}");
            assert!(all.x > 0.0 && (count < 40 || rays < count / 2), "{count}: {rays} rays");
        }
    }

    #[test]
    fn equal_lights_all_cast_rays_and_hidden_ones_do_not_end_the_search() {
        let renderer = Renderer::new(dataset(plates(), white()));
        let mut view = from_above(8);
        view.camera = Camera::look_at(Vec3::new(1.0, 6.0, 0.01), Vec3::X, 30.0);
        let point = surface_at(&renderer, &view);
        let equal: Vec<Light> = (0..500)
            .map(|i| {
                light(Emission::Point, point.position + Vec3::new(1e-3 * (i % 7) as f32, 1.0, 0.0), Vec3::ZERO, 1.0)
            })
            .collect();
        assert_eq!(counted(&renderer, &point, &equal).1, 500, "no light is negligible");
        // The brightest light is behind the wall beyond the floor's edge; the faint one is visible.
        let behind = light(Emission::Point, Vec3::new(-0.5, 0.3, 0.0), Vec3::ZERO, 1e6);
        let faint = light(Emission::Point, point.position + Vec3::Y, Vec3::ZERO, 1e-3);
        let both = [behind, faint.clone()];
        let (sum, rays) = counted(&renderer, &point, &both);
        let alone = counted(&renderer, &point, &[faint]).0;
        assert!(rays == 2 && sum == alone && alone.x > 0.0, "{rays} rays, {sum} for {alone}");
    }
}
