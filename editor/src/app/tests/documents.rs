//! Documents are opened, saved and found again, and left only after a question.

use super::*;
use crate::actions::{BakeAction, ExportAction, FileAction, LightAction, MaterialAction};
use lapidary_interchange::image;

#[test]
fn what_was_edited_is_undone_saved_and_found_again() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    let before = window.roughness();
    window.type_roughness("0.25");
    assert_eq!(window.roughness(), 0.25);
    window.perform(Action::Undo);
    assert_eq!(window.roughness(), before);
    assert!(!window.0.state().work.is_modified());
    window.perform(Action::Redo);
    window.perform(Action::File(FileAction::SaveAs(Some(place.path("look.lapidary")))));
    assert!(!window.0.state().work.is_modified() && window.has_said("Saved"));
    let mut again = place.window();
    again.open(&place.path("look.lapidary"));
    assert_eq!(again.roughness(), 0.25);
    assert_eq!(again.0.state().work.title(), "look.lapidary");
    again.wait("a picture", |s| s.picture.shown().is_some());
    assert_eq!(again.0.state().recent.entries().len(), 2);
}

#[test]
fn nothing_is_written_over_what_the_document_is_made_of() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    let session = place.path("look.lapidary");
    window.perform(Action::File(FileAction::SaveAs(Some(session.clone()))));
    let used = ["scene.obj", "scene.cuts", "look.lapidary"].map(|name| place.path(name));
    let contents = || used.clone().map(|file| std::fs::read(file).unwrap());
    let before = contents();
    window.type_roughness("0.25");
    for file in &used {
        let path = || Some(file.clone());
        for action in [
            Action::Material(MaterialAction::Save { material: 0, path: path() }),
            Action::Light(LightAction::Save(path())),
            Action::Export(ExportAction::Picture(path())),
            Action::Export(ExportAction::Layers(path())),
        ] {
            window.perform(action);
            let text = format!("written over an input; choose another name ({})", file.display());
            assert!(window.has_said(&text), "{}", file.display());
            assert!(!window.0.state().exporting.is_running() && window.0.state().picture.exports.is_empty());
        }
    }
    for file in &used[..2] {
        window.perform(Action::File(FileAction::SaveAs(Some(file.clone()))));
        assert!(window.0.state().work.is_modified() && window.0.state().work.title() == "look.lapidary");
    }
    assert_eq!(contents(), before);
    window.perform(Action::File(FileAction::Save));
    assert!(!window.0.state().work.is_modified(), "its own session is written again");
    assert!(std::fs::read_to_string(session).unwrap().contains("0.25"));
}

#[test]
fn a_bake_over_something_else_than_a_file_does_not_start() {
    let place = Place::new();
    std::fs::create_dir(place.path("scene.cuts")).unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.perform(Action::Bake(BakeAction::Begin { resume: false }));
    assert!(window.has_said("is a folder") && window.0.state().baking.run.is_none());
}

#[test]
fn changes_are_asked_about_before_they_are_lost() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.perform(Action::Quit);
    assert!(window.0.state().questions.may_close, "there is nothing to lose");
    window.0.state_mut().questions.may_close = false;
    window.type_roughness("0.1");
    window.perform(Action::File(FileAction::Open(Some(place.path("scene.cuts")))));
    window.wait("the question", |s| !s.questions.waiting.is_empty());
    assert!(window.shows("Save the changes?"));
    window.click("Cancel");
    assert!(!window.shows("Save the changes?") && window.0.state().opening.is_none());
    assert_eq!(window.roughness(), 0.1);
    window.perform(Action::Quit);
    assert!(!window.0.state().questions.may_close);
    window.click("Discard");
    assert!(window.0.state().questions.may_close);
}

#[test]
fn changes_are_not_asked_about_before_there_is_a_document_to_take_their_place() {
    let place = Place::new();
    place.bake();
    image::write(&lapidary_core::image::Image::filled([3, 3], glam::Vec3::X), &place.path("red.png")).unwrap();
    std::fs::write(place.path("broken.gltf"), b"{").unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.type_roughness("0.1");
    for (file, said) in
        [("red.png", "a picture, not a scene"), ("broken.gltf", "broken.gltf"), ("gone.obj", "gone.obj")]
    {
        window.perform(Action::File(FileAction::Open(Some(place.path(file)))));
        window.wait("the answer", |s| s.opening.is_none());
        assert!(window.has_said(said) && window.0.state().questions.waiting.is_empty(), "{file}");
    }
    window.perform(Action::File(FileAction::Open(Some(place.path("scene.cuts")))));
    window.wait("the question", |s| !s.questions.waiting.is_empty());
    window.click("Discard");
    assert!(!window.0.state().work.is_modified() && window.0.state().work.title() == "scene.cuts");
}

