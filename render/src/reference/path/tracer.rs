//! One light path from the eye: direct light at each vertex, then a reflection by the BRDF.

use super::{
    emitters::Emitters, environment_sampling::EnvironmentDistribution, light_choice::LightChoice,
    settings::PathSettings,
};
use crate::{
    light::{components::Components, environment::Illumination},
    renderer::Renderer,
    shade::{
        background::Sky,
        direct::arriving_share,
        mirror::rays::RayLobes,
        mirrors,
        seen_scene::SeenScene,
        surface::{FirstHit, SurfacePoint, Surfaces},
    },
};
use glam::{Vec2, Vec3};
use lapidary_core::{lights::Light, opacity::chance};

/// From this bounce on, Russian roulette ends paths of low throughput and gives the others more weight (Arvo and Kirk 1990).
const SAFE_BOUNCES: u32 = 3;

/// Highest survival probability, so that a path between white walls ends.
const MOST_LIKELY: f32 = 0.95;

/// Estimates of reflected radiance.
pub struct Tracer<'a> {
    renderer: &'a Renderer,
    surfaces: Surfaces<'a>,
    sky: Sky<'a>,
    environment: EnvironmentDistribution,
    lights: LightChoice<'a>,
    emitters: Emitters,
    settings: PathSettings,
    /// The scene that mirrors show after the last bounce, if they do.
    mirrored: Option<SeenScene<'a>>,
}

/// Shares of the kinds of direct light to gather at a vertex: one that is not wanted is left out of what mirrors show, too.
#[derive(Clone, Copy)]
struct Gathered {
    environment: f32,
    lights: f32,
}

impl Gathered {
    /// Of what is wanted, at a vertex of which mirrors alone show this share.
    fn of(wanted: Components, mirrored: f32) -> Self {
        let share = |is_wanted: bool| if is_wanted { 1.0 } else { 1.0 - mirrored };
        Self { environment: share(wanted.environment), lights: share(wanted.direct) }
    }
}

/// A reflection sampled from the BRDF.
struct Scattered {
    world: Vec3,
    /// Density of the direction per solid angle.
    pdf: f32,
    /// BRDF times cosine over the density.
    weight: Vec3,
}

impl<'a> Tracer<'a> {
    /// Paths of a picture whose mirrors show a scene, or none.
    pub fn new(
        renderer: &'a Renderer,
        light: &'a Illumination,
        lights: &'a [Light],
        settings: PathSettings,
        mirrored: Option<SeenScene<'a>>,
    ) -> Self {
        let radius = 0.5 * renderer.dataset().scene.mesh.bounds().diagonal();
        Self {
            renderer,
            surfaces: Surfaces::of(renderer),
            sky: Sky::new(light),
            environment: EnvironmentDistribution::new(&light.environment.map),
            lights: LightChoice::new(lights, radius),
            emitters: Emitters::new(&renderer.dataset().scene.mesh, &renderer.appearance),
            settings,
            mirrored,
        }
    }

    /// One estimate of the radiance from a point toward the eye. A ground that catches shadows reflects what stands on it, as in
    /// [`mirrors::Mirrors::over_ground`].
    pub fn radiance(&self, seen: &SurfacePoint, rng: &mut fastrand::Rng) -> Vec3 {
        let own = self.reflected(seen, 0, rng);
        let Some(ground) = seen.ground.as_deref() else { return own };
        let scattered = self.scatter(ground, rng);
        let shown = scattered.and_then(|scattered| {
            let weight = scattered.weight * self.mirrored_share(ground, scattered.world, 0);
            Some((weight, self.mirrored(ground, &scattered)?))
        });
        match shown {
            Some((weight, shown)) => own * (1.0 - weight.min(Vec3::ONE)) + weight * self.reflected(&shown, 1, rng),
            None => own,
        }
    }

