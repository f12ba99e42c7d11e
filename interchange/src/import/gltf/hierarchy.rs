//! The nodes of a glTF file.

use glam::{Mat4, Quat, Vec3};
use gltf::scene::Transform as Stored;
use lapidary_core::animation::nodes::{Node, Nodes, Transform, unit_rotation};

/// Largest deviation of a rotation's squared length from 1 without a warning.
const UNIT_TOLERANCE: f64 = 1e-2;

/// Peak bytes of a morph target weight of a node: in the node, and in three postures.
const WEIGHT: u64 = 16;

/// All nodes, and the nodes of a scene.
pub(super) struct Hierarchy {
    pub nodes: Nodes,
    /// Every node of the scene once, parents first; a file's cycles end at the second visit.
    pub order: Vec<usize>,
    /// Names of the nodes whose rotation was normalized.
    pub turned: Vec<String>,
}

/// Bytes of the weights of all nodes.
pub(super) fn bytes_of_weights(gltf: &gltf::Document) -> u64 {
    let targets = targets_of_meshes(gltf);
    let of_nodes = gltf.nodes().filter_map(|node| node.mesh()).map(|mesh| targets[mesh.index()] as u64);
    of_nodes.sum::<u64>().saturating_mul(WEIGHT)
}

/// Number of morph targets of each mesh.
fn targets_of_meshes(gltf: &gltf::Document) -> Vec<usize> {
    let of_mesh = |mesh: gltf::Mesh| mesh.primitives().map(|primitive| primitive.morph_targets().count()).max();
    gltf.meshes().map(|mesh| of_mesh(mesh).unwrap_or(0)).collect()
}

/// The nodes of a file and of one of its scenes; without scenes, all nodes are shown.
pub(super) fn read(gltf: &gltf::Document, scene: Option<usize>) -> Hierarchy {
    let targets = targets_of_meshes(gltf);
    let mut visit = Visit::new(gltf);
    let above = visit.top();
    let of_scene = |scene: gltf::Scene| scene.nodes().map(|node| node.index()).collect();
    let scene = scene.and_then(|index| gltf.scenes().nth(index));
    visit.below(scene.map_or_else(|| above.clone(), of_scene));
    let order = visit.order.clone();
    // Joints may be outside the scenes, and in cycles.
    visit.below(above);
    visit.below((0..visit.children.len()).collect());
    let read: Vec<(Node, bool)> =
        gltf.nodes().map(|node| read_node(&node, visit.parents[node.index()], &targets)).collect();
    let is_turned = |index: &usize| read[*index].1;
    let names: Vec<_> = gltf.nodes().collect();
    let turned = order.iter().filter(|index| is_turned(index)).map(|&index| node_name(&names[index])).collect();
    let nodes = read.into_iter().map(|(node, _)| node).collect();
    Hierarchy { nodes: Nodes::new(nodes, visit.order), order, turned }
}

/// A walk down the nodes.
struct Visit {
    children: Vec<Vec<usize>>,
    parents: Vec<Option<usize>>,
    is_visited: Vec<bool>,
    order: Vec<usize>,
}

impl Visit {
    fn new(gltf: &gltf::Document) -> Self {
        let children: Vec<Vec<usize>> =
            gltf.nodes().map(|node| node.children().map(|child| child.index()).collect()).collect();
        let count = children.len();
        Self { children, parents: vec![None; count], is_visited: vec![false; count], order: Vec::new() }
    }

    /// Nodes without a parent.
    fn top(&self) -> Vec<usize> {
        let mut is_child = vec![false; self.children.len()];
        self.children.iter().flatten().for_each(|&child| is_child[child] = true);
        (0..is_child.len()).filter(|&node| !is_child[node]).collect()
    }

    /// Visits unvisited nodes and all below them.
    fn below(&mut self, roots: Vec<usize>) {
        let mut pending: Vec<(usize, Option<usize>)> = roots.into_iter().map(|root| (root, None)).rev().collect();
        while let Some((node, parent)) = pending.pop() {
            if std::mem::replace(&mut self.is_visited[node], true) {
                continue;
            }
            self.parents[node] = parent;
            self.order.push(node);
            pending.extend(self.children[node].iter().rev().map(|&child| (child, Some(node))));
        }
    }
}

/// A node, and whether its rotation was normalized. The format requires unit quaternions; null ones become the identity.
fn read_node(node: &gltf::Node, parent: Option<usize>, targets: &[usize]) -> (Node, bool) {
    let matrix = Mat4::from_cols_array_2d(&node.transform().matrix());
    let weights = node.weights().or(node.mesh().and_then(|mesh| mesh.weights())).unwrap_or_default();
    let weights = completed(weights, node.mesh().map_or(0, |mesh| targets[mesh.index()]));
    let made = |at_rest, parent_from_node| Node { parent, at_rest, parent_from_node, weights };
    match node.transform() {
        Stored::Matrix { .. } => (made(decomposed(matrix), matrix), false),
        Stored::Decomposed { translation, rotation, scale } => {
            let at_rest =
                Transform { translation: translation.into(), rotation: unit_rotation(rotation), scale: scale.into() };
            let length_sq: f64 = rotation.iter().map(|x| f64::from(*x).powi(2)).sum();
            let is_turned = !((length_sq - 1.0).abs() < UNIT_TOLERANCE);
            (made(at_rest, if is_turned { at_rest.parent_from_node() } else { matrix }), is_turned)
        }
    }
}

/// Splits a matrix into translation, rotation and scale, which channels may change.
fn decomposed(matrix: Mat4) -> Transform {
    let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
    let is_one = scale.is_finite() && rotation.is_finite() && scale.min_element() != 0.0;
    let (scale, rotation) = if is_one { (scale, rotation) } else { (Vec3::ONE, Quat::IDENTITY) };
    Transform { translation, rotation, scale }
}

/// One weight for each of `targets` morph targets; missing ones and NaN are 0.
fn completed(weights: &[f32], targets: usize) -> Vec<f32> {
    let weight = |k: usize| weights.get(k).copied().filter(|weight| weight.is_finite()).unwrap_or(0.0);
    (0..targets).map(weight).collect()
}

/// The name of a node or its mesh, or one derived from its position in the file.
pub(super) fn node_name(node: &gltf::Node) -> String {
    let mesh_name = node.mesh().and_then(|m| m.name().map(str::to_owned));
    node.name().map(str::to_owned).or(mesh_name).unwrap_or_else(|| format!("node {}", node.index()))
}