#[test]
fn saving_before_leaving_goes_on_with_what_was_asked_for() {
    let place = Place::new();
    place.bake();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    window.perform(Action::File(FileAction::SaveAs(Some(place.path("look.lapidary")))));
    window.type_roughness("0.1");
    window.perform(Action::Quit);
    window.click("Save");
    window.wait("the end", |s| s.questions.may_close);
    assert!(std::fs::read_to_string(place.path("look.lapidary")).unwrap().contains("0.1"));
}

#[test]
fn a_foreign_file_is_refused_with_what_can_be_opened() {
    let place = Place::new();
    std::fs::write(place.path("notes.docx"), b"PK").unwrap();
    let mut window = place.window();
    window.drop_file(place.path("notes.docx"));
    assert!(window.has_said(".gltf") && window.has_said("notes.docx"));
    assert!(window.0.state().opening.is_none());
    window.drop_file(place.path("scene.obj"));
    window.wait("the scene", |s| s.work.scene.source.is_some());
}

#[test]
fn a_bake_of_another_version_is_not_shown_until_it_is_asked_for() {
    let place = Place::new();
    place.bake();
    std::fs::write(place.path("scene.obj"), SCENE.replace("0 0.6 0", "0 0.9 0")).unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    assert!(window.shows("has changed") && window.0.state().work.scene.shown().is_none());
    window.click("Show anyway");
    window.wait("a picture", |s| s.picture.shown().is_some());
    assert!(!window.shows("has changed") && window.0.state().work.scene.is_stale());
}

#[test]
fn a_scene_without_a_bake_is_baked_from_the_notice() {
    let place = Place::new();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    assert!(window.shows("is not baked yet"));
    window.0.state_mut().work.document.bake = few_lights();
    window.click("Bake now");
    window.wait("the bake", |s| s.work.scene.shown().is_some() && s.baking.progress().is_none());
    assert!(place.path("scene.cuts").is_file() && window.has_said("Baked"));
    assert_eq!(window.0.state().work.document.dataset, Some(place.path("scene.cuts")));
}

/// A scene in a folder of its own, whose texture is above that.
fn with_a_texture_outside(place: &Place) -> PathBuf {
    std::fs::create_dir(place.path("inner")).unwrap();
    image::write(&lapidary_core::image::Image::filled([3, 3], glam::Vec3::X), &place.path("red.png")).unwrap();
    std::fs::write(place.path("inner/a.mtl"), "newmtl m\nmap_Kd ../red.png\n").unwrap();
    std::fs::write(place.path("inner/a.obj"), format!("mtllib a.mtl\nusemtl m\n{SCENE}")).unwrap();
    place.path("inner/a.obj")
}

#[test]
fn files_outside_the_folder_of_a_scene_are_read_after_a_question_that_is_asked_once() {
    let place = Place::new();
    let scene = with_a_texture_outside(&place);
    let texture = |window: &Window| window.0.state().work.document.textures[0].texture.size;
    let mut window = place.window();
    window.open(&scene);
    assert!(window.shows("Read files outside the folder?") && window.shows("../red.png"));
    assert!(window.0.state().work.scene.source.is_none(), "nothing is opened before the answer");
    window.click("Open without them");
    window.wait("the scene", |s| s.work.scene.source.is_some());
    assert_eq!(texture(&window), [8, 8], "the checkerboard");
    window.open(&scene);
    window.click("Read them");
    window.wait("the picture", |s| s.work.document.textures.first().is_some_and(|t| t.texture.size == [3, 3]));
    let mut later = place.window();
    later.open(&scene);
    assert!(!later.shows("Read files outside the folder?"), "the folder is remembered");
    assert_eq!(texture(&later), [3, 3]);
    assert!(later.has_said("were read, as was allowed"));
}

#[test]
fn pictures_outside_the_folder_of_a_material_are_read_after_a_question() {
    let place = Place::new();
    place.bake();
    with_a_texture_outside(&place);
    let json = r#"{"model": "ward", "parameters": {}, "maps": {"base_color": {"file": "../red.png"}}}"#;
    std::fs::write(place.path("inner/x.json"), json).unwrap();
    let mut window = place.window();
    window.open(&place.path("scene.obj"));
    let load = || Action::Material(MaterialAction::Load { material: 0, path: Some(place.path("inner/x.json")) });
    window.perform(load());
    window.wait("the question", |s| !s.questions.waiting.is_empty());
    assert!(window.shows("../red.png"));
    window.click("Cancel");
    assert!(window.0.state().work.document.textures.is_empty() && window.0.state().questions.waiting.is_empty());
    window.perform(load());
    window.wait("the question", |s| !s.questions.waiting.is_empty());
    window.click("Read them");
    window.wait("the map", |s| s.work.document.materials[0].maps.get("base_color").is_some());
    assert_eq!(window.0.state().work.document.textures[0].texture.size, [3, 3]);
}
