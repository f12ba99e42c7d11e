//! Animations of a glTF file. Damaged ones are reported by name, and the others are playable.

use super::{
    super::budget::{Budget, OverBudget},
    pointers,
    scene_file::SceneFile,
};
use crate::names::listed;
use gltf::{Accessor, accessor::Dimensions, animation as file, json::validation::Checked};
use lapidary_core::animation::{
    Clip,
    clip::{Channel, Property},
    keyframes::{Interpolation, Keyframes},
};
use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

/// Peak bytes of a number of a keyframe, twice its size while the list grows.
const NUMBER: u64 = 8;

/// Playable clips, and remarks on the others.
#[derive(Default)]
pub(super) struct Clips {
    pub playable: Vec<Clip>,
    /// Names of unplayable clips, with the reasons.
    pub broken: Vec<(String, String)>,
    /// Names of clips with more than one channel for a property of a node.
    doubled: Vec<String>,
    /// Names of clips with channels that move no node.
    pointing: Vec<String>,
}

impl Clips {
    /// Reads the clips; playable ones take memory from a budget.
    pub fn read(file: &SceneFile, budget: &mut Budget) -> Self {
        let mut clips = Self::default();
        let names = file.gltf.animations().map(|animation| name(&animation)).collect();
        for (animation, name) in file.gltf.animations().zip(numbered(names)) {
            let mut reader = ChannelReader::new(file, budget);
            let read = reader.channels(&animation);
            let is_pointing = file.pointing.contains(&animation.index());
            match read {
                Ok(channels) if is_pointing && channels.is_empty() => {
                    let reason = format!("it moves no node, only what {} names", pointers::EXTENSION);
                    clips.broken.push((name, reason));
                }
                Ok(channels) => {
                    *budget = reader.budget;
                    clips.doubled.extend(reader.is_doubled.then(|| name.clone()));
                    clips.pointing.extend(is_pointing.then(|| name.clone()));
                    clips.playable.push(Clip::new(name, channels));
                }
                Err(reason) => clips.broken.push((name, reason)),
            }
        }
        clips
    }

    /// Remarks on the unplayable clips.
    pub fn remarks_of_broken(&self) -> impl Iterator<Item = String> {
        let remark = |(name, reason): &(String, String)| {
            format!("the animation \"{name}\" cannot be played: {reason}; export it again")
        };
        self.broken.iter().map(remark)
    }

    /// Remarks on the clips that play without some of their channels.
    pub fn remarks_of_channels(&self) -> impl Iterator<Item = String> {
        let doubled = "have several channels for one property of a node, of which the first plays; remove the others";
        let pointing =
            format!("have channels that move no node ({}), which were left out; the others play", pointers::EXTENSION);
        let kinds = [(&self.doubled, doubled.to_owned()), (&self.pointing, pointing)];
        let told = kinds.into_iter().filter(|(names, _)| !names.is_empty());
        told.map(|(names, text)| format!("the animations {} {text}", listed(names)))
    }
}

/// Name from the file, or derived from its position there.
fn name(animation: &gltf::Animation) -> String {
    animation.name().map_or_else(|| format!("clip {}", animation.index() + 1), str::to_owned)
}

/// Makes names unique by appending numbers to repeated ones.
fn numbered(names: Vec<String>) -> Vec<String> {
    let mut taken: HashSet<String> = names.iter().cloned().collect();
    let mut counts: HashMap<String, usize> = HashMap::new();
    let mut number = |name: String| {
        let count = counts.entry(name.clone()).or_insert(0);
        *count += 1;
        if *count == 1 {
            return name;
        }
        while !taken.insert(format!("{name} ({count})")) {
            *count += 1;
        }
        format!("{name} ({count})")
    };
    names.into_iter().map(&mut number).collect()
}

