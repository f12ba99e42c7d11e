//! BRDFs that users write: their sliders, and changes of their files.

use super::*;
use lapidary_core::{brdf::BrdfModel, material::Material};

/// A BRDF with one parameter.
fn text(name: &str, body: &str) -> String {
    format!(
        "// @parameter {name} | Sheen | number | 0.5 | 0..1 | | How much.\n\
         fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {{\n    {body}\n}}\n"
    )
}

fn material(window: &Window) -> &Material {
    &window.0.state().work.document.materials[0]
}

#[test]
fn a_written_brdf_has_its_sliders_follows_its_file_and_survives_mistakes() {
    let place = Place::new();
    place.bake();
    let path = place.path("mine.wgsl");
    std::fs::write(&path, text("sheen_of_mine", "return vec3(0.2 * p.sheen_of_mine);")).unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.0.state_mut().work.selection.material = Some(0);
    window.drop_file(path.clone());
    window.wait("the BRDF", |s| s.work.document.materials[0].model == BrdfModel::Wgsl);
    window.wait("the watch", |s| s.watcher.watched.contains(&path));
    assert!(window.shows("Sheen") && window.shows("mine.wgsl"));
    let before = material(&window).clone();
    let spoil = || std::fs::write(&path, text("sheen_of_mine", "return vec3(0.2 * q);")).unwrap();
    window.wait_for_watch("the message", spoil, |s| s.work.messages.any_contains("line 3: "));
    assert!(window.has_said("`return vec3(0.2 * q);`") && window.has_said("mine.wgsl"));
    assert_eq!(*material(&window), before, "the last good version stays");
    let mend = || std::fs::write(&path, text("sheen_of_mine", "return vec3(0.1);")).unwrap();
    window.wait_for_watch("the new BRDF", mend, |s| s.work.document.materials[0].file != before.file);
    assert!(material(&window).plain_brdf().as_brdf().albedo().x > 0.3);
    window.perform(Action::Undo);
    assert_eq!(material(&window).model, BrdfModel::default(), "loading it was a step");
}
