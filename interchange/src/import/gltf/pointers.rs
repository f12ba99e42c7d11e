//! Animation channels that move no node, which extensions allow: KHR_animation_pointer moves materials, lights and
//! cameras. The `gltf` crate refuses the whole file, so they are removed before it parses one.

use serde_json::Value;

/// The extension with such channels.
pub(super) const EXTENSION: &str = "KHR_animation_pointer";

/// Removes the channels. Returns the animations that had some.
pub(super) fn remove(json: &mut Value) -> Vec<usize> {
    let has_node = |channel: &Value| channel.get("target").is_none_or(|target| target.get("node").is_some());
    let animations = json.get_mut("animations").and_then(Value::as_array_mut);
    let mut pointing = Vec::new();
    for (index, animation) in animations.into_iter().flatten().enumerate() {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { continue };
        let count = channels.len();
        channels.retain(has_node);
        if channels.len() < count {
            pointing.push(index);
        }
    }
    pointing
}
