//! The nodes of a file: a hierarchy of transforms (glTF 2.0, section 3.5), and the weights of their morph targets.

use glam::{DVec4, Mat4, Quat, Vec3, Vec4};

/// Transform of a node within its parent: scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// In units of the parent; meters at the root.
    pub translation: Vec3,
    /// Unit quaternion.
    pub rotation: Quat,
    /// Along the node's own axes.
    pub scale: Vec3,
}

impl Transform {
    /// Matrix from the node to its parent.
    pub fn parent_from_node(&self) -> Mat4 {
        Mat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// Normalizes a rotation as stored in files: x, y, z, w. A null rotation becomes the identity.
pub fn unit_rotation(stored: [f32; 4]) -> Quat {
    let unit = DVec4::from_array(stored.map(f64::from)).try_normalize().unwrap_or(DVec4::W);
    Quat::from_vec4(Vec4::from_array(unit.as_vec4().to_array()))
}

/// A node.
#[derive(Clone, Debug)]
pub struct Node {
    /// Index of the parent node.
    pub parent: Option<usize>,
    /// Its transform without an animation.
    pub at_rest: Transform,
    /// Its matrix in the file, which may shear.
    pub parent_from_node: Mat4,
    /// Weights of the morph targets of its mesh without an animation.
    pub weights: Vec<f32>,
}

/// All nodes of a file by index, and an order in which parents come first.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    nodes: Vec<Node>,
    order: Vec<usize>,
}

/// Animated state: for each node its transform within its parent, and the weights of its morph targets.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeState {
    /// Transforms by node.
    pub transforms: Vec<Transform>,
    /// Weights by node and morph target.
    pub weights: Vec<Vec<f32>>,
}

impl Nodes {
    /// `order` has every index once, parents first.
    pub fn new(nodes: Vec<Node>, order: Vec<usize>) -> Self {
        Self { nodes, order }
    }

    /// A node by its index.
    pub fn get(&self, node: usize) -> &Node {
        &self.nodes[node]
    }

    /// Gives a node at rest a scale of `least` along each axis where it is 0. Returns whether there is such an axis.
    pub fn extend_at_rest(&mut self, node: usize, least: f32) -> bool {
        let node = &mut self.nodes[node];
        let scale = node.at_rest.scale.map(|along| if along == 0.0 { least } else { along });
        let is_changed = scale != node.at_rest.scale;
        if is_changed {
            node.at_rest.scale = scale;
            node.parent_from_node = node.at_rest.parent_from_node();
        }
        is_changed
    }

    /// Puts a node at rest elsewhere in its parent.
    pub fn place_at_rest(&mut self, node: usize, translation: Vec3) {
        let node = &mut self.nodes[node];
        node.at_rest.translation = translation;
        node.parent_from_node.w_axis = translation.extend(1.0);
    }

    /// The state without an animation.
    pub fn at_rest(&self) -> NodeState {
        NodeState {
            transforms: self.nodes.iter().map(|node| node.at_rest).collect(),
            weights: self.nodes.iter().map(|node| node.weights.clone()).collect(),
        }
    }

    /// Matrices from each node to the world. Nodes at rest keep the matrix of the file.
    pub fn world_from_nodes(&self, state: &NodeState) -> Vec<Mat4> {
        let mut world_from_nodes = vec![Mat4::IDENTITY; self.nodes.len()];
        for &index in &self.order {
            let (node, transform) = (&self.nodes[index], &state.transforms[index]);
            let is_at_rest = *transform == node.at_rest;
            let parent_from_node = if is_at_rest { node.parent_from_node } else { transform.parent_from_node() };
            let world_from_parent = node.parent.map_or(Mat4::IDENTITY, |parent| world_from_nodes[parent]);
            world_from_nodes[index] = world_from_parent * parent_from_node;
        }
        world_from_nodes
    }

    /// The nodes that `moving` nodes move: themselves and all below them.
    pub fn carried(&self, moving: &[bool]) -> Vec<bool> {
        let mut carried = moving.to_vec();
        for &index in &self.order {
            carried[index] |= self.nodes[index].parent.is_some_and(|parent| carried[parent]);
        }
        carried
    }
}
