//! Samples of the environment: a direction each.

use super::PointShader;
use crate::{
    renderer::{Illumination, Renderer},
    surface::SurfacePoint,
};
use glam::Vec3;
use lapidary_core::{ray::DirectionSet, simd::Vec3x8};
use wide::f32x8;

/// Light samples in tree order, padded to whole groups of eight.
pub(super) struct LightSamples {
    directions: DirectionSet,
    wi: Vec<Vec3x8>,
    radiance: Vec<Vec3x8>,
    solid_angle: f32,
}

impl LightSamples {
    pub fn new(renderer: &Renderer, light: &Illumination) -> Self {
        let tree = &renderer.dataset.tree;
        let lighting = renderer.lighting(light, 1);
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

/// Traces and sums; keeps its buffer between points.
struct DistantShader<'a> {
    samples: &'a LightSamples,
    renderer: &'a Renderer,
    visible: Vec<u8>,
}

impl PointShader for DistantShader<'_> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        let Self { samples, renderer, visible } = self;
        let (n, s) = (point.world_from_local.z_axis, point.smooth_normal);
        visible.fill(0);
        let received = |d: Vec3| d.dot(n) > 0.0 && d.dot(s) > 0.0;
        renderer.intersector.trace_batch(point.ray_origin, &samples.directions, received, visible);
        let axes = [0, 1, 2].map(|i| Vec3x8::splat(point.world_from_local.col(i)));
        let brdf = point.brdf.as_brdf();
        let mut sum = Vec3x8::splat(Vec3::ZERO);
        for (i, seen) in visible.chunks(8).enumerate().filter(|(_, seen)| seen.iter().any(|&v| v != 0)) {
            let d = samples.wi[i];
            let wi = Vec3x8 { x: d.dot(axes[0]), y: d.dot(axes[1]), z: d.dot(axes[2]) };
            let weight = f32x8::new(std::array::from_fn(|k| f32::from(seen.get(k).copied().unwrap_or(0))));
            sum = sum + brdf.brdf_cos_x8(wi, point.wo, f32x8::ZERO).scale(samples.radiance[i]) * weight;
        }
        sum.reduce_add() * samples.solid_angle
    }
}
