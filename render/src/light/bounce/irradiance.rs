//! Irradiance of surface points: from local lights by shadow rays, from the environment by cuts.

use crate::{
    device::{GpuShadowRays, ShadowRay},
    light::environment::SceneLighting,
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    cut::{merge::merge, packed::PackedCursor},
    dataset::Dataset,
    lights::{Light, LightSample, LightSampler},
    offset,
    ray::{EightRays, Intersector},
    sources::Source,
    surfel::Surfel,
};
use rayon::prelude::*;
use std::array::from_fn;

/// What casts shadow rays, and how.
#[derive(Clone, Copy)]
pub struct ShadowRays<'a> {
    /// The scene.
    pub intersector: &'a Intersector,
    /// The scene on a device, which traces the rays.
    pub device: Option<&'a GpuShadowRays>,
    /// Samples along each side of an area light; averages over neighboring points reduce their error.
    pub area_samples: u32,
    /// Distance in meters of ray origins from the surface.
    pub offset: f32,
}

/// Surface points, their normals, and an order in which neighbors are close together, so that their rays enter the same boxes.
pub struct ReceivingPoints<'a> {
    pub points: &'a [Surfel],
    pub normals: &'a [Vec3],
    pub order: &'a [u32],
}

/// Irradiance of each point from `lights`.
pub fn light_irradiance(at: &ReceivingPoints, lights: &[Light], rays: ShadowRays) -> Vec<Vec3> {
    let lights = SampledLights::new(lights, rays.area_samples);
    let by_device = rays.device.and_then(|device| lights.irradiance_on(device, at, rays.offset));
    let eights = by_device.unwrap_or_else(|| lights.irradiance(rays.intersector, at, rays.offset));
    let mut irradiance = vec![Vec3::ZERO; at.points.len()];
    at.order.iter().zip(eights.as_flattened()).for_each(|(&i, &received)| irradiance[i as usize] = received);
    irradiance
}

/// Lights with the samples of each.
struct SampledLights<'a>(Vec<(LightSampler<'a>, Vec<Vec2>)>);

impl<'a> SampledLights<'a> {
    fn new(lights: &'a [Light], area_samples: u32) -> Self {
        Self(lights.iter().map(|light| (light.sampler(), pattern(light, area_samples))).collect())
    }

    /// Samples of all lights.
    fn samples(&self) -> usize {
        self.0.iter().map(|(_, pattern)| pattern.len()).sum()
    }

    /// Irradiance of points, eight at a time.
    fn irradiance(&self, scene: &Intersector, at: &ReceivingPoints, offset: f32) -> Vec<[Vec3; 8]> {
        let of_eight = |eight: &[u32]| {
            let points = at.eight(eight);
            self.sum(self.sent(&points, offset).map(|sent| (sent.received, sent.passed(scene))))
        };
        at.order.par_chunks(8).with_min_len(8).map(of_eight).collect()
    }

    /// The same with rays on a device; `None` if it fails.
    fn irradiance_on(&self, device: &GpuShadowRays, at: &ReceivingPoints, offset: f32) -> Option<Vec<[Vec3; 8]>> {
        let samples = self.samples();
        let at_a_time = (GpuShadowRays::AT_A_TIME / (8 * samples).max(1)).max(1);
        let mut irradiance = Vec::with_capacity(at.order.len().div_ceil(8));
        for some in at.order.chunks(8 * at_a_time) {
            let sent: Vec<Vec<EightSent>> =
                some.par_chunks(8).with_min_len(8).map(|eight| self.sent(&at.eight(eight), offset).collect()).collect();
            let rays: Vec<ShadowRay> = sent.iter().flatten().flat_map(EightSent::rays).collect();
            let open = device.open(&rays)?;
            let of_eight = |(eight, sent): (usize, &Vec<EightSent>)| {
                let passed = open[eight * samples..].iter().map(|open| from_fn(|lane| f32::from(open >> lane & 1)));
                self.sum(sent.iter().map(|sent| sent.received).zip(passed))
            };
            irradiance.par_extend(sent.par_iter().enumerate().with_min_len(8).map(of_eight));
        }
        Some(irradiance)
    }

    /// What is sent to up to eight points with their normals, light by light and sample by sample.
    fn sent(&self, points: &[(&Surfel, Vec3)], offset: f32) -> impl Iterator<Item = EightSent> {
        let samples = self.0.iter().flat_map(|(light, pattern)| pattern.iter().map(move |&u| (light, u)));
        samples.map(move |(light, u)| EightSent::new(points, light, u, offset))
    }

    /// Irradiance of eight points from what each sample sends, and the share of it that passes.
    fn sum(&self, mut samples: impl Iterator<Item = ([Vec3; 8], [f32; 8])>) -> [Vec3; 8] {
        let mut sums = [Vec3::ZERO; 8];
        for (_, pattern) in &self.0 {
            let mut of_light = [Vec3::ZERO; 8];
            for (received, passed) in samples.by_ref().take(pattern.len()) {
                of_light.iter_mut().enumerate().for_each(|(i, sum)| *sum += received[i] * passed[i]);
            }
            sums.iter_mut().zip(of_light).for_each(|(sum, of_light)| *sum += of_light / pattern.len() as f32);
        }
        sums
    }
}

