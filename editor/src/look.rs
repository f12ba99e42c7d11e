//! What renderers show of a document.

use crate::document::{Document, lights::shines};
use lapidary_core::{dataset::BakeParts, environment::Environment, scene::pose::Poses};
use lapidary_render::{Appearance, Assigned, Baked, Components, Illumination, Look, Solution, View};
use std::sync::Arc;

/// The look of a document in a picture of `size` pixels, with the materials of the triangles of its bake and poses relative to it.
pub fn look_of(
    document: &Document,
    baked: Option<&Baked>,
    environment: Arc<Environment>,
    (assigned, poses): (Assigned, Poses),
    size: [u32; 2],
) -> Look {
    let bounces = baked.map_or(BakeParts::NONE, |b| b.dataset.bounces());
    Look {
        poses,
        appearance: Appearance { assigned, ..document.appearance() },
        illumination: illumination(document, environment),
        lights: document.lights.iter().filter(|light| shines(light)).cloned().collect(),
        components: shown_components(document, baked),
        solution: Solution::closest_to(document.solution, bounces).unwrap_or_default(),
        illum_cut: document.view.illum_cut,
        tau: document.view.tau,
        sampling: document.view.sampling,
        view: view_of(document, size),
        post: document.view.post,
        backplate: None,
    }
}

/// The components that are shown. An environment that lights no surface would only mislead as a background, and a
/// reference would have a bounce that the picture cannot have.
fn shown_components(document: &Document, baked: Option<&Baked>) -> Components {
    let shown = document.components.shown();
    let Some(dataset) = baked.map(|baked| &baked.dataset) else { return shown };
    let (has_environment, has_bounces) = (dataset.settings.mode.environment(), dataset.has_bounces());
    Components { environment: shown.environment && has_environment, indirect: shown.indirect && has_bounces, ..shown }
}

/// The environment with the document's rotation and intensity.
pub fn illumination(document: &Document, environment: Arc<Environment>) -> Illumination {
    let settings = &document.environment;
    Illumination { environment, rotation: settings.rotation(), intensity: settings.intensity, sun: settings.suns() }
}

/// The view of a document in a picture of `size` pixels.
pub fn view_of(document: &Document, size: [u32; 2]) -> View {
    let view = &document.view;
    View {
        aa: view.aa.max(document.camera.lens.least_samples()),
        background: view.background(),
        ground: document.bake.ground,
        mirrors: view.mirrors,
        mode: view.mode,
        basis: view.basis,
        wireframe: view.wireframe,
        ..View::new(document.camera.clone(), size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{cut::packed::PackedCuts, dataset::BakeParts, sources::IndirectBake, test_scenes};

    #[test]
    fn light_that_was_not_baked_is_not_shown() {
        let document = Document::empty();
        let mut dataset = test_scenes::dataset(&["a"], &[]);
        let shown = shown_components(&document, Some(&dataset.clone().into()));
        assert_eq!(shown, Components { indirect: false, ..Components::ALL }, "no bounces were baked");
        dataset.settings.mode = BakeParts::INDIRECT;
        let shown = shown_components(&document, Some(&dataset.clone().into()));
        assert_eq!(shown, Components { direct: true, ..Components::NONE });
        let [cuts, environment_cuts] = [PackedCuts::default(), PackedCuts::default()];
        dataset.indirect = Some(IndirectBake { sources: Vec::new(), cuts, environment_cuts });
        let shown = shown_components(&document, Some(&dataset.into()));
        assert_eq!(shown, Components { environment: false, ..Components::ALL }, "negative control: bounces were");
        assert_eq!(shown_components(&document, None), Components::ALL);
    }
}
