//! Animation channels that move no node, which extensions allow: KHR_animation_pointer moves materials, lights and
//! cameras. The `gltf` crate refuses the whole file, so they are removed before it parses one.

use crate::import::gltf::json::json_of;
use gltf::{Document, Glb, Gltf};
use serde_json::Value;

/// The extension with such channels.
pub(super) const EXTENSION: &str = "KHR_animation_pointer";

/// The file without such channels, not validated, and the indices of the animations that had some. `None` if it is
/// unreadable anyway.
pub(super) fn parse_without(bytes: &[u8]) -> Option<(Gltf, Vec<usize>)> {
    let mut json: Value = serde_json::from_slice(&json_of(bytes)).ok()?;
    let pointing = remove(&mut json);
    let document = Document::from_json_without_validation(serde_json::from_value(json).ok()?);
    let blob = Glb::from_slice(bytes).ok().and_then(|glb| glb.bin).map(std::borrow::Cow::into_owned);
    Some((Gltf { document, blob }, pointing))
}

/// Removes the channels. Returns the animations that had some.
fn remove(json: &mut Value) -> Vec<usize> {
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
