//! Settings of the draft shown during a bake, and whether it is worthwhile.

use crate::bake_parts;
use lapidary_core::dataset::BakeSettings;
use lapidary_precompute::{Preset, with_room};

/// Settings of the first bake to be shown. It has the same components and viewpoint. It is coarser than the draft preset, because
/// the user waits for it, and in nothing finer than the requested bake. Its vertices are evenly spread. The mesh has
/// `mesh_vertices`.
pub fn first_draft(wanted: &BakeSettings, mesh_vertices: usize) -> BakeSettings {
    let most = Some(with_room(15_000, mesh_vertices));
    let mut draft = BakeSettings {
        mode: wanted.mode,
        ground: wanted.ground,
        shots: wanted.shots.clone(),
        // A mesh that is not tessellated stays so in the draft.
        max_vertices: most.min(wanted.max_vertices),
        even_vertices: true,
        ..Preset::Draft.settings()
    };
    bake_parts::all().for_each(|part| part.coarsen(&mut draft, wanted));
    draft
}

/// Whether a draft finishes earlier than the bake itself.
pub fn draft_is_sooner(wanted: &BakeSettings) -> bool {
    let draft = first_draft(wanted, 0);
    wanted.mode.parts().any(|part| bake_parts::of(part).is_sooner(&draft, wanted))
}
