//! Samples of bounced light: a segment to every surface source that sends light.

use super::PointShader;
use crate::{
    indirect::SourceLighting,
    node_field::{NodeField, SourceField},
    renderer::Renderer,
    surface::SurfacePoint,
};
use glam::Vec3;
use lapidary_core::{indirect::Receiver, ray::SegmentBatch, simd::Vec3x8, surfel::OFFSET};
use std::array::from_fn;
use wide::f32x8;

/// Sources in tree order, and where segments to them end.
pub(super) struct SourceSamples<'a> {
    lighting: &'a SourceLighting,
    ends: Vec<Vec3>,
}

impl<'a> SourceSamples<'a> {
    pub fn new(renderer: &Renderer, lighting: &'a SourceLighting) -> Self {
        let off_surface = OFFSET * renderer.dataset.scene.mesh.bounds().diagonal();
        let sources = lighting.tree.sources();
        let ends = sources.iter().map(|s| s.surfel.position + s.surfel.normal * off_surface).collect();
        Self { lighting, ends }
    }

    pub fn shader(&'a self, renderer: &'a Renderer) -> impl PointShader {
        SourceShader {
            samples: self,
            field: SourceField::new(self.lighting),
            renderer,
            batch: SegmentBatch::default(),
            solid_angles: vec![0.0; self.ends.len()],
            wanted: Vec::new(),
        }
    }
}

/// Traces and sums; keeps its buffers between points.
struct SourceShader<'a> {
    samples: &'a SourceSamples<'a>,
    field: SourceField<'a>,
    renderer: &'a Renderer,
    batch: SegmentBatch,
    solid_angles: Vec<f32>,
    wanted: Vec<u32>,
}

impl SourceShader<'_> {
    /// Sets the solid angles of the sources that are seen, and lists those that may be.
    fn trace(&mut self, point: &SurfacePoint) {
        let (lighting, solid_angles) = (self.samples.lighting, &mut self.solid_angles);
        let (n, s) = (point.world_from_local.z_axis, point.smooth_normal);
        let leaves = lighting.tree.len();
        let receiver = Receiver { position: point.position, normal: s, radius: 0.0 };
        self.wanted.clear();
        for (i, source) in lighting.tree.sources().iter().enumerate() {
            let direction = source.surfel.position - point.position;
            let received = direction.dot(n) > 0.0 && direction.dot(s) > 0.0;
            let sends = lighting.nodes.radiance[leaves + i] != Vec3::ZERO;
            solid_angles[i] = if received && sends { source.mean_solid_angle(&receiver) } else { 0.0 };
            if solid_angles[i] > 0.0 {
                self.wanted.push(i as u32);
            }
        }
        let hidden = |i: u32| solid_angles[i as usize] = 0.0;
        self.batch.trace(&self.renderer.intersector, point.ray_origin, &self.samples.ends, &self.wanted, hidden);
    }
}

impl PointShader for SourceShader<'_> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        self.trace(point);
        let axes = [0, 1, 2].map(|i| Vec3x8::splat(point.world_from_local.col(i)));
        let brdf = point.brdf.as_brdf();
        let leaves = self.samples.lighting.tree.len();
        let mut sum = Vec3x8::splat(Vec3::ZERO);
        for group in self.wanted.chunks(8) {
            // Padding repeats the first source without a solid angle.
            let member = |k: usize| group.get(k).map_or(group[0], |&i| i) as usize;
            let nodes = from_fn(|k| leaves + member(k));
            let direction = self.field.directions(nodes, point.position);
            let wi = Vec3x8 { x: direction.dot(axes[0]), y: direction.dot(axes[1]), z: direction.dot(axes[2]) };
            let weight = from_fn(|k| if k < group.len() { self.solid_angles[member(k)] } else { 0.0 });
            let radiance = Vec3x8::from_array(nodes.map(|n| self.field.radiance(n)));
            let inv_kappa = self.field.inv_kappas(nodes, point.position);
            sum = sum + brdf.brdf_cos_x8(wi, point.wo, inv_kappa).scale(radiance) * f32x8::new(weight);
        }
        sum.reduce_add()
    }
}
