//! The comparison with a reference, from the key that begins it to the figures.

use super::*;
use crate::{
    actions::{CompareAction, LadderAction},
    compare::panel::{ComparisonPanel, KindChoice},
    document::Edit,
    ladder::LadderWindow,
    viewport::compare::CompareView,
};
use egui::Event;
use lapidary_core::{cut::lit::DEFAULT_TAU, image::Image};
use lapidary_interchange::image;
use lapidary_render::{BrdfSampling, compare::map::ErrorMap};
use lapidary_studies::{jobs::measure::ShownMap, ladder::Cuts};

/// A window that compares a small scene with paths, and has measured it.
fn comparing(place: &Place) -> Window {
    place.bake();
    let mut window = place.window_of(vec2(1300.0, 760.0));
    window.open(&place.path("scene.cuts"));
    window.wait("a picture", |s| s.picture.can_be_compared(&s.work));
    window.0.key_press(Key::C);
    window.0.run_steps(2);
    *panel(&mut window) =
        ComparisonPanel { open: true, kind: KindChoice::Paths, spp: 4, scale: 8, advanced: true, ..Default::default() };
    finished(&mut window);
    window
}

fn panel(window: &mut Window) -> &mut ComparisonPanel {
    &mut window.0.state_mut().comparison.panel
}

fn finished(window: &mut Window) {
    window.wait("a finished reference", |s| s.comparison.context().measured.is_some_and(|m| m.reference.finished));
}

fn rel_rmse(window: &Window) -> f64 {
    window.0.state().comparison.context().measured.unwrap().metrics.rel_rmse
}

#[test]
fn a_key_begins_the_comparison_and_its_figures_are_shown() {
    let place = Place::new();
    let mut window = comparing(&place);
    assert!(window.shows("Relative RMSE") && window.shows("Reference noise"));
    let error = rel_rmse(&window);
    assert!(error > 0.0 && error < 0.5, "{error}");
    let before = window.0.state().work.viewport_size;
    window.0.key_press(Key::C);
    window.0.run_steps(2);
    assert!(!window.shows("Relative RMSE"));
    assert!(window.0.state().work.viewport_size[1] > before[1], "the strip has gone");
    assert!(window.0.state().comparison.context().measured.is_none(), "and with it both threads");
}

#[test]
fn edits_of_light_begin_anew_and_exposure_does_not() {
    let place = Place::new();
    let mut window = comparing(&place);
    let (begun, error) = (window.0.state().comparison.begun(), rel_rmse(&window));
    let mut view = window.0.state().work.document.view.clone();
    (view.post.exposure, view.wireframe) = (1.0, true);
    window.perform(Action::Edit { edit: Edit::View(view.clone()), label: "Exposure" });
    window.0.run_steps(3);
    assert_eq!((window.0.state().comparison.begun(), rel_rmse(&window)), (begun, error));
    (view.sampling, view.illum_cut) = (BrdfSampling::Refine, 1);
    window.perform(Action::Edit { edit: Edit::View(view), label: "Light cut" });
    window.wait("figures of another picture", |s| {
        s.comparison.context().measured.is_some_and(|m| m.reference.finished && m.metrics.rel_rmse != error)
    });
    assert_eq!(window.0.state().comparison.begun(), begun + 1);
}

