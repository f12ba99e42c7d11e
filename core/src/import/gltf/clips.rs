//! Animations of a glTF file. Those that are damaged are told by their names, and the others can be played.

use super::buffers::Buffers;
use crate::animation::{
    Clip,
    clip::{Channel, Property},
    keyframes::{Interpolation, Keyframes},
    nodes::Nodes,
};
use gltf::{accessor::Dimensions, animation as file, json::validation::Checked};

/// Clips that can be played, and the names of those that cannot, with what is wrong.
#[derive(Default)]
pub(super) struct Clips {
    pub playable: Vec<Clip>,
    pub broken: Vec<(String, String)>,
}

impl Clips {
    pub fn read(gltf: &gltf::Document, nodes: &Nodes, buffers: &Buffers) -> Self {
        let mut clips = Self::default();
        for animation in gltf.animations() {
            let name = animation.name().map_or_else(|| format!("clip {}", animation.index() + 1), str::to_owned);
            match channels(gltf, &animation, nodes, buffers) {
                Ok(channels) => clips.playable.push(Clip::new(name, channels)),
                Err(reason) => clips.broken.push((name, reason)),
            }
        }
        clips
    }

    /// What is told of those that cannot be played.
    pub fn remarks(&self) -> impl Iterator<Item = String> {
        let remark = |(name, reason): &(String, String)| {
            format!("the animation \"{name}\" cannot be played: {reason}; export it again")
        };
        self.broken.iter().map(remark)
    }
}

fn channels(
    gltf: &gltf::Document,
    animation: &gltf::Animation,
    nodes: &Nodes,
    buffers: &Buffers,
) -> Result<Vec<Channel>, String> {
    let stored = &gltf.as_json().animations[animation.index()];
    let mut channels = Vec::new();
    for (index, channel) in animation.channels().enumerate() {
        // The crate does not check these, and ends the program where they are wrong.
        let target = &stored.channels[index].target;
        let node = target.node.value();
        if node >= gltf.nodes().count() || !matches!(target.path, Checked::Valid(_)) {
            return Err(format!("channel {index} moves what is not there"));
        }
        let read = read_channel(gltf, &channel, node, nodes, buffers);
        channels.extend(read.map_err(|reason| format!("channel {index}: {reason}"))?);
    }
    Ok(channels)
}

/// `None` for weights of a node without morph targets.
fn read_channel(
    gltf: &gltf::Document,
    channel: &file::Channel,
    node: usize,
    nodes: &Nodes,
    buffers: &Buffers,
) -> Result<Option<Channel>, String> {
    let (property, dimensions, width) = match channel.target().property() {
        file::Property::Translation => (Property::Translation, Dimensions::Vec3, 3),
        file::Property::Rotation => (Property::Rotation, Dimensions::Vec4, 4),
        file::Property::Scale => (Property::Scale, Dimensions::Vec3, 3),
        file::Property::MorphTargetWeights => (Property::Weights, Dimensions::Scalar, targets(gltf, node)),
    };
    if width == 0 {
        return Ok(None);
    }
    let sampler = channel.sampler();
    let interpolation = match sampler.interpolation() {
        file::Interpolation::Step => Interpolation::Step,
        file::Interpolation::Linear => Interpolation::Linear,
        file::Interpolation::CubicSpline => Interpolation::CubicSpline,
    };
    let times = keyframe_numbers(buffers, &sampler.input(), Dimensions::Scalar)?;
    let values = keyframe_numbers(buffers, &sampler.output(), dimensions)?;
    let channel = Channel { node, property, keys: Keyframes::new(times, values, width, interpolation)? };
    channel.check(nodes)?;
    Ok(Some(channel))
}

/// Numbers that a buffer holds, so that there are no more than the file is large.
fn keyframe_numbers(buffers: &Buffers, accessor: &gltf::Accessor, dimensions: Dimensions) -> Result<Vec<f32>, String> {
    if accessor.view().is_none() {
        return Err(format!("accessor {} has no data", accessor.index()));
    }
    buffers.numbers(accessor, dimensions)
}

/// Morph targets of the mesh of a node.
fn targets(gltf: &gltf::Document, node: usize) -> usize {
    let mesh = gltf.nodes().nth(node).and_then(|node| node.mesh());
    mesh.and_then(|mesh| mesh.primitives().map(|p| p.morph_targets().count()).max()).unwrap_or(0)
}