    /// The same without the ground, of a point within a number of mirrors.
    fn reflected(&self, seen: &SurfacePoint, within: u32, rng: &mut fastrand::Rng) -> Vec3 {
        let wanted = self.settings.components;
        let mut bounces = if wanted.indirect { self.settings.bounces } else { 0 };
        let mirrors = if self.mirrored.is_some() { mirrors::DEEPEST - within } else { 0 };
        let last = bounces + mirrors;
        // Mirrors that may show a kind of light that is not wanted.
        let left_out = if wanted.direct && wanted.environment { 0 } else { mirrors };
        let mut mirrored = 1.0;
        let mut gathered = Gathered::of(wanted, mirrored);
        let (mut sum, mut throughput) = (seen.emission * gathered.lights, Vec3::ONE);
        let mut reflected: Box<SurfacePoint>;
        let mut point = seen;
        for bounce in 0..=last {
            sum += throughput * self.by_light(point, gathered, rng);
            let shown = |world: Vec3| {
                if bounce < left_out { mirrored * self.mirrored_share(point, world, within + bounce) } else { 0.0 }
            };
            if bounce < bounces {
                sum += throughput * self.by_emitters(point, rng, |world| Gathered::of(wanted, shown(world)).lights);
            }
            let Some(scattered) = self.scatter(point, rng) else { break };
            throughput *= scattered.weight;
            let next_mirrored = shown(scattered.world);
            let next_gathered = Gathered::of(wanted, next_mirrored);
            if gathered.lights > 0.0 {
                sum += throughput * self.rectangles(point, &scattered) * gathered.lights;
            }
            if bounce == bounces {
                if gathered.environment > 0.0 {
                    sum += throughput * self.environment_behind(point, &scattered) * gathered.environment;
                }
                if bounce == last {
                    break;
                }
                let share = self.mirrored_share(point, scattered.world, within + bounces + mirrors - last);
                let next = self.mirrored(point, &scattered).filter(|_| share > 0.0);
                let Some(next) = next else { break };
                throughput *= share;
                if wanted.indirect {
                    (gathered, mirrored) = (next_gathered, next_mirrored);
                }
                sum += throughput * next.emission * gathered.lights;
                (reflected, bounces) = (next, bounces + 1);
                point = &reflected;
                continue;
            }
            match self.surfaces.seen_along(point.ray_origin, scattered.world) {
                FirstHit::Surface(next) if leaves_face(point, scattered.world) => {
                    sum += throughput * self.emission_along(point, &scattered, &next) * next_gathered.lights;
                    reflected = next;
                }
                FirstHit::Background => {
                    if gathered.environment > 0.0 {
                        sum += throughput * self.environment_along(&scattered) * gathered.environment;
                    }
                    break;
                }
                _ => break,
            }
            if bounce >= SAFE_BOUNCES {
                let chance = throughput.max_element().min(MOST_LIKELY);
                if !(rng.f32() < chance) {
                    break;
                }
                throughput /= chance;
            }
            (gathered, mirrored) = (next_gathered, next_mirrored);
            point = &reflected;
        }
        sum
    }

    /// Share of the light of surfaces along a reflection that a mirror shows which is within so many others.
    fn mirrored_share(&self, point: &SurfacePoint, world: Vec3, mirrors: u32) -> f32 {
        let lobes = if mirrors == 0 { RayLobes::at } else { RayLobes::of_map };
        let lobes = lobes(point, self.renderer.dataset.tree.leaf_solid_angle());
        lobes.map_or(0.0, |lobes| lobes.share_of(point.world_from_local.transpose() * world))
    }

    /// The surface that a mirror shows along a reflection.
    fn mirrored(&self, point: &SurfacePoint, scattered: &Scattered) -> Option<Box<SurfacePoint>> {
        let [x, y] = [scattered.world.x, scattered.world.y].map(f32::to_bits);
        let by_chance = |triangle| chance(&[x, y, triangle]);
        match self.mirrored?.mirrored((point.ray_origin, scattered.world), by_chance) {
            FirstHit::Surface(next) if leaves_face(point, scattered.world) => Some(next),
            _ => None,
        }
    }

    /// Direct light by samples of the environment and of lights.
    fn by_light(&self, point: &SurfacePoint, gathered: Gathered, rng: &mut fastrand::Rng) -> Vec3 {
        let of = |share: f32, light: &mut dyn FnMut() -> Vec3| if share > 0.0 { light() * share } else { Vec3::ZERO };
        let environment = of(gathered.environment, &mut || self.by_environment(point, rng));
        environment + of(gathered.lights, &mut || self.by_local_lights(point, rng))
    }

    fn by_environment(&self, point: &SurfacePoint, rng: &mut fastrand::Rng) -> Vec3 {
        let Some((direction, pdf)) = self.environment.sample(rng.f32(), rng.f32()) else { return Vec3::ZERO };
        let world = self.sky.to_world(direction);
        let (reflected, other) = reflection(point, world);
        let value = reflected * self.sky.radiance(world);
        if value == Vec3::ZERO {
            return Vec3::ZERO;
        }
        value * self.renderer.intersector().transmittance(point.ray_origin, world) * (power_heuristic(pdf, other) / pdf)
    }

