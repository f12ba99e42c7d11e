//! Primitives that an animation moves, each with its deformation.

use super::{
    nodes::{NodeState, Nodes},
    skin::{Influences, Skin},
    surface::{MorphTarget, Surface},
};
use crate::sphere::fibonacci_directions;
use glam::{Mat4, Vec3};

/// The fractions of its multiples are far apart.
const GOLDEN_RATIO: f32 = 1.618_034;

/// Changes to the vertices of a primitive in addition to its node's transform.
#[derive(Clone, Debug, Default)]
pub struct Deformation {
    /// Morph targets.
    pub targets: Vec<MorphTarget>,
    /// Index of the skin, and the influences of its joints on each vertex.
    pub skin: Option<(usize, Influences)>,
}

/// A primitive of a node.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Index of its object in the scene.
    pub object: u32,
    /// Index of the node.
    pub node: usize,
    /// Its vertices in its own space.
    pub surface: Surface,
    /// Its triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Its deformation.
    pub deformation: Deformation,
}

/// The transforms of a file's nodes at a time, and of its skins' joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture {
    world_from_nodes: Vec<Mat4>,
    /// Matrices by skin and joint.
    joints: Vec<Vec<Mat4>>,
    weights: Vec<Vec<f32>>,
}

impl Posture {
    /// The posture for a state of the nodes.
    pub fn new(nodes: &Nodes, skins: &[Skin], state: NodeState) -> Self {
        let world_from_nodes = nodes.world_from_nodes(&state);
        let joints = skins.iter().map(|skin| skin.world_from_mesh(&world_from_nodes)).collect();
        Self { world_from_nodes, joints, weights: state.weights }
    }

    /// The posture with each joint moved by a distance in meters in its own direction, and each morph target changed by
    /// its own weight.
    pub fn trial(&self, distance: f32) -> Self {
        let mut trial = self.clone();
        for joints in &mut trial.joints {
            let directions = fibonacci_directions(joints.len());
            let moved =
                |(joint, direction): (&mut Mat4, Vec3)| *joint = Mat4::from_translation(distance * direction) * *joint;
            joints.iter_mut().zip(directions).for_each(moved);
        }
        for weights in &mut trial.weights {
            (1..).zip(weights).for_each(|(k, weight)| *weight += 0.5 + (k as f32 * GOLDEN_RATIO).fract());
        }
        trial
    }

    /// Matrix from a node to the world.
    pub fn world_from_node(&self, node: usize) -> Mat4 {
        self.world_from_nodes[node]
    }
}

impl Deformation {
    /// Transforms the vertices of a primitive of `node` into the world. Returns whether that mirrors them.
    pub fn place(&self, surface: &mut Surface, node: usize, posture: &Posture) -> bool {
        surface.morph(&self.targets, &posture.weights[node]);
        match &self.skin {
            Some((skin, influences)) => surface.skin(influences, &posture.joints[*skin]),
            None => surface.place(posture.world_from_nodes[node]),
        }
    }
}

impl Shape {
    /// Whether two postures transform it equally, to the bit.
    pub fn is_same(&self, a: &Posture, b: &Posture) -> bool {
        let is_placed_alike = match &self.deformation.skin {
            Some((skin, _)) => a.joints[*skin] == b.joints[*skin],
            None => a.world_from_nodes[self.node] == b.world_from_nodes[self.node],
        };
        is_placed_alike && (self.deformation.targets.is_empty() || a.weights[self.node] == b.weights[self.node])
    }

    /// Its vertices in the world, all with normals.
    pub fn posed(&self, posture: &Posture) -> Surface {
        let mut surface = self.surface.clone();
        self.deformation.place(&mut surface, self.node, posture);
        surface.complete_normals(&self.triangles);
        surface
    }
}
