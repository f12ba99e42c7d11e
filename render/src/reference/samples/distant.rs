//! Samples of the environment: a direction each.

use crate::{
    light::environment::SceneLighting,
    renderer::Renderer,
    shade::{
        point_shader::PointShader,
        surface::{ReceiverX8, SurfacePoint},
    },
};
use glam::Vec3;
use lapidary_core::{light_tree::LightTree, ray::DirectionSet, simd::Vec3x8};
use wide::f32x8;

/// Light samples in tree order, padded to whole groups of eight.
pub(crate) struct LightSamples {
    directions: DirectionSet,
    wi: Vec<Vec3x8>,
    radiance: Vec<Vec3x8>,
    solid_angle: f32,
}

impl LightSamples {
    /// Of a tree that is lit; its illumination cut does not matter.
    pub fn of(tree: &LightTree, lighting: &SceneLighting) -> Self {
        let leaf_radiance = &lighting.nodes.radiance[tree.len()..];
        let eight = |values: &[Vec3]| -> Vec<Vec3x8> {
            let lane = |chunk: &[Vec3], i: usize| chunk.get(i).copied().unwrap_or(Vec3::ZERO);
            values.chunks(8).map(|c| Vec3x8::from_array(std::array::from_fn(|i| lane(c, i)))).collect()
        };
        Self {
            directions: DirectionSet::new(tree.leaf_directions()),
            wi: eight(tree.leaf_directions()),
            radiance: eight(leaf_radiance),
            solid_angle: tree.leaf_solid_angle(),
        }
    }

    pub fn shader<'a>(&'a self, renderer: &'a Renderer) -> impl PointShader {
        DistantShader { samples: self, renderer, visible: vec![0; self.directions.len()] }
    }
}

/// Sets `visible` to 1 for the lights that a point sees and whose light it receives, and to 0 for all others.
pub(crate) fn trace_lights(renderer: &Renderer, lights: &DirectionSet, point: &SurfacePoint, visible: &mut [u8]) {
    visible.fill(0);
    renderer.intersector().trace_batch(point.ray_origin, lights, |d| point.receives(d), visible);
}

/// Traces and sums; keeps its buffer between points.
struct DistantShader<'a> {
    samples: &'a LightSamples,
    renderer: &'a Renderer,
    visible: Vec<u8>,
}

impl PointShader for DistantShader<'_> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        let Self { samples, renderer, visible } = self;
        trace_lights(renderer, &samples.directions, point, visible);
        let receiver = ReceiverX8::new(point);
        let mut sum = Vec3x8::splat(Vec3::ZERO);
        for (i, seen) in visible.chunks(8).enumerate().filter(|(_, seen)| seen.iter().any(|&v| v != 0)) {
            let wi = receiver.local(samples.wi[i]);
            let weight = f32x8::new(std::array::from_fn(|k| f32::from(seen.get(k).copied().unwrap_or(0))));
            sum = sum + point.reflect(wi, f32x8::ZERO).scale(samples.radiance[i]) * weight;
        }
        sum.reduce_add() * samples.solid_angle
    }
}
