//! A clip: an animation of a glTF file, which moves nodes and changes the weights of morph targets over time.

use super::{
    keyframes::Keyframes,
    nodes::{NodeState, Nodes},
};
use glam::Vec3;
use std::sync::Arc;

/// The smallest size of a node along an axis, relative to its mesh: a scale of zero would leave no normals.
pub const LEAST_SCALE: f32 = 1e-4;

/// The property of its node that a channel changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Property {
    /// Position within its parent.
    Translation,
    /// Rotation.
    Rotation,
    /// Scale along its own axes.
    Scale,
    /// Weights of the morph targets of its mesh.
    Weights,
}

/// One property of one node over time.
#[derive(Clone, Debug)]
pub struct Channel {
    /// The node, by index.
    pub node: usize,
    /// The changed property.
    pub property: Property,
    /// Its keyframes; channels may share them.
    pub keys: Arc<Keyframes>,
}

impl Channel {
    /// Checks that values are valid for the nodes.
    ///
    /// # Errors
    /// A description of the problem: a scale that turns a mesh inside out.
    pub fn check(&self, nodes: &Nodes) -> Result<(), String> {
        let sides = side(nodes.get(self.node).at_rest.scale);
        let turns_over = |value: &[f32]| (Vec3::from_slice(value) * sides).min_element() < 0.0;
        if self.property == Property::Scale && self.keys.values().any(turns_over) {
            return Err("a scale changes its sign, which turns surfaces inside out; keep scales above 0".into());
        }
        Ok(())
    }

    fn apply(&self, seconds: f32, nodes: &Nodes, state: &mut NodeState) {
        let transform = &mut state.transforms[self.node];
        match self.property {
            Property::Translation => transform.translation = Vec3::from_slice(&self.keys.sample(seconds)),
            Property::Rotation => transform.rotation = self.keys.sample_rotation(seconds),
            Property::Scale => {
                let sides = side(nodes.get(self.node).at_rest.scale);
                let size = (Vec3::from_slice(&self.keys.sample(seconds)) * sides).max(Vec3::splat(LEAST_SCALE));
                transform.scale = size * sides;
            }
            Property::Weights => state.weights[self.node] = self.keys.sample(seconds),
        }
    }
}

/// 1 or -1 along each axis.
fn side(scale: Vec3) -> Vec3 {
    scale.map(|s| if s < 0.0 { -1.0 } else { 1.0 })
}

/// Playback beyond the end of a clip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Playback {
    /// The last pose stays.
    #[default]
    Once,
    /// The clip restarts.
    Loop,
}

/// A named animation.
#[derive(Clone, Debug)]
pub struct Clip {
    /// Name from the file, or derived from its position there. It is unique in the file: equal names are numbered.
    pub name: String,
    channels: Vec<Channel>,
}

impl Clip {
    /// Creates a clip from checked channels.
    pub fn new(name: String, channels: Vec<Channel>) -> Self {
        Self { name, channels }
    }

    /// Duration in seconds: from 0 to its last keyframe. A clip of duration 0 is one pose.
    pub fn seconds(&self) -> f32 {
        self.channels.iter().map(|channel| channel.keys.end()).fold(0.0, f32::max)
    }

    /// Its channels.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Time within the clip at a playing time, in seconds. NaN is the beginning.
    pub fn time_at(&self, seconds: f32, playback: Playback) -> f32 {
        let length = self.seconds();
        match playback {
            _ if !(seconds.is_finite() && length > 0.0) => 0.0,
            Playback::Once => seconds.clamp(0.0, length),
            Playback::Loop => seconds.rem_euclid(length),
        }
    }

    /// State of the nodes at a time of the clip, in seconds.
    pub fn state_at(&self, seconds: f32, nodes: &Nodes) -> NodeState {
        let mut state = nodes.at_rest();
        self.channels.iter().for_each(|channel| channel.apply(seconds, nodes, &mut state));
        state
    }
}
