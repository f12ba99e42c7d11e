//! Sequences and layered pictures from the window: described in the dialog, made on a worker, canceled.

use super::{Place, Window};
use crate::{
    actions::{Action, CameraAction, ExportAction},
    document::{BackgroundKind, Edit, ViewSettings},
};
use egui_kittest::kittest::Queryable;
use lapidary_interchange::image;
use std::path::Path;

fn opened(place: &Place) -> Window {
    place.bake();
    let mut window = place.window_of(egui::vec2(1100.0, 860.0));
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    window
}

/// Replaces the text of a field.
pub fn fill(window: &mut Window, field: &str, text: &str) {
    window.click(field);
    window.0.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.0.run_steps(2);
    window.0.get_by_label(field).type_text(text);
    window.0.run_steps(2);
    window.0.key_press(egui::Key::Enter);
    window.0.run_steps(3);
}

fn describe(window: &mut Window, folder: &Path, frames: &str) {
    window.click_containing("File");
    window.click("Export sequence...");
    fill(window, "Frame count", frames);
    fill(window, "Frame width", "24");
    fill(window, "Frame height", "16");
    fill(window, "Frame samples", "1");
    fill(window, "Folder of the frames", &folder.display().to_string());
}

fn is_idle(window: &mut Window) {
    window.wait("the end of the export", |s| !s.exporting.is_running());
}

#[test]
fn a_turntable_is_described_and_written_with_its_sheet() {
    let place = Place::new();
    let mut window = opened(&place);
    let folder = place.path("turn");
    describe(&mut window, &folder, "3");
    assert!(window.shows("3 frames of 24 x 16 pixels"));
    window.click("Export");
    assert!(!window.shows("Export a sequence"), "the dialog is closed");
    is_idle(&mut window);
    assert!(window.has_said("Sequence written: 3 frames"));
    let read = |name: &str| image::read(&folder.join(name)).unwrap();
    assert_eq!(read("frame.0001.png").size, [24, 16]);
    assert_ne!(read("frame.0001.png"), read("frame.0002.png"));
    assert!(read("contact-sheet.png").size[0] > 2 * 24);
    assert!(folder.join("frame.json").is_file());
    let dialog_again = |window: &mut Window| describe(window, &folder, "3");
    dialog_again(&mut window);
    window.click("Export");
    assert!(window.shows("3 of the 3 frames are there"), "the dialog says why it does not begin");
    window.click("Replace");
    window.click("Export");
    is_idle(&mut window);
}

#[test]
fn a_wrong_description_is_told_in_the_dialog_and_nothing_is_made() {
    let place = Place::new();
    let mut window = opened(&place);
    let folder = place.path("none");
    describe(&mut window, &folder, "2");
    fill(&mut window, "Name of the frames", "frame");
    window.click("Export");
    assert!(window.shows("####") && !folder.exists());
    window.0.key_press(egui::Key::Escape);
    window.0.run_steps(3);
    assert!(!window.shows("Export a sequence"));
}

#[test]
fn an_export_is_cancelled_from_the_status_line_and_leaves_whole_frames() {
    let place = Place::new();
    let mut window = opened(&place);
    let folder = place.path("long");
    describe(&mut window, &folder, "400");
    fill(&mut window, "Frame samples", "16");
    window.click("Export");
    let first = folder.join("frame.0001.png");
    window.wait("a frame", |_| first.is_file());
    assert!(window.shows("Exporting"), "the status line says how far it is");
    window.click("Cancel");
    is_idle(&mut window);
    assert!(window.has_said("Export cancelled"));
    let frames: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|f| f.unwrap().path()).collect();
    let frames: Vec<_> = frames.iter().filter(|f| f.extension().is_some_and(|e| e == "png")).collect();
    assert!((1..400).contains(&frames.len()), "{}", frames.len());
    assert!(frames.iter().all(|frame| image::read(frame).is_ok()));
}

#[test]
fn the_picture_is_written_with_its_layers_and_is_that_of_the_window() {
    let place = Place::new();
    let mut window = opened(&place);
    let view = ViewSettings { aa: 1, ..window.0.state().work.document.view.clone() };
    window.perform(Action::Edit { edit: Edit::View(view), label: "Samples" });
    let (layers, plain) = (place.path("layers.exr"), place.path("plain.exr"));
    window.perform(Action::Export(ExportAction::Layers(Some(layers.clone()))));
    assert!(window.0.state().exporting.is_running());
    is_idle(&mut window);
    assert!(window.has_said("layers written"));
    window.perform(Action::Export(ExportAction::Picture(Some(plain.clone()))));
    window.wait("the file", |_| plain.is_file());
    let (beauty, plain) = (image::read(&layers).unwrap(), image::read(&plain).unwrap());
    assert_eq!(beauty, plain);
    let environment = image::read_layer(&layers, "environment").unwrap();
    assert_eq!(environment, beauty, "there is no other light");
    assert_ne!(image::read_layer(&layers, "normal").unwrap(), beauty, "negative control");
    assert!(image::read_layer(&layers, "indirect").is_err(), "no bounced light was baked");
}

#[test]
fn without_a_scene_there_is_nothing_to_export() {
    let place = Place::new();
    let mut window = place.window();
    window.perform(Action::Export(ExportAction::DescribeSequence));
    assert!(window.has_said("nothing to export"));
    window.perform(Action::Export(ExportAction::Layers(Some(place.path("a.exr")))));
    assert!(!place.path("a.exr").exists() && !window.0.state().exporting.is_running());
}

#[test]
fn a_picture_lies_behind_the_scene_in_the_window_and_in_files_and_a_bad_one_is_told() {
    let place = Place::new();
    let mut window = opened(&place);
    let red = place.path("red.png");
    image::write(&lapidary_core::image::Image::filled([8, 4], glam::Vec3::X), &red).unwrap();
    window.perform(Action::Camera(CameraAction::Backplate(Some(red.clone()))));
    window.wait("the picture", |s| s.picture.backplate.picture().is_some());
    assert_eq!(window.0.state().work.document.view.background, BackgroundKind::Picture);
    let written = place.path("out.png");
    window.perform(Action::Export(ExportAction::Picture(Some(written.clone()))));
    window.wait("the file", |s| {
        s.picture.exports.is_empty() && written.exists() && s.work.messages.any_contains("written")
    });
    let corner = |path: &Path| {
        let texture = image::read_texture(path).unwrap();
        let lapidary_core::texture::Texels::U8(texels) = texture.texels else { panic!("8 bits") };
        texels[0]
    };
    assert_eq!(corner(&written), [255, 0, 0, 255], "the scene does not reach the corner");
    window.perform(Action::Undo);
    assert_eq!(window.0.state().work.document.view.background, BackgroundKind::Environment);
    std::fs::write(&red, b"no picture").unwrap();
    window.perform(Action::Camera(CameraAction::Backplate(Some(red))));
    window.wait("the message", |s| s.work.messages.any_contains("red.png"));
    assert!(window.0.state().picture.backplate.picture().is_none(), "negative control");
}