#[test]
fn every_view_is_shown_and_the_reference_as_long_as_its_key_is_held() {
    let place = Place::new();
    let mut window = comparing(&place);
    for (label, view) in [
        ("A", CompareView::Picture),
        ("B", CompareView::Reference),
        ("Side by side", CompareView::SideBySide),
        ("Difference", CompareView::Difference),
        ("A | B", CompareView::Swipe),
    ] {
        window.click(label);
        assert_eq!(panel(&mut window).shown_view(), view);
    }
    panel(&mut window).map = ShownMap::Predicted;
    window.wait("the predicted error", |s| {
        s.comparison.context().measured.is_some_and(|m| m.field.title == "Predicted error" && m.metrics.rmse > 0.0)
    });
    let hold = |window: &mut Window, pressed| {
        let event = Event::Key { key: Key::R, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
        window.0.input_mut().events.push(event);
        window.0.run_steps(2);
        panel(window).shown_view()
    };
    assert_eq!(hold(&mut window, true), CompareView::Reference);
    assert_eq!(hold(&mut window, false), CompareView::Swipe);
}

#[test]
fn a_region_is_drawn_in_the_viewport_and_measured_alone() {
    let place = Place::new();
    let mut window = comparing(&place);
    let measured = |s: &EditorState| s.comparison.context().measured.map(|m| m.metrics.pixels);
    let whole = measured(window.0.state()).unwrap();
    window.click("Region");
    let rect = window.0.state().interface.viewport_rect;
    let eye = window.0.state().work.document.camera.eye;
    let at = |x: f32, y: f32| rect.min + vec2(x, y) * rect.size();
    window.0.drag_at(at(0.25, 0.25));
    window.0.run_steps(2);
    window.0.hover_at(at(0.6, 0.6));
    window.0.run_steps(2);
    window.0.drop_at(at(0.75, 0.75));
    window.wait("the figures of the region", |s| measured(s).is_some_and(|pixels| pixels < whole / 2));
    let [left, top, right, bottom] = panel(&mut window).region.unwrap();
    assert!((left - 0.25).abs() < 0.02 && (top - 0.25).abs() < 0.02 && right > 0.5 && bottom > 0.5);
    assert_eq!(panel(&mut window).tool, None, "one drag draws one region");
    assert_eq!(window.0.state().work.document.camera.eye, eye, "the camera stays");
    window.click("Whole");
    window.wait("the figures of all", |s| measured(s) == Some(whole));
}

#[test]
fn a_picture_file_is_compared_with_and_a_bad_one_is_told_in_the_strip() {
    let place = Place::new();
    let mut window = comparing(&place);
    let path = place.path("truth.exr");
    image::write(&Image::filled([40, 30], glam::Vec3::splat(0.5)), &path).unwrap();
    window.perform(Action::Compare(CompareAction::Reference(Some(path.clone()))));
    window.wait("the file", |s| s.comparison.context().measured.is_some_and(|m| m.reference.image.size == [40, 30]));
    panel(&mut window).map = ShownMap::Error(ErrorMap::Signed);
    window
        .wait("the signed map", |s| s.comparison.context().measured.is_some_and(|m| m.field.kind == ErrorMap::Signed));
    std::fs::write(&path, b"nothing").unwrap();
    window.perform(Action::Compare(CompareAction::Reference(Some(path))));
    window.wait("the problem", |s| s.comparison.context().problem.is_some());
    assert!(window.shows("cannot be read"));
    panel(&mut window).kind = KindChoice::Samples;
    finished(&mut window);
    assert!(!window.shows("cannot be read"), "negative control: light samples go on");
}

#[test]
fn the_ladder_finds_figures_for_all_sizes_and_a_click_uses_one() {
    let place = Place::new();
    let mut window = comparing(&place);
    window.perform(Action::Ladder(LadderAction::Start));
    assert!(window.0.state().comparison.context().held);
    window.0.state_mut().ladder = LadderWindow::default();
    window.0.run_steps(1);
    assert!(!window.0.state().comparison.context().held, "a window that is closed gives the cores back");
    window.click("Which cut size is enough?");
    window.wait("all figures", |s| s.ladder.figures() == 7);
    window.0.run_steps(3);
    assert!(!window.0.state().comparison.context().held, "its end gives the cores back");
    assert!(window.shows("enough: ") || window.shows("Every size lowers the error"));
    let use_buttons = window.0.query_all_by_label("Use").count();
    assert_eq!(use_buttons, 6, "lit cuts are in use");
    window.0.query_all_by_label("Use").next().unwrap().click();
    window.0.run_steps(3);
    let cuts = |window: &Window| window.0.state().work.document.view.cuts();
    assert_eq!(cuts(&window), Cuts::Refine(1), "as the ladder's picture");
    window.0.query_all_by_label("Use").last().unwrap().click();
    window.0.run_steps(3);
    assert_eq!((cuts(&window), window.0.state().work.document.view.illum_cut), (Cuts::Lit(DEFAULT_TAU), 1));
    window.perform(Action::Undo);
    assert_eq!(cuts(&window), Cuts::Refine(1));
    window.perform(Action::Undo);
    assert_eq!((cuts(&window), window.0.state().work.document.view.illum_cut), (Cuts::Lit(DEFAULT_TAU), 256));
}

#[test]
fn a_click_asks_why_and_the_answer_has_the_nodes_of_the_pixel_and_its_errors_causes() {
    let place = Place::new();
    let mut window = comparing(&place);
    window.click("Why is a pixel so?");
    let rect = window.0.state().interface.viewport_rect;
    let click = |window: &mut Window, at| {
        window.0.drag_at(at);
        window.0.run_steps(1);
        window.0.drop_at(at);
        window.0.run_steps(2);
    };
    click(&mut window, rect.center());
    window.wait("the explanation", |s| s.explain.has_nodes());
    assert!(window.shows("Merged cut") && window.shows("Vertex"));
    window.click("Split the error");
    window.wait("the causes", |s| s.explain.causes() > 3);
    assert!(!window.shows("The picture has changed since"));
    window.0.state_mut().work.document.view.tau = 1.0;
    window.0.run_steps(3);
    assert!(window.shows("The picture has changed since"));
    window.click("Explain again");
    window.wait("the explanation of the new picture", |s| s.explain.has_nodes());
    assert!(!window.shows("The picture has changed since"));
    click(&mut window, rect.left_top() + vec2(10.0, 10.0));
    window.wait("the reason", |s| s.explain.message().is_some());
    assert!(window.shows("shows the background"), "there is no cut to explain");
}
