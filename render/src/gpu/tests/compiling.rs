//! Passes that are compiled on other threads: a picture is ready once it has all, and errors are told by the name of a pass.

use super::twin::{Rig, agrees, appearance, difference, parameters, scene, view};
use crate::{Backend, BackendError, BrdfSampling, ViewMode, gpu::ShaderSource};
use lapidary_core::material::{BrdfModel, MaterialMaps};
use std::{
    thread::sleep,
    time::{Duration, Instant},
};

/// Waits for the compiler as the window does.
fn ready(rig: &mut Rig) -> Result<(), BackendError> {
    let start = Instant::now();
    while !rig.gpu.is_ready()? {
        assert!(start.elapsed() < Duration::from_secs(120), "it takes for ever");
        sleep(Duration::from_millis(2));
    }
    Ok(())
}

fn compiled(rig: &Rig) -> Vec<&'static str> {
    let mut labels: Vec<_> = rig.gpu.compile_times().into_iter().map(|(label, _)| label).collect();
    labels.sort_unstable();
    labels
}

/// Texts that no other test has compiled on the same device.
fn unlike_others(text: &str) -> String {
    format!("{text}\n// Of one test.\n")
}

#[test]
fn a_picture_is_ready_once_its_passes_are_compiled_and_edits_take_over_what_they_can() {
    let Some(mut rig) = Rig::with(&ShaderSource::Changed(unlike_others), scene(), 64) else { return };
    let dataset = rig.renderer.dataset().clone();
    let view = view(ViewMode::Shaded);
    let look = |model| appearance(&dataset, model, parameters(0.5, 0.0), MaterialMaps::default());
    rig.look(look(BrdfModel::Ggx));
    assert!(compiled(&rig).is_empty(), "nothing is compiled before a picture needs it");
    rig.gpu.begin(&view, BrdfSampling::Refine).unwrap();
    ready(&mut rig).unwrap();
    let of_first = compiled(&rig);
    for needed in ["visibility_pass", "surface_pass", "merge_pass", "sketch_pass", "history_pass", "display_pass"] {
        assert!(of_first.contains(&needed), "{needed}: {of_first:?}");
    }
    assert!(!of_first.contains(&"direct_pass"), "negative control: no lamp shines, {of_first:?}");
    let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
    assert!(agrees(&gpu, &cpu), "{:?}", difference(&gpu, &cpu));
    assert_eq!(compiled(&rig), of_first, "the picture needed nothing else");
    rig.look(look(BrdfModel::Ward));
    let kept = compiled(&rig);
    assert!(kept.contains(&"visibility_pass") && kept.contains(&"display_pass"), "no model is in them: {kept:?}");
    assert!(!kept.contains(&"merge_pass"), "negative control: {kept:?}");
    let [gpu, cpu] = rig.both(&view, BrdfSampling::Refine);
    assert!(agrees(&gpu, &cpu), "without a wait: {:?}", difference(&gpu, &cpu));
}

/// A merge that calls what is not there.
fn broken(text: &str) -> String {
    text.replace("shaded = merge_cuts(texel, point);", "shaded = merge_cats(texel, point);")
}

#[test]
fn a_pass_that_does_not_compile_is_told_by_its_name() {
    let Some(mut rig) = Rig::with(&ShaderSource::Changed(broken), scene(), 64) else { return };
    rig.gpu.begin(&view(ViewMode::Shaded), BrdfSampling::Refine).unwrap();
    let told = |result: Result<(), BackendError>| match result {
        Err(BackendError::Driver(text)) => text.contains("merge_pass") && text.contains("merge_cats"),
        _ => false,
    };
    assert!(told(ready(&mut rig)));
    assert!(told(rig.gpu.render_rows(0, 0..4)), "to who does not ask, too");
}
