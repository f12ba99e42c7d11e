//! Whether a bake would give another dataset than the one there is, and why.

use super::panel::mode::name as mode_name;
use crate::{document::Document, widgets::units::grouped, workspace::Workspace};
use glam::Vec3;
use lapidary_core::{
    dataset::{BakeParts, BakeSettings, Dataset},
    ground::Ground,
    light_tree::TreeKind,
    shot::Shot,
};

/// Differences between the document's settings and those of the dataset, in sentences; empty if there are none.
/// `scene_hash_now` is the hash of the scene file in its present state, if that is known.
pub fn stale_reasons(document: &Document, dataset: &Dataset, scene_hash_now: Option<&str>) -> Vec<String> {
    let mut reasons = Vec::new();
    if scene_hash_now.is_some_and(|hash| hash != dataset.scene_hash) {
        reasons.push("The scene file changed since the bake".into());
    }
    if document.lets_through_otherwise(&dataset.scene) {
        reasons.push("Opacity of materials was edited; shadows are of those in the bake".into());
    }
    if document.poses != dataset.scene.placed_poses() {
        reasons.push("Objects were moved; shadows and bounces of what moved are a preview".into());
    }
    if document.clip_time != dataset.scene.clip_time {
        reasons.push("The animation is at another time than in the bake".into());
    }
    let (now, baked) = (described(&document.bake), described(&dataset.settings));
    let differing = now.iter().zip(&baked).filter(|(now, baked)| now != baked);
    reasons.extend(differing.map(|((name, now), (_, baked))| format!("{name}: {now} now, {baked} in the bake")));
    reasons
}

/// Differences between the bake that there is and what another would give now.
pub fn stale_now(work: &Workspace) -> Vec<String> {
    let hash = work.scene.source.as_ref().map(|source| source.hash.as_str());
    let baked = work.scene.baked.as_ref();
    baked.map_or_else(Vec::new, |baked| stale_reasons(&work.document, &baked.dataset, hash))
}

/// Name for people.
pub fn tree_name(tree: TreeKind) -> &'static str {
    match tree {
        TreeKind::Geometric => "Geometric",
        TreeKind::DataDriven => "Data-driven",
        TreeKind::Mixed => "Mixed",
    }
}

/// Which views a bake is for, with all that tells one from another.
fn described_shots(shots: &[Shot]) -> String {
    let place = |Vec3 { x, y, z }: Vec3| format!("({x}, {y}, {z})");
    let described = |Shot { camera, aspect }: &Shot| {
        let (eye, target, degrees) = (place(camera.eye), place(camera.target), camera.fov_y.to_degrees());
        let roll = if camera.up == Vec3::Y { String::new() } else { format!(", {} upward", place(camera.up)) };
        format!("from {eye} to {target}{roll} at {degrees}°, {aspect} to 1")
    };
    if shots.is_empty() { "all alike".into() } else { shots.iter().map(described).collect::<Vec<_>>().join("; ") }
}

/// All settings in words. Beta counts in a mixed tree only.
fn described(settings: &BakeSettings) -> Vec<(&'static str, String)> {
    // Destructured, so that a new setting cannot be forgotten here.
    let BakeSettings {
        lights,
        tree,
        beta,
        criterion,
        pilot_clusters,
        ground,
        max_vertices,
        even_vertices,
        shots,
        max_bytes,
        exhaustive,
        mode,
        indirect,
        meshless,
    } = settings;
    let of_sources = |text: String| if mode.sources() { text } else { "unused".into() };
    let of_bounces = |text: String| if *mode == BakeParts::ENVIRONMENT { "unused".into() } else { text };
    let of_meshless = |text: String| if mode.meshless() { text } else { "unused".into() };
    let limit = |limit: Option<u64>| limit.map_or("no limit".into(), grouped);
    let beta = if *tree == TreeKind::Mixed { beta.to_string() } else { "unused".into() };
    let max_nodes = (criterion.max_nodes < u32::MAX).then_some(u64::from(criterion.max_nodes));
    vec![
        ("Lights", grouped(*lights as u64)),
        ("Light tree", tree_name(*tree).to_lowercase()),
        ("Beta", beta),
        ("Sigma", criterion.sigma.to_string()),
        ("Largest cut", limit(max_nodes)),
        ("Total error", criterion.total_error.map_or("no limit".into(), |e| e.to_string())),
        ("Pilot clusters", grouped(*pilot_clusters as u64)),
        ("Vertices", limit(max_vertices.map(|v| v as u64))),
        // Whether it is a surface or catches shadows is not baked.
        ("Ground", if *ground == Ground::Off { "none" } else { "under the scene" }.into()),
        ("Placing", if *even_vertices { "evenly" } else { "where visibility varies" }.into()),
        ("Views", described_shots(shots)),
        ("Bytes", limit(*max_bytes)),
        ("Tracing", if *exhaustive { "every light and source" } else { "boundaries" }.into()),
        ("Bake of", mode_name(*mode).to_lowercase()),
        ("Sources", of_sources(grouped(indirect.sources as u64))),
        ("Source sigma", of_sources(indirect.criterion.sigma.to_string())),
        ("Largest solid angle", of_sources(indirect.criterion.max_solid_angle.to_string())),
        ("Source contrast", of_sources(indirect.criterion.contrast.to_string())),
        ("Levels", of_meshless(meshless.levels.to_string())),
        ("Sender levels", of_meshless(meshless.sender_levels.to_string())),
        ("Coarse radius", of_meshless(meshless.coarse_radius.map_or("found".into(), |r| r.to_string()))),
        ("Gather rays", of_meshless(meshless.rays.to_string())),
        ("Epsilon", of_meshless(meshless.epsilon.to_string())),
        ("Viewpoint", of_bounces(indirect.viewpoint.map_or("found".into(), |v| v.to_string()))),
    ]
}