    fn by_local_lights(&self, point: &SurfacePoint, rng: &mut fastrand::Rng) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (light, probability) in self.lights.asked(rng.f32()) {
            let u = Vec2::new(rng.f32(), rng.f32());
            let Some(sample) = light.sample(point.ray_origin, u) else { continue };
            let (reflected, other) = reflection(point, sample.direction);
            let value = reflected * sample.irradiance;
            if value != Vec3::ZERO {
                let value = value * self.arriving_share(point, sample.direction, sample.distance);
                sum += value * (power_heuristic(probability * sample.pdf, other) / probability);
            }
        }
        sum
    }

    /// Light from emissive surfaces, by sampling them; `share` tells how much counts from a direction.
    fn by_emitters(&self, point: &SurfacePoint, rng: &mut fastrand::Rng, share: impl Fn(Vec3) -> f32) -> Vec3 {
        if self.emitters.is_empty() {
            return Vec3::ZERO;
        }
        let mesh = &self.renderer.dataset().scene.mesh;
        let u = Vec3::new(rng.f32(), rng.f32(), rng.f32());
        let Some(sample) = self.emitters.sample(&self.surfaces, mesh, point.ray_origin, u) else { return Vec3::ZERO };
        let (reflected, other) = reflection(point, sample.direction);
        let value = reflected * sample.radiance;
        if value == Vec3::ZERO {
            return Vec3::ZERO;
        }
        value
            * share(sample.direction)
            * self.arriving_share(point, sample.direction, sample.distance)
            * (power_heuristic(sample.pdf, other) / sample.pdf)
    }

    /// Emission of the surface that a reflection hits, weighted against samples of emitters.
    fn emission_along(&self, point: &SurfacePoint, scattered: &Scattered, next: &SurfacePoint) -> Vec3 {
        if next.emission == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let [a, b, c] = next.corners;
        let cosine = (b - a).cross(c - a).normalize_or_zero().dot(scattered.world);
        let distance = next.position.distance(point.ray_origin);
        next.emission * power_heuristic(scattered.pdf, self.emitters.pdf(next.material, distance, cosine))
    }

    /// A reflection by importance; `None` without a valid direction.
    fn scatter(&self, point: &SurfacePoint, rng: &mut fastrand::Rng) -> Option<Scattered> {
        let brdf = point.brdf.as_brdf();
        let wi = brdf.sample(point.wo, Vec3::new(rng.f32(), rng.f32(), rng.f32()));
        let pdf = brdf.pdf(wi, point.wo);
        let world = point.world_from_local * wi;
        if !(wi.z > 0.0 && pdf > 0.0 && point.receives(world)) {
            return None;
        }
        let weight = brdf.brdf_cos(wi, point.wo) / pdf;
        (weight.is_finite() && weight != Vec3::ZERO).then_some(Scattered { world, pdf, weight })
    }

    /// Radiance of the rectangular lights along a reflection, weighted against their samples.
    fn rectangles(&self, point: &SurfacePoint, scattered: &Scattered) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (light, probability) in self.lights.all() {
            let Some(hit) = light.intersect(point.ray_origin, scattered.world) else { continue };
            let share = self.arriving_share(point, scattered.world, hit.distance);
            if share > 0.0 {
                sum += share * hit.radiance * power_heuristic(scattered.pdf, probability * hit.pdf);
            }
        }
        sum
    }

    /// Radiance of the environment along a reflection, weighted against its samples, unless a surface blocks it.
    fn environment_behind(&self, point: &SurfacePoint, scattered: &Scattered) -> Vec3 {
        let radiance = self.environment_along(scattered);
        if radiance == Vec3::ZERO {
            return Vec3::ZERO;
        }
        radiance * self.renderer.intersector().transmittance(point.ray_origin, scattered.world)
    }

    fn arriving_share(&self, point: &SurfacePoint, direction: Vec3, distance: f32) -> f32 {
        arriving_share(self.renderer.intersector(), point, direction, distance)
    }

    fn environment_along(&self, scattered: &Scattered) -> Vec3 {
        let other = self.environment.pdf(self.sky.to_environment(scattered.world));
        self.sky.radiance(scattered.world) * power_heuristic(scattered.pdf, other)
    }
}

/// BRDF times cosine for light from a world direction, and the pdf of that direction in BRDF sampling.
fn reflection(point: &SurfacePoint, world: Vec3) -> (Vec3, f32) {
    let wi = point.world_from_local.transpose() * world;
    if !(wi.z > 0.0 && point.receives(world)) {
        return (Vec3::ZERO, 0.0);
    }
    let brdf = point.brdf.as_brdf();
    (brdf.brdf_cos(wi, point.wo), brdf.pdf(wi, point.wo))
}

/// Whether a direction leaves the visible side of the triangle; otherwise a ray would hit the triangle itself.
fn leaves_face(point: &SurfacePoint, world: Vec3) -> bool {
    let [a, b, c] = point.corners;
    let normal = (b - a).cross(c - a);
    normal.dot(world) * normal.dot(point.ray_origin - a) > 0.0
}

fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let (a, b) = (pdf * pdf, other * other);
    if a.is_infinite() { 1.0 } else { a / (a + b) }
}
