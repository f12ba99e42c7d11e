//! Skins: meshes that follow joints (glTF 2.0, section 3.7.3).

use glam::Mat4;

/// The joints that a mesh follows.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Indices of the nodes.
    pub joints: Vec<usize>,
    /// Matrices from the mesh to each joint in the bind pose.
    pub joints_from_mesh: Vec<Mat4>,
}

impl Skin {
    /// For each joint, the matrix from the mesh to the world. The transform of the mesh's own node does not apply.
    pub fn world_from_mesh(&self, world_from_nodes: &[Mat4]) -> Vec<Mat4> {
        let joints = self.joints.iter().zip(&self.joints_from_mesh);
        joints.map(|(&joint, joint_from_mesh)| world_from_nodes[joint] * *joint_from_mesh).collect()
    }
}

/// Four joints for each vertex, and their weights, as in a file.
#[derive(Clone, Debug)]
pub struct InfluenceSet {
    /// Indices into the joints of the skin.
    pub joints: Vec<[u16; 4]>,
    /// Weights of the joints; 0 where there are fewer than four.
    pub weights: Vec<[f32; 4]>,
}

impl InfluenceSet {
    fn of(&self, vertex: usize) -> impl Iterator<Item = (u16, f32)> {
        self.joints[vertex].into_iter().zip(self.weights[vertex]).filter(|(_, weight)| *weight != 0.0)
    }
}

/// Weights of a skin's joints for each vertex; the weights of a vertex sum to 1.
#[derive(Clone, Debug, Default)]
pub struct Influences {
    /// Start of each vertex's entries, and the end.
    starts: Vec<u32>,
    joints: Vec<u16>,
    weights: Vec<f32>,
}

impl Influences {
    /// Combines all sets of a mesh with `vertices` vertices, for a skin of `joints` joints.
    ///
    /// # Errors
    /// A description of the problem.
    pub fn new(sets: &[InfluenceSet], vertices: usize, joints: usize) -> Result<Self, String> {
        let mut influences = Self { starts: vec![0], ..Self::default() };
        for vertex in 0..vertices {
            let all: Vec<(u16, f32)> = sets.iter().flat_map(|set| set.of(vertex)).collect();
            influences.push(vertex, &all, joints)?;
        }
        Ok(influences)
    }

    fn push(&mut self, vertex: usize, all: &[(u16, f32)], joints: usize) -> Result<(), String> {
        if let Some((joint, _)) = all.iter().find(|(joint, _)| usize::from(*joint) >= joints) {
            return Err(format!("vertex {vertex} follows joint {joint}, but there are {joints}"));
        }
        let sum: f32 = all.iter().map(|(_, weight)| weight).sum();
        if !(sum > 0.0 && sum.is_finite() && all.iter().all(|(_, weight)| *weight > 0.0)) {
            return Err(format!("the weights of vertex {vertex} are zero, negative or not finite"));
        }
        self.joints.extend(all.iter().map(|(joint, _)| joint));
        self.weights.extend(all.iter().map(|(_, weight)| weight / sum));
        self.starts.push(self.joints.len() as u32);
        Ok(())
    }

    /// The mean of the joints' matrices for a vertex.
    pub fn mean(&self, vertex: usize, world_from_mesh: &[Mat4]) -> Mat4 {
        let range = self.starts[vertex] as usize..self.starts[vertex + 1] as usize;
        let weighted = |(&joint, &weight): (&u16, &f32)| world_from_mesh[usize::from(joint)] * weight;
        self.joints[range.clone()].iter().zip(&self.weights[range]).map(weighted).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn weights_are_normalised_over_all_sets() {
        let set = |joint, weights| InfluenceSet { joints: vec![[joint, 1, 0, 0]], weights: vec![weights] };
        let sets = [set(0, [1.0, 1.0, 0.0, 0.0]), set(1, [2.0, 0.0, 0.0, 0.0])];
        let influences = Influences::new(&sets, 1, 2).unwrap();
        let matrices = [Mat4::IDENTITY, Mat4::from_translation(Vec3::X)];
        assert_eq!(influences.mean(0, &matrices).w_axis.x, 0.75);
        assert_eq!(Influences::new(&sets[..1], 1, 2).unwrap().mean(0, &matrices).w_axis.x, 0.5, "negative control");
    }

    #[test]
    fn vertices_that_follow_nothing_are_told() {
        let of = |joint: u16, weight: f32| {
            let set = InfluenceSet { joints: vec![[joint; 4]], weights: vec![[weight, 0.0, 0.0, 0.0]] };
            Influences::new(&[set], 1, 2).err().unwrap_or_default()
        };
        assert_eq!(of(1, 0.5), "");
        assert!(of(2, 0.5).contains("joint 2, but there are 2"));
        for weight in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(of(1, weight).contains("the weights of vertex 0"), "{weight}");
        }
    }
}
