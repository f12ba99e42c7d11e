//! Visibility by rays from the vertices, interpolated: the result of exact cuts.

use super::leaf_sum::LeafSum;
use crate::{
    light::environment::SceneLighting,
    shade::{point_shader::PointShader, surface::SurfacePoint},
};
use glam::Vec3;
use lapidary_core::ray::OPEN;
use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};

/// Sets the visibility (0 or 1) of all leaves of the environment's tree at a vertex.
pub type TraceVertex<'a> = &'a (dyn Fn(u32, &mut [u8]) + Sync);

/// Vertices in the cache, at one byte per leaf: half a gigabyte for 32,768 leaves. Neighboring pixels share vertices.
const KEPT: usize = 16_384;

/// Visibility of vertices, traced at first use.
pub struct TracedVertices<'a> {
    trace: TraceVertex<'a>,
    leaves: usize,
    known: Mutex<HashMap<u32, Arc<[u8]>>>,
}

impl<'a> TracedVertices<'a> {
    /// Creates an empty cache for the tree of `lighting`.
    pub fn new(lighting: &SceneLighting, trace: TraceVertex<'a>) -> Self {
        Self { trace, leaves: lighting.leaves(), known: Mutex::default() }
    }

    /// A shader that uses the traced visibility.
    pub fn shader<'b>(&'b self, lighting: &'b SceneLighting) -> impl PointShader {
        VertexShader { vertices: self, lighting, sum: LeafSum::new(lighting) }
    }

    fn of(&self, vertex: u32) -> Arc<[u8]> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(visible) = known().get(&vertex) {
            return visible.clone();
        }
        let mut visible = vec![0; self.leaves];
        (self.trace)(vertex, &mut visible);
        let visible: Arc<[u8]> = visible.into();
        let mut known = known();
        if known.len() >= KEPT {
            known.clear();
        }
        known.insert(vertex, visible.clone());
        visible
    }
}

struct VertexShader<'a, 'b> {
    vertices: &'a TracedVertices<'b>,
    lighting: &'a SceneLighting,
    sum: LeafSum<&'a SceneLighting>,
}

impl PointShader for VertexShader<'_, '_> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        let visible = point.vertices.map(|vertex| self.vertices.of(vertex));
        let leaves = self.sum.lit.len();
        for (leaf, lit) in self.sum.lit.iter_mut().enumerate() {
            let share: f32 = visible
                .iter()
                .zip(point.weights)
                .map(|(v, weight)| weight * f32::from(v[leaf]) / f32::from(OPEN))
                .sum();
            *lit = self.lighting.nodes.radiance[leaves + leaf] * share;
        }
        self.sum.reflected(point)
    }
}
