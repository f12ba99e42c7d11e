//! The merge's interface to a tree of lights: distant lights with constant directions, or surface sources with directions that
//! depend on the point.

use crate::light::{
    bounce::SourceLighting,
    environment::{Distant, SceneLighting},
    mirrored_map::MirroredMap,
    node_row::{EightNodes, NodeExtent, NodeRow},
    sent::SentByDirection,
    tree_light::TreeLight,
};
use glam::Vec3;
use lapidary_core::{
    brdf::LobeMomentsX8,
    cut::{packed::VALUE_MAX, solid_angles},
    simd::{Lanes, Vec3x8},
    sources::SourceTree,
};
use std::sync::Arc;
use wide::f32x8;

/// A light tree under one illumination. Nodes are heap indices.
pub(crate) trait NodeField: Copy {
    /// The leaves of the tree.
    type Lights;

    /// The tree.
    fn tree(&self) -> &TreeLight<Self::Lights>;
    /// Value of a 12-bit code in a vertex's cut.
    fn cut_value(&self, code: u16) -> f32;
    /// Solid angle in steradians of a leaf with a cut value of one.
    fn solid_angle(&self) -> f32;
    /// Cones of eight nodes from a point, for the refinement test.
    fn cones<L: Lanes>(&self, nodes: [usize; 8], from: Vec3) -> EightCones<L>;
    /// Light of eight nodes at a point, with each node's angular spread if `spread`, else with none.
    fn light<L: Lanes>(&self, nodes: [usize; 8], from: Vec3, spread: bool) -> EightLights<L>;
    /// Unit directions to eight nodes from a point.
    fn directions(&self, nodes: [usize; 8], from: Vec3) -> Vec3x8;
    /// Angular spread of the light from eight nodes, as inverse concentrations of von Mises-Fisher lobes.
    fn inv_kappas(&self, nodes: [usize; 8], from: Vec3) -> f32x8;
    /// Angular spread of eight leaves, as the references use it.
    fn leaf_inv_kappas(&self, leaves: [usize; 8], from: Vec3) -> f32x8;
    /// Center of a node's light, unless infinitely far.
    fn center(&self, node: usize) -> Option<Vec3>;
    /// The map of its light samples, if any.
    fn mirrored<'m>(self) -> Option<&'m MirroredMap>
    where
        Self: 'm;

    /// Mean radiance of a node, or what it sends back along the direction that leads to it.
    #[inline(always)]
    fn radiance(&self, node: usize, _direction: Vec3) -> Vec3 {
        self.tree().nodes.radiance[node]
    }
}

/// Light that arrives from eight nodes.
pub(crate) struct EightLights<L> {
    /// Unit directions to them.
    pub direction: Vec3x8<L>,
    /// Angular spread, as inverse concentrations of von Mises-Fisher lobes.
    pub inv_kappa: L,
    /// Moments of these lobes.
    pub moments: LobeMomentsX8<L>,
    /// Mean radiance.
    pub radiance: Vec3x8<L>,
}

impl<L: Lanes> EightLights<L> {
    /// Lights without angular spread.
    #[inline(always)]
    fn of_points(direction: Vec3x8<L>, radiance: Vec3x8<L>) -> Self {
        let (inv_kappa, moments) = (L::splat(0.0), LobeMomentsX8::known(L::splat(0.0), L::splat(1.0)));
        Self { direction, inv_kappa, moments, radiance }
    }
}

/// Directions of eight nodes.
pub(crate) struct EightCones<L> {
    /// Unit directions to the nodes.
    pub direction: Vec3x8<L>,
    /// Half-angles in radians.
    pub radius: L,
    /// Brightness of the nodes; see [`NodeExtent`].
    pub brightness: L,
}

impl NodeField for &SceneLighting {
    type Lights = Distant;

    #[inline(always)]
    fn tree(&self) -> &SceneLighting {
        self
    }

    #[inline(always)]
    fn cut_value(&self, code: u16) -> f32 {
        f32::from(code) * (1.0 / VALUE_MAX as f32)
    }

    #[inline(always)]
    fn solid_angle(&self) -> f32 {
        self.lights.leaf_solid_angle
    }

    #[inline(always)]
    fn cones<L: Lanes>(&self, nodes: [usize; 8], _from: Vec3) -> EightCones<L> {
        let [radius, brightness] = NodeExtent::eight(&self.extents, nodes);
        EightCones { direction: NodeRow::eight(&self.rows, nodes).place, radius, brightness }
    }

    #[inline(always)]
    fn light<L: Lanes>(&self, nodes: [usize; 8], _from: Vec3, spread: bool) -> EightLights<L> {
        let EightNodes { place: direction, spread: inv_kappa, radiance, resultant } = NodeRow::eight(&self.rows, nodes);
        if !spread {
            return EightLights::of_points(direction, radiance);
        }
        EightLights { direction, inv_kappa, moments: LobeMomentsX8::known(inv_kappa, resultant), radiance }
    }

    #[inline(always)]
    fn directions(&self, nodes: [usize; 8], _from: Vec3) -> Vec3x8 {
        Vec3x8::from_array(nodes.map(|n| self.nodes.place[n]))
    }

    #[inline(always)]
    fn inv_kappas(&self, nodes: [usize; 8], _from: Vec3) -> f32x8 {
        f32x8::new(nodes.map(|n| self.nodes.spread[n]))
    }

    /// Samples are single directions.
    #[inline(always)]
    fn leaf_inv_kappas(&self, _leaves: [usize; 8], _from: Vec3) -> f32x8 {
        f32x8::ZERO
    }

    fn center(&self, _node: usize) -> Option<Vec3> {
        None
    }

