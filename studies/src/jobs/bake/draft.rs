//! The draft that is shown while a bake goes on: what it is baked with, and whether it is ready sooner.

use lapidary_core::{
    cut::{CutCriterion, SourceCriterion},
    dataset::{BakeSettings, IndirectSettings, MeshlessSettings},
};
use lapidary_precompute::{Preset, with_room};

/// Settings of the first bake that is shown. It has the same components and viewpoint, is coarser than a draft, because
/// the user waits for it, and in nothing finer than the bake asked for. What is sharp in the light of an environment are suns,
/// which have shadows without a bake; for the rest few lights and evenly spread vertices do. The mesh has `mesh_vertices`.
pub fn first_draft(wanted: &BakeSettings, mesh_vertices: usize) -> BakeSettings {
    let draft = Preset::Draft.settings();
    let lights = (draft.lights / 16).min(wanted.lights);
    // A quarter of the lights at half the sigma is the same error in solid angle.
    let as_fine_as = |other: &BakeSettings| other.criterion.sigma * (lights as f32 / other.lights as f32).sqrt();
    let sigma = as_fine_as(&draft).max(as_fine_as(wanted));
    let criterion = CutCriterion { sigma, max_nodes: wanted.criterion.max_nodes, ..draft.criterion };
    let most = Some(with_room(15_000, mesh_vertices));
    // A mesh that is to stay as it is does so in the draft.
    let max_vertices = most.min(wanted.max_vertices);
    let (indirect, meshless) = (draft_of_sources(&wanted.indirect), draft_of_basis(&wanted.meshless));
    let pilot_clusters = wanted.pilot_clusters.min(64);
    BakeSettings {
        mode: wanted.mode,
        ground: wanted.ground,
        shots: wanted.shots.clone(),
        lights,
        pilot_clusters,
        criterion,
        max_vertices,
        even_vertices: true,
        indirect,
        meshless,
        ..draft
    }
}

fn draft_of_sources(wanted: &IndirectSettings) -> IndirectSettings {
    let draft = Preset::Draft.settings().indirect;
    let sources = (draft.sources / 4).min(wanted.sources);
    let sigma = draft.criterion.sigma.max(wanted.criterion.sigma * (sources as f32 / wanted.sources as f32).sqrt());
    IndirectSettings { sources, criterion: SourceCriterion { sigma, ..draft.criterion }, viewpoint: wanted.viewpoint }
}

fn draft_of_basis(wanted: &MeshlessSettings) -> MeshlessSettings {
    let (levels, sender_levels) = (wanted.levels.min(3), wanted.sender_levels.min(3));
    let (rays, epsilon) = (wanted.rays.min(128), wanted.epsilon.max(MeshlessSettings::default().epsilon));
    MeshlessSettings { levels, sender_levels, rays, epsilon, coarse_radius: wanted.coarse_radius }
}

/// Whether a draft is ready sooner than the bake itself.
pub fn draft_is_sooner(wanted: &BakeSettings) -> bool {
    let (draft, mode) = (first_draft(wanted, 0), wanted.mode);
    let (few, many) = (draft.meshless, wanted.meshless);
    (mode.environment() && draft.lights < wanted.lights)
        || (mode.sources() && draft.indirect.sources < wanted.indirect.sources)
        || (mode.meshless() && (few.levels < many.levels || few.rays < many.rays))
}
