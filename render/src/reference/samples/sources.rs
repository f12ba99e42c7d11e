//! Samples of bounced light: a segment to every surface source that sends light, and rays in all directions for near sources.

use crate::{
    light::bounce::SourceLighting,
    renderer::Renderer,
    shade::{
        merge::SharpLight,
        mirror::rays::RayLobes,
        node_field::{NodeField, SourceField},
        point_shader::PointShader,
        surface::{ReceiverX8, SurfacePoint},
    },
};
use glam::Vec3;
use lapidary_core::{
    offset,
    ray::SegmentBatch,
    simd::Vec3x8,
    sources::{NearField, Origin},
};
use std::array::from_fn;
use wide::f32x8;

/// Sources in tree order, and where segments to them end.
pub(crate) struct SourceSamples<'a> {
    lighting: &'a SourceLighting,
    ends: Vec<Vec3>,
    near: NearField,
}

impl<'a> SourceSamples<'a> {
    pub fn new(renderer: &Renderer, lighting: &'a SourceLighting) -> Self {
        let off_surface = offset::TRANSPORT * renderer.dataset.scene.mesh.bounds().diagonal();
        let sources = lighting.lights.sources();
        let ends = sources.iter().map(|s| s.surfel.position + s.surfel.normal * off_surface).collect();
        let near = NearField::new(sources);
        Self { lighting, ends, near }
    }

    pub fn shader(&'a self, renderer: &'a Renderer) -> SourceShader<'a> {
        SourceShader {
            samples: self,
            field: SourceField::new(self.lighting),
            renderer,
            batch: SegmentBatch::default(),
            solid_angles: vec![0.0; self.ends.len()],
            wanted: Vec::new(),
            sharp: SharpLight::Map,
        }
    }
}

/// Traces and sums sources; keeps its buffers between points.
pub(crate) struct SourceShader<'a> {
    samples: &'a SourceSamples<'a>,
    field: SourceField<'a>,
    renderer: &'a Renderer,
    batch: SegmentBatch,
    solid_angles: Vec<f32>,
    wanted: Vec<u32>,
    /// Where the light of sharp lobes comes from.
    pub sharp: SharpLight,
}

impl SourceShader<'_> {
    /// Sets the solid angles of visible sources, and lists candidate sources.
    fn trace(&mut self, point: &SurfacePoint) {
        let receives = |direction: Vec3| point.receives(direction);
        let has_near = self.trace_far(point, receives);
        if has_near {
            self.gather_near(point, receives);
        }
    }

    /// Distant sources, one segment each. Returns whether near sources face the point.
    fn trace_far(&mut self, point: &SurfacePoint, receives: impl Fn(Vec3) -> bool) -> bool {
        let Self { samples, solid_angles, wanted, .. } = self;
        let lighting = samples.lighting;
        let leaves = lighting.lights.len();
        let mut has_near = false;
        wanted.clear();
        solid_angles.fill(0.0);
        for (i, source) in lighting.lights.sources().iter().enumerate() {
            let sends = lighting.nodes.radiance[leaves + i] != Vec3::ZERO;
            let solid_angle = source.solid_angle_from(point.position);
            if solid_angle == 0.0 || !sends || !receives(source.surfel.position - point.position) {
                continue;
            }
            if samples.near.holds(source, point.ray_origin) {
                has_near |= samples.near.is_over(source, point.position);
            } else {
                solid_angles[i] = solid_angle;
                wanted.push(i as u32);
            }
        }
        let hidden = |i: u32| solid_angles[i as usize] = 0.0;
        let intersector = self.renderer.intersector();
        self.batch.trace(intersector, point.ray_origin, &samples.ends, wanted, hidden);
        for &i in wanted.iter().filter(|_| intersector.has_veils()) {
            let opacity = intersector.opacity_at(samples.lighting.lights.sources()[i as usize].surfel.place);
            solid_angles[i as usize] *=
                opacity * intersector.past_veils_between(point.ray_origin, samples.ends[i as usize]);
        }
        has_near
    }

    /// Near sources, by rays in all directions.
    fn gather_near(&mut self, point: &SurfacePoint, receives: impl Fn(Vec3) -> bool) {
        let Self { samples, solid_angles, wanted, renderer, .. } = self;
        let sources = samples.lighting.lights.sources();
        let lifted = point.ray_origin - point.position;
        let origin = Origin {
            position: point.ray_origin,
            anchor: point.ray_origin,
            normal: point.world_from_local.z_axis,
            face: lifted.normalize_or(point.smooth_normal),
            lift: lifted.length(),
            same_surface_cosine: Origin::SAME_SURFACE_COSINE,
        };
        samples.near.gather(sources, renderer.intersector(), origin, receives, |i, solid_angle| {
            if solid_angles[i] == 0.0 {
                wanted.push(i as u32);
            }
            solid_angles[i] += solid_angle;
        });
    }
}

impl PointShader for SourceShader<'_> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        self.trace(point);
        let receiver = ReceiverX8::new(point);
        let leaves = self.samples.lighting.lights.len();
        let (rays, brightest) = (self.sharp.lobes(point), self.sharp.brightest());
        let narrowing = rays.as_ref().and_then(RayLobes::narrowing);
        let [mut sum, mut seen] = [Vec3x8::splat(Vec3::ZERO); 2];
        for group in self.wanted.chunks(8) {
            // Padding repeats the first source with zero solid angle.
            let member = |k: usize| group.get(k).map_or(group[0], |&i| i) as usize;
            let nodes = from_fn(|k| leaves + member(k));
            let direction = self.field.directions(nodes, point.position);
            let wi = receiver.local(direction);
            let weight = from_fn(|k| if k < group.len() { self.solid_angles[member(k)] } else { 0.0 });
            let radiance = Vec3x8::from_array(from_fn(|k| self.field.radiance(nodes[k], direction.lane(k))));
            let inv_kappa = self.field.leaf_inv_kappas(nodes, point.position);
            let inv_kappa = narrowing.map_or(inv_kappa, |mirror| mirror.spread(wi, inv_kappa));
            let reflected = point.reflect(wi, inv_kappa).scale(radiance) * f32x8::new(weight);
            sum = sum + reflected;
            if let Some(rays) = &rays {
                seen = seen + reflected * rays.share_below(wi, radiance, brightest);
            }
        }
        (sum.reduce_add() - seen.reduce_add()).max(Vec3::ZERO)
    }
}
