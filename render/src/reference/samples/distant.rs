//! Samples of the environment: one direction each.

use crate::{
    light::{environment::SceneLighting, mirrored_map::MirroredMap},
    renderer::Renderer,
    shade::{
        merge::SharpLight,
        mirror::Mirror,
        point_shader::PointShader,
        surface::{ReceiverX8, SurfacePoint},
    },
};
use glam::Vec3;
use lapidary_core::{
    light_tree::LightTree,
    ray::{DirectionSet, OPEN},
    simd::{Lanes, Vec3x8},
};
use wide::f32x8;

/// Light samples in tree order, padded to whole groups of eight.
pub(crate) struct LightSamples {
    directions: DirectionSet,
    wi: Vec<Vec3x8>,
    radiance: Vec<Vec3x8>,
    /// Directional spread of each sample, for sharp lobes.
    inv_kappa: Vec<f32x8>,
    mirrored: Option<MirroredMap>,
    solid_angle: f32,
}

impl LightSamples {
    /// Samples of a lit tree; its illumination cut does not matter.
    pub fn of(tree: &LightTree, lighting: &SceneLighting) -> Self {
        let leaf_radiance = &lighting.nodes.radiance[tree.len()..];
        let eight = |values: &[Vec3]| -> Vec<Vec3x8> {
            let lane = |chunk: &[Vec3], i: usize| chunk.get(i).copied().unwrap_or(Vec3::ZERO);
            values.chunks(8).map(|c| Vec3x8::from_array(std::array::from_fn(|i| lane(c, i)))).collect()
        };
        let spreads = lighting.nodes.spread[tree.len()..].chunks(8);
        let spread = |chunk: &[f32]| f32x8::new(std::array::from_fn(|i| chunk.get(i).copied().unwrap_or(0.0)));
        Self {
            directions: DirectionSet::new(tree.leaf_directions()),
            wi: eight(tree.leaf_directions()),
            radiance: eight(leaf_radiance),
            inv_kappa: spreads.map(spread).collect(),
            mirrored: lighting.lights.mirrored.clone(),
            solid_angle: tree.leaf_solid_angle(),
        }
    }

    pub fn shader<'a>(&'a self, renderer: &'a Renderer) -> DistantShader<'a> {
        DistantShader { samples: self, renderer, visible: vec![0; self.directions.len()], sharp: SharpLight::Map }
    }

    /// The map of the samples, if they have one.
    pub fn map(&self) -> Option<&MirroredMap> {
        self.mirrored.as_ref()
    }
}

/// Sets `visible` to the visible share of each light at a point, in units of 1 / [`OPEN`], and to 0 for lights that the point does
/// not receive.
pub(crate) fn trace_lights(renderer: &Renderer, lights: &DirectionSet, point: &SurfacePoint, visible: &mut [u8]) {
    visible.fill(0);
    let receives = |d| point.receives(d);
    renderer.intersector().trace_batch(point.ray_origin, lights, |_, d| receives(d), visible);
    renderer.intersector().attenuate(point.ray_origin, lights, receives, visible);
}

/// Traces and sums samples; keeps its buffer between points.
pub(crate) struct DistantShader<'a> {
    samples: &'a LightSamples,
    renderer: &'a Renderer,
    visible: Vec<u8>,
    /// Where the light of sharp lobes comes from.
    pub sharp: SharpLight,
}

impl PointShader for DistantShader<'_> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        trace_lights(self.renderer, &self.samples.directions, point, &mut self.visible);
        let map = self.samples.map().filter(|_| self.sharp == SharpLight::Map);
        let is_mirrored = self.sharp != SharpLight::Map || map.is_some();
        match Mirror::at(point, self.samples.solid_angle).filter(|_| is_mirrored) {
            Some(mirror) => self.mirrored(point, &mirror, map),
            None => self.sum(point),
        }
    }
}

impl DistantShader<'_> {
    /// Visible shares of eight samples.
    fn seen(&self, i: usize) -> f32x8 {
        let seen = |k| self.visible.get(8 * i + k).map_or(0.0, |&v| f32::from(v) / f32::from(OPEN));
        f32x8::new(std::array::from_fn(seen))
    }

    /// Light of all visible samples.
    fn sum(&self, point: &SurfacePoint) -> Vec3 {
        let Self { samples, visible, .. } = self;
        let receiver = ReceiverX8::new(point);
        let mut sum = Vec3x8::splat(Vec3::ZERO);
        for (i, _) in visible.chunks(8).enumerate().filter(|(_, seen)| seen.iter().any(|&v| v != 0)) {
            let wi = receiver.local(samples.wi[i]);
            sum = sum + point.reflect(wi, f32x8::ZERO).scale(samples.radiance[i]) * self.seen(i);
        }
        sum.reduce_add() * samples.solid_angle
    }

    /// The same sum if sharp lobes read the map, with the visibility of the samples around the mirror direction; without a map, the
    /// sum without these lobes' light.
    fn mirrored(&self, point: &SurfacePoint, mirror: &Mirror, map: Option<&MirroredMap>) -> Vec3 {
        let samples = self.samples;
        let receiver = ReceiverX8::new(point);
        let [mut sum, mut seen, mut all] = [Vec3x8::splat(Vec3::ZERO); 3];
        for (i, &direction) in samples.wi.iter().enumerate() {
            let wi = receiver.local(direction);
            let spread = mirror.sample_spread(wi, samples.inv_kappa[i]);
            let light = point.reflect(wi, spread).scale(samples.radiance[i])
                * Lanes::select(receiver.receives(direction), f32x8::ONE, f32x8::ZERO);
            let (reflected, window) = (light * self.seen(i), mirror.window(wi));
            sum = sum + reflected;
            seen = seen + reflected * window;
            all = all + light * window;
        }
        let [sum, seen, all] = [sum, seen, all].map(|sum| sum.reduce_add() * samples.solid_angle);
        match map {
            Some(map) => mirror.sharpened(sum, seen, all, || mirror.unshadowed::<f32x8>(point, map)),
            None => mirror.without_window(sum, seen),
        }
    }
}
