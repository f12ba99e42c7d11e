//! Sums over all leaves, each with its own BRDF value.

use crate::{
    measure::explain::leaves_below,
    shade::{
        merge::{EightTerms, Shader},
        node_field::NodeField,
        point_shader::PointShader,
        surface::{ReceiverX8, SurfacePoint},
    },
};
use glam::Vec3;
use lapidary_core::simd::Vec3x8;
use std::array::from_fn;

/// Light from every leaf, as radiance times visibility, for leaves of unit solid angle.
pub struct LeafSum<F> {
    field: F,
    /// One value per leaf in tree order.
    pub lit: Vec<Vec3>,
}

impl<F: NodeField> LeafSum<F> {
    /// Starts with all leaves dark.
    pub fn new(field: F) -> Self {
        Self { lit: vec![Vec3::ZERO; 1 << field.tree().height()], field }
    }

    /// Reflected radiance toward the eye.
    pub fn reflected(&self, point: &SurfacePoint) -> Vec3 {
        let receiver = ReceiverX8::new(point);
        let leaves = self.lit.len();
        let mut sum = Vec3x8::splat(Vec3::ZERO);
        for (first, lit) in (0..).step_by(8).zip(self.lit.chunks(8)) {
            if lit.iter().all(|&l| l == Vec3::ZERO) {
                continue;
            }
            // The last group is padded with dark copies of its last leaf.
            let index = from_fn(|i| leaves + first + i.min(lit.len() - 1));
            let arriving = Vec3x8::from_array(from_fn(|i| lit.get(i).copied().unwrap_or(Vec3::ZERO)));
            let direction = self.field.directions(index, point.position);
            let spread = self.field.leaf_inv_kappas(index, point.position);
            let reflected = point.reflect(receiver.local(direction), spread).scale(arriving);
            let mask = receiver.receives(direction);
            sum = sum + Vec3x8 { x: reflected.x & mask, y: reflected.y & mask, z: reflected.z & mask };
        }
        sum.reduce_add() * self.field.solid_angle()
    }
}

/// Nodes visited by a shader, with the mean BRDF over their leaves.
pub struct NodesByLeaves<'a, F> {
    shader: Shader<'a, F>,
    sum: LeafSum<F>,
}

impl<'a, F: NodeField> NodesByLeaves<'a, F> {
    /// Wraps `shader` over the tree of `field`.
    pub fn new(shader: Shader<'a, F>, field: F) -> Self {
        Self { shader, sum: LeafSum::new(field) }
    }
}

impl<F: NodeField> PointShader for NodesByLeaves<'_, F> {
    fn shade(&mut self, point: &SurfacePoint) -> Vec3 {
        let lit = &mut self.sum.lit;
        let leaves = lit.len();
        lit.fill(Vec3::ZERO);
        self.shader.traverse(
            point,
            |_| (),
            |eight: &EightTerms| {
                for (lane, term) in eight.terms.iter().enumerate().filter(|(_, term)| term.visibility > 0.0) {
                    lit[leaves_below(term.node, leaves)].fill(eight.radiance.lane(lane) * term.visibility);
                }
            },
        );
        self.sum.reflected(point)
    }
}
