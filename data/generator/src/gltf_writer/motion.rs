//! Skins, morph targets and animations as glTF.

use serde_json::{Value, json};

use super::{ARRAY_BUFFER, FLOAT, UNSIGNED_SHORT, Writer, bounds};
use crate::motion::{Channel, Clip, Joint, Motion, Moved};
use crate::scene::Scene;

impl Writer {
    /// Adds motion to the meshes and nodes of a scene. Returns the skins and the animations. Joints follow all other nodes.
    pub fn motion(
        &mut self,
        scene: &Scene,
        motion: &Motion,
        meshes: &mut [Value],
        nodes: &mut Vec<Value>,
    ) -> [Value; 2] {
        let first = nodes.len();
        self.skin_attributes(motion, &mut meshes[motion.skin.piece]);
        self.morph_target(motion, &mut meshes[motion.morph.piece]);
        let skinned = scene.nodes.iter().position(|node| node.piece == motion.skin.piece);
        skinned.into_iter().for_each(|node| nodes[node]["skin"] = json!(0));
        nodes.extend((0..motion.joints.len()).map(|joint| joint_node(&motion.joints, joint, first)));
        let inverse: Vec<f32> = motion.joints.iter().flat_map(inverse_bind).collect();
        let inverse = self.accessor(bytemuck::cast_slice(&inverse), None, FLOAT, motion.joints.len(), "MAT4");
        let joints: Vec<usize> = (first..nodes.len()).collect();
        let skins = json!([{ "name": "Tower", "inverseBindMatrices": inverse, "joints": joints }]);
        let clips = motion.clips.iter().map(|clip| self.clip(clip, first)).collect();
        [skins, Value::Array(clips)]
    }

    fn skin_attributes(&mut self, motion: &Motion, mesh: &mut Value) {
        let (joints, weights) = (&motion.skin.joints, &motion.skin.weights);
        let target = Some(ARRAY_BUFFER);
        let joints = self.accessor(bytemuck::cast_slice(joints), target, UNSIGNED_SHORT, joints.len(), "VEC4");
        let weights = self.accessor(bytemuck::cast_slice(weights), target, FLOAT, weights.len(), "VEC4");
        let attributes = &mut mesh["primitives"][0]["attributes"];
        (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
    }

    fn morph_target(&mut self, motion: &Motion, mesh: &mut Value) {
        let position = self.positions(&motion.morph.positions);
        let normals = &motion.morph.normals;
        let normal = self.accessor(bytemuck::cast_slice(normals), Some(ARRAY_BUFFER), FLOAT, normals.len(), "VEC3");
        mesh["primitives"][0]["targets"] = json!([{ "POSITION": position, "NORMAL": normal }]);
        mesh["weights"] = json!([0.0]);
    }

    fn clip(&mut self, clip: &Clip, first_joint: usize) -> Value {
        let samplers: Vec<Value> = clip.channels.iter().map(|channel| self.sampler(channel)).collect();
        let channel = |(sampler, channel): (usize, &Channel)| {
            let node = match channel.of {
                Moved::Joint(joint) => first_joint + joint,
                Moved::Node(node) => node,
            };
            json!({ "sampler": sampler, "target": { "node": node, "path": channel.path } })
        };
        let channels: Vec<Value> = clip.channels.iter().enumerate().map(channel).collect();
        json!({ "name": clip.name, "channels": channels, "samplers": samplers })
    }

    fn sampler(&mut self, channel: &Channel) -> Value {
        let (kind, width) = match channel.path {
            "rotation" => ("VEC4", 4),
            "weights" => ("SCALAR", 1),
            _ => ("VEC3", 3),
        };
        let times = &channel.times;
        let input = self.accessor(bytemuck::cast_slice(times), None, FLOAT, times.len(), "SCALAR");
        let [low, high] = [times.first(), times.last()].map(|time| json!([time]));
        (self.accessors[input]["min"], self.accessors[input]["max"]) = (low, high);
        let count = channel.values.len() / width;
        let output = self.accessor(bytemuck::cast_slice(&channel.values), None, FLOAT, count, kind);
        json!({ "input": input, "output": output, "interpolation": channel.interpolation })
    }

    /// An accessor of positions, with their bounds.
    pub fn positions(&mut self, positions: &[glam::Vec3]) -> usize {
        let bytes = bytemuck::cast_slice(positions);
        let accessor = self.accessor(bytes, Some(ARRAY_BUFFER), FLOAT, positions.len(), "VEC3");
        let [low, high] = bounds(positions);
        (self.accessors[accessor]["min"], self.accessors[accessor]["max"]) = (json!(low), json!(high));
        accessor
    }
}

fn joint_node(joints: &[Joint], index: usize, first: usize) -> Value {
    let Joint { name, parent, position } = &joints[index];
    let from = parent.map_or(glam::Vec3::ZERO, |parent| joints[parent].position);
    let children: Vec<usize> =
        (0..joints.len()).filter(|&j| joints[j].parent == Some(index)).map(|j| first + j).collect();
    let mut node = json!({ "name": name, "translation": (*position - from).to_array() });
    if !children.is_empty() {
        node["children"] = json!(children);
    }
    node
}

/// Matrix from the mesh to a joint without rotation.
fn inverse_bind(joint: &Joint) -> [f32; 16] {
    glam::Mat4::from_translation(-joint.position).to_cols_array()
}
