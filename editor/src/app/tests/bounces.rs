//! Edits in a room with a lamp: the bounce follows the lamp, the paint of a wall and the gloss of a floor, and the environment adds
//! to it, all without another bake.

use super::{Place, Window};
use crate::{
    actions::Action,
    app::state::EditorState,
    document::{Component, ComponentSettings, Edit},
};
use glam::Vec3;
use lapidary_core::{
    dataset::{BakeParts, BakeSettings, IndirectSettings},
    lights::Light,
    material::Material,
};
use lapidary_interchange::import::import;
use lapidary_precompute::{BakeJob, Preset, Silent, bake, resolve};
use std::path::Path;

const BOX: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/color-box/color-box.gltf");

/// The color box with few sources, in the window.
fn opened(place: &Place) -> Window {
    let normal = Preset::Draft.settings();
    let indirect = IndirectSettings { sources: 1024, ..normal.indirect };
    let settings =
        BakeSettings { mode: BakeParts::CUTS, lights: 256, pilot_clusters: 8, max_vertices: None, indirect, ..normal };
    let output = place.path("box.cuts");
    let job = BakeJob::new(resolve(settings).unwrap(), output);
    bake(import(Path::new(BOX)).unwrap().scene, &job, &Silent).unwrap();
    // A narrow window has a small picture without panels.
    let mut window = place.window_of(egui::vec2(240.0, 480.0));
    window.open(&place.path("box.cuts"));
    window
}

/// Mean color of the left and the right half of the picture, once it is finished.
fn halves(state: &EditorState) -> Option<[Vec3; 2]> {
    let shown = state.picture.shown().filter(|p| p.full_size && p.samples == p.of_samples)?;
    let width = shown.size[0] as usize;
    let mean = |right: bool| {
        let of_half = shown.pixels.iter().enumerate().filter(|(i, _)| (2 * (i % width) >= width) == right);
        let sum: Vec3 = of_half.map(|(_, p)| Vec3::new(p[0].into(), p[1].into(), p[2].into())).sum();
        sum / (shown.pixels.len() / 2) as f32
    };
    Some([false, true].map(mean))
}

/// The halves of the first finished picture that differs from `before`.
fn settled(window: &mut Window, before: Option<[Vec3; 2]>) -> [Vec3; 2] {
    window.wait("a picture of something else", |s| halves(s).is_some_and(|now| before != Some(now)));
    halves(window.0.state()).unwrap()
}

fn edit(window: &mut Window, edit: Edit) {
    window.perform(Action::Edit { edit, label: "Edit" });
    window.perform(Action::EndGesture);
}

fn edit_material(window: &mut Window, name: &str, change: impl FnOnce(&mut Material)) {
    let materials = &window.0.state().work.document.materials;
    let index = materials.iter().position(|m| m.name == name).unwrap();
    let mut material = materials[index].clone();
    change(&mut material);
    edit(window, Edit::Material { index, material: Box::new(material) });
}

#[test]
fn the_bounce_follows_lamp_paint_and_gloss_and_the_environment_adds_to_it() {
    let place = Place::new();
    let mut window = opened(&place);
    edit(&mut window, Edit::Components(ComponentSettings { solo: Some(Component::Indirect), ..Default::default() }));
    let ratio =
        |[left, right]: [Vec3; 2], of: fn(Vec3) -> f32, to: fn(Vec3) -> f32| of(left + right) / to(left + right);
    let (red, green, blue) = (|c: Vec3| c.x, |c: Vec3| c.y, |c: Vec3| c.z);
    let first = settled(&mut window, None);
    assert!(first[0].x + first[1].x > 10.0, "the bounce shows: {first:?}");

    let lamp = Light { target: Vec3::new(0.9, 0.5, 0.0), ..window.0.state().work.document.lights[0].clone() };
    edit(&mut window, Edit::Light { index: 0, light: Box::new(lamp) });
    let toward_green = settled(&mut window, Some(first));
    assert!(ratio(toward_green, green, red) > 1.05 * ratio(first, green, red), "{first:?} {toward_green:?}");
    window.perform(Action::Undo);
    assert_eq!(settled(&mut window, Some(toward_green)), first);

    edit_material(&mut window, "Red paint", |m| m.parameters.set("base_color", Vec3::new(0.05, 0.1, 0.6)));
    let blue_wall = settled(&mut window, Some(first));
    assert!(ratio(blue_wall, blue, red) > 1.2 * ratio(first, blue, red), "{first:?} {blue_wall:?}");
    // The half without the red wall changes only by the wall's bounce.
    let far = usize::from(red(first[0]) / green(first[0]) > red(first[1]) / green(first[1]));
    let (before, after) = (blue(first[far]) / red(first[far]), blue(blue_wall[far]) / red(blue_wall[far]));
    assert!(after > 1.02 * before, "{before} {after}");
    window.perform(Action::Undo);
    assert_eq!(settled(&mut window, Some(blue_wall)), first);

    edit_material(&mut window, "White paint", |m| {
        m.parameters.set("metalness", 1.0);
        m.parameters.set("roughness", 0.15);
    });
    let glossy = settled(&mut window, Some(first));
    assert!((glossy[0] - first[0]).abs().max_element() > 2.0, "{first:?} {glossy:?}");
    window.perform(Action::Undo);
    assert_eq!(settled(&mut window, Some(glossy)), first);

    let parts = |environment| Edit::Components(ComponentSettings { environment, solo: None, ..Default::default() });
    edit(&mut window, parts(false));
    let without = settled(&mut window, Some(first));
    edit(&mut window, parts(true));
    let with = settled(&mut window, Some(without));
    assert!((with[0] - without[0]).min_element() > 0.5, "{without:?} {with:?}");
}