    fn mirrored<'m>(self) -> Option<&'m MirroredMap>
    where
        Self: 'm,
    {
        self.lights.mirrored.as_ref()
    }
}

/// Surface sources that send light, see [`SourceLighting`].
#[derive(Clone, Copy)]
pub(crate) struct SourceField<'a> {
    lighting: &'a SourceLighting,
    /// What it sends by direction, unless it counts as diffuse.
    sent: Option<&'a SentByDirection>,
    /// Solid angle of each code.
    solid_angles: &'static [f32; 4096],
}

impl<'a> SourceField<'a> {
    /// Wraps sources under one illumination.
    pub fn new(lighting: &'a SourceLighting) -> Self {
        Self { lighting, sent: lighting.sent.as_deref(), solid_angles: solid_angles() }
    }

    /// The same sources as if they were diffuse.
    pub fn as_diffuse(&self) -> Self {
        Self { sent: None, ..*self }
    }
}

/// Smallest distance in meters: a point on a source still has a direction to it.
pub(crate) const LEAST_DISTANCE: f32 = 1e-6;

impl NodeField for SourceField<'_> {
    type Lights = Arc<SourceTree>;

    #[inline(always)]
    fn tree(&self) -> &SourceLighting {
        self.lighting
    }

    #[inline(always)]
    fn radiance(&self, node: usize, direction: Vec3) -> Vec3 {
        let mean = self.lighting.nodes.radiance[node];
        self.sent.map_or(mean, |sent| sent.share(node, -direction) * mean.max_element())
    }

    #[inline(always)]
    fn cut_value(&self, code: u16) -> f32 {
        self.solid_angles[usize::from(code)]
    }

    #[inline(always)]
    fn solid_angle(&self) -> f32 {
        1.0
    }

    #[inline(always)]
    fn cones<L: Lanes>(&self, nodes: [usize; 8], from: Vec3) -> EightCones<L> {
        let [radius, brightness] = NodeExtent::eight(&self.lighting.extents, nodes);
        let to_center = NodeRow::eight::<L>(&self.lighting.rows, nodes).place - Vec3x8::splat(from);
        let one = L::splat(1.0);
        let inv_distance = one / to_center.dot(to_center).sqrt().at_least(LEAST_DISTANCE);
        let tan = radius * inv_distance;
        // Twice the tangent of half the angle, close to the angle for angles that need no split.
        let radius = (tan + tan) / (one + (one + tan * tan).sqrt());
        EightCones { direction: to_center * inv_distance, radius, brightness }
    }

    #[inline(always)]
    fn light<L: Lanes>(&self, nodes: [usize; 8], from: Vec3, spread: bool) -> EightLights<L> {
        let rows = NodeRow::eight(&self.lighting.rows, nodes);
        let to_center = rows.place - Vec3x8::splat(from);
        let direction = normalized(to_center);
        let radiance = match self.sent {
            None => rows.radiance,
            Some(sent) => {
                let Vec3x8 { x, y, z } = rows.radiance;
                sent.shares(nodes, direction * L::splat(-1.0)) * x.fast_max(y).fast_max(z)
            }
        };
        if !spread {
            return EightLights::of_points(direction, radiance);
        }
        let inv_kappa = cap_inv_kappa(to_center, rows.spread);
        EightLights { direction, inv_kappa, moments: LobeMomentsX8::new(inv_kappa), radiance }
    }

    #[inline(always)]
    fn directions(&self, nodes: [usize; 8], from: Vec3) -> Vec3x8 {
        normalized(self.toward_centers(nodes, from))
    }

    #[inline(always)]
    fn inv_kappas(&self, nodes: [usize; 8], from: Vec3) -> f32x8 {
        let spread = f32x8::new(nodes.map(|n| self.lighting.nodes.spread[n]));
        cap_inv_kappa(self.toward_centers(nodes, from), spread)
    }

    /// The spread of a disc.
    #[inline(always)]
    fn leaf_inv_kappas(&self, leaves: [usize; 8], from: Vec3) -> f32x8 {
        self.inv_kappas(leaves, from)
    }

    fn center(&self, node: usize) -> Option<Vec3> {
        Some(self.lighting.nodes.place[node])
    }

    fn mirrored<'m>(self) -> Option<&'m MirroredMap>
    where
        Self: 'm,
    {
        None
    }
}

impl SourceField<'_> {
    #[inline(always)]
    fn toward_centers(&self, nodes: [usize; 8], from: Vec3) -> Vec3x8 {
        Vec3x8::from_array(nodes.map(|n| self.lighting.nodes.place[n])) - Vec3x8::splat(from)
    }
}

#[inline(always)]
fn normalized<L: Lanes>(to_center: Vec3x8<L>) -> Vec3x8<L> {
    to_center * (L::splat(1.0) / to_center.dot(to_center).sqrt().at_least(LEAST_DISTANCE))
}

/// Inverse concentrations of discs with radius `spread` in meters, seen face on.
#[inline(always)]
fn cap_inv_kappa<L: Lanes>(to_center: Vec3x8<L>, spread: L) -> L {
    let one = L::splat(1.0);
    let distance_sq = to_center.dot(to_center).at_least(LEAST_DISTANCE * LEAST_DISTANCE);
    // A cap of half-angle r, tan r = spread / distance, has its centroid at R = (1 + cos r) / 2.
    let cos = one / (one + spread * spread / distance_sq).sqrt();
    let resultant = L::splat(0.5) * (one + cos);
    let resultant_sq = resultant * resultant;
    (one - resultant_sq) / (resultant * (L::splat(3.0) - resultant_sq))
}