impl ReceivingPoints<'_> {
    fn eight(&self, which: &[u32]) -> Vec<(&Surfel, Vec3)> {
        which.iter().map(|&i| (&self.points[i as usize], self.normals[i as usize])).collect()
    }
}

fn pattern(light: &Light, area_samples: u32) -> Vec<Vec2> {
    let side = if light.is_delta() { 1 } else { area_samples };
    // Centers of equal parts, moved apart so that they have the variance of the whole side.
    let apart = 1.0 / (1.0 - 1.0 / (side * side).max(2) as f32).sqrt();
    let middle = |i: u32| 0.5 + ((i as f32 + 0.5) / side as f32 - 0.5) * apart;
    (0..side * side).map(|i| Vec2::new(middle(i % side), middle(i / side))).collect()
}

/// Light of one sample at up to eight points, unless something stops it.
struct EightSent {
    origins: [Vec3; 8],
    directions: [Vec3; 8],
    /// Distances in meters before which something stops it; 0 where nothing is received.
    reaches: [f32; 8],
    received: [Vec3; 8],
}

impl EightSent {
    fn new(points: &[(&Surfel, Vec3)], light: &LightSampler, u: Vec2, offset: f32) -> Self {
        let sent: [Option<(Vec3, LightSample, Vec3)>; 8] = from_fn(|i| {
            let (point, normal) = points.get(i)?;
            let sample = light.sample(point.position, u)?;
            let received = sample.irradiance * normal.dot(sample.direction).max(0.0);
            (received.max_element() > 0.0).then_some((point.position + point.normal * offset, sample, received))
        });
        Self {
            origins: sent.map(|sent| sent.map_or(Vec3::ZERO, |(origin, ..)| origin)),
            directions: sent.map(|sent| sent.map_or(Vec3::Y, |(_, sample, _)| sample.direction)),
            // A light may lie on a surface, which does not block it.
            reaches: sent.map(|sent| sent.map_or(0.0, |(_, sample, _)| offset::REACH_OF_BOUNCE * sample.distance)),
            received: sent.map(|sent| sent.map_or(Vec3::ZERO, |(.., received)| received)),
        }
    }

    /// The share of each that passes.
    fn passed(&self, scene: &Intersector) -> [f32; 8] {
        let active = (0..8).map(|i| u8::from(self.received[i] != Vec3::ZERO) << i).sum();
        scene.passed_before(&EightRays::new(self.origins, self.directions, active), self.reaches)
    }

    fn rays(&self) -> [ShadowRay; 8] {
        from_fn(|i| ShadowRay { origin: self.origins[i], direction: self.directions[i], reach: self.reaches[i] })
    }
}

/// Irradiance of each source from the environment: its cut merged with the illumination cut, times the cosine. `None`
/// if sources have no cuts over the environment.
pub fn environment_irradiance(dataset: &Dataset, lighting: &SceneLighting) -> Option<Vec<Vec3>> {
    let (bake, mesh) = (dataset.indirect.as_ref()?, &dataset.scene.mesh);
    if bake.environment_cuts.len() != bake.sources.len() {
        return None;
    }
    let of_source = |(i, source): (usize, &Source)| {
        let visible = [(1.0, bake.environment_cuts.nodes_from(i as u32))];
        received(&visible, mesh.shading_normal(&source.surfel), lighting)
    };
    Some(bake.sources.par_iter().enumerate().with_min_len(64).map(of_source).collect())
}

/// Irradiance of points of a dataset's mesh from the environment, by interpolated cuts of the vertices.
pub fn environment_irradiance_of(points: &[Surfel], dataset: &Dataset, lighting: &SceneLighting) -> Vec<Vec3> {
    let of_point = |point: &Surfel| {
        let mesh = &dataset.scene.mesh;
        let vertices = mesh.triangles[point.place.triangle as usize];
        let weights = dataset.interpolation_weights(vertices, point.place.barycentric);
        let visible: [_; 3] = from_fn(|i| (weights[i], dataset.cuts.nodes_from(vertices[i])));
        received(&visible, mesh.shading_normal(point), lighting)
    };
    points.par_iter().with_min_len(64).map(of_point).collect()
}

/// Irradiance under a weighted sum of visibility cuts.
fn received<const N: usize>(visible: &[(f32, &[u16]); N], normal: Vec3, lighting: &SceneLighting) -> Vec3 {
    let height = lighting.height();
    let mut cursors: Vec<_> = visible.iter().map(|(_, nodes)| PackedCursor::new(height, nodes)).collect();
    cursors.push(PackedCursor::new(height, &lighting.cut));
    let mut sum = Vec3::ZERO;
    merge(1 << height, &mut cursors, |interval, cursors| {
        let visibility: f32 = visible.iter().zip(cursors).map(|((weight, _), cursor)| weight * cursor.value()).sum();
        if visibility > 0.0 {
            let node = interval.heap_index(1 << height) as usize;
            let cos = lighting.nodes.place[node].dot(normal).max(0.0);
            sum += lighting.nodes.radiance[node] * (cos * visibility * interval.size() as f32);
        }
    });
    sum * lighting.lights.leaf_solid_angle
}