/// Reads the channels of one animation.
struct ChannelReader<'a> {
    file: &'a SceneFile,
    budget: Budget,
    /// Samplers by index, and the property and number of values they are for.
    samplers: HashMap<(usize, Property, usize), Arc<Keyframes>>,
    /// Properties of nodes with a channel.
    moved: HashSet<(usize, Property)>,
    /// Whether a property has more than one.
    is_doubled: bool,
}

impl<'a> ChannelReader<'a> {
    fn new(file: &'a SceneFile, budget: &Budget) -> Self {
        let (samplers, moved) = (HashMap::new(), HashSet::new());
        Self { file, budget: budget.clone(), samplers, moved, is_doubled: false }
    }

    fn channels(&mut self, animation: &gltf::Animation) -> Result<Vec<Channel>, String> {
        let gltf = &self.file.gltf;
        let stored = &gltf.as_json().animations[animation.index()];
        let mut channels = Vec::new();
        for (index, channel) in animation.channels().enumerate() {
            // The crate does not check these indices, and panics if they are invalid.
            let target = &stored.channels[index].target;
            let node = target.node.value();
            if node >= gltf.nodes().count() || !matches!(target.path, Checked::Valid(_)) {
                return Err(format!("channel {index} has a missing node or an unknown property"));
            }
            channels.extend(self.channel(&channel, node).map_err(|reason| format!("channel {index}: {reason}"))?);
        }
        Ok(channels)
    }

    /// `None` for weights of a node without morph targets, and for a property that another channel moves.
    fn channel(&mut self, channel: &file::Channel, node: usize) -> Result<Option<Channel>, String> {
        let nodes = &self.file.nodes;
        let (property, width) = match channel.target().property() {
            file::Property::Translation => (Property::Translation, 3),
            file::Property::Rotation => (Property::Rotation, 4),
            file::Property::Scale => (Property::Scale, 3),
            file::Property::MorphTargetWeights => (Property::Weights, nodes.get(node).weights.len()),
        };
        if !self.moved.insert((node, property)) {
            self.is_doubled = true;
            return Ok(None);
        }
        if width == 0 {
            return Ok(None);
        }
        let channel = Channel { node, property, keys: self.keyframes(&channel.sampler(), property, width)? };
        channel.check(nodes)?;
        Ok(Some(channel))
    }

    /// Reads a sampler on first use.
    fn keyframes(
        &mut self,
        sampler: &file::Sampler,
        property: Property,
        width: usize,
    ) -> Result<Arc<Keyframes>, String> {
        let key = (sampler.index(), property, width);
        if let Some(known) = self.samplers.get(&key) {
            return Ok(known.clone());
        }
        let dimensions = match property {
            Property::Translation | Property::Scale => Dimensions::Vec3,
            Property::Rotation => Dimensions::Vec4,
            Property::Weights => Dimensions::Scalar,
        };
        let interpolation = match sampler.interpolation() {
            file::Interpolation::Step => Interpolation::Step,
            file::Interpolation::Linear => Interpolation::Linear,
            file::Interpolation::CubicSpline => Interpolation::CubicSpline,
        };
        let numbers = [(sampler.input(), Dimensions::Scalar), (sampler.output(), dimensions)];
        let count = |(accessor, dimensions): &(Accessor, Dimensions)| {
            (accessor.count() as u64).saturating_mul(dimensions.multiplicity() as u64)
        };
        let count = numbers.iter().map(count).fold(0, u64::saturating_add);
        self.budget.take(count.saturating_mul(NUMBER)).map_err(no_room)?;
        let [times, values] = numbers.map(|(accessor, dimensions)| self.file.buffers.numbers(&accessor, dimensions));
        let keys = Arc::new(Keyframes::new(times?, values?, width, interpolation)?);
        self.samplers.insert(key, keys.clone());
        Ok(keys)
    }
}

fn no_room(over: OverBudget) -> String {
    let [needed, available] = over.megabytes();
    format!("with its keyframes the file takes about {needed} MB of memory, but {available} MB are free; reduce them")
}
