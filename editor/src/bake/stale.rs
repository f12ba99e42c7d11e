//! Whether another bake would give another dataset, and why.

use super::parts::described;
use crate::{document::Document, workspace::Workspace};
use lapidary_core::dataset::Dataset;

/// Differences between the settings of the document and of the dataset, in sentences; empty if there are none. `scene_hash_now` is
/// the hash of the scene file in its present state, if that is known.
pub fn stale_reasons(document: &Document, dataset: &Dataset, scene_hash_now: Option<&str>) -> Vec<String> {
    let mut reasons = Vec::new();
    if scene_hash_now.is_some_and(|hash| hash != dataset.scene_hash) {
        reasons.push("The scene file changed since the bake".into());
    }
    if document.lets_through_otherwise(&dataset.scene) {
        reasons.push("Material opacity was edited; shadows show the baked opacity".into());
    }
    if document.poses != dataset.scene.placed_poses() {
        reasons.push("Objects were moved, hidden or shown; their shadows and bounces are a preview".into());
    }
    if document.clip_time != dataset.scene.clip_time {
        reasons.push("The animation is at another time than the bake".into());
    }
    let (now, baked) = (described(&document.bake), described(&dataset.settings));
    let differing = now.iter().zip(&baked).filter(|(now, baked)| now != baked);
    reasons.extend(differing.map(|((name, now), (_, baked))| format!("{name}: {now} now, {baked} in the bake")));
    reasons
}

/// Differences between the present bake and a new one.
pub fn stale_now(work: &Workspace) -> Vec<String> {
    let hash = work.scene.source.as_ref().map(|source| source.hash.as_str());
    let baked = work.scene.baked.as_ref();
    baked.map_or_else(Vec::new, |baked| stale_reasons(&work.document, &baked.dataset, hash))
}
