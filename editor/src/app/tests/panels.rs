//! Panels stay put: only the user moves their edges, and the picture is kept meanwhile.

use super::{Place, Window, hands};
use crate::{
    actions::{Action, SelectAction},
    preferences::{Preferences, SIDE_WIDTHS},
    workspace::{Inspector, Side},
};
use egui::{Rect, Role, Shape, Vec2, vec2};
use egui_kittest::kittest::Queryable;
use lapidary_core::scene::pose::Pose;

/// A window with a picture.
fn opened(place: &Place, size: Vec2) -> Window {
    place.bake();
    let mut window = place.window_of(size);
    window.open(&place.path("scene.obj"));
    window.wait("a picture", |s| s.picture.shown().is_some());
    window
}

impl Window {
    fn viewport(&self) -> Rect {
        self.0.get_by_label("Viewport").rect()
    }

    /// Size of the picture that was asked for last.
    fn asked(&self) -> [u32; 2] {
        self.0.state().picture.requests.last_sent().unwrap().look.view.size
    }

    fn columns(&self, rows: &[&str]) -> Vec<[f32; 4]> {
        let columns = |row: &&str| {
            let (slider, number) =
                (self.0.get_by_label(row).rect(), self.0.get_by_label(&format!("{row} value")).rect());
            [slider.left(), slider.right(), number.left(), number.right()].map(f32::round)
        };
        rows.iter().map(columns).collect()
    }
}

#[test]
fn no_tab_and_no_content_moves_an_edge() {
    let place = Place::new();
    let mut window = opened(&place, vec2(1300.0, 800.0));
    let (viewport, asked) = (window.viewport(), window.asked());
    let long = "a name as long as that of a material from a studio's library of many thousands ".repeat(3);
    window.0.state_mut().work.document.materials[0].name = long.clone();
    for inspector in Inspector::ALL {
        for side in Side::ALL {
            (window.0.state_mut().work.tabs.inspector, window.0.state_mut().work.tabs.side) = (inspector, side);
            window.0.run_steps(4);
            assert_eq!((window.viewport(), window.asked()), (viewport, asked), "{inspector:?}, {side:?}");
        }
    }
    window.0.state_mut().work.messages.warning(long);
    window.0.run_steps(4);
    assert_eq!((window.viewport(), window.asked()), (viewport, asked), "a message");
}

#[test]
fn a_dragged_edge_keeps_the_picture_until_it_is_let_go_and_is_remembered() {
    let place = Place::new();
    let mut window = opened(&place, vec2(1300.0, 800.0));
    let (viewport, asked) = (window.viewport(), window.asked());
    let edge = viewport.right_center();
    window.0.drag_at(edge);
    window.0.run_steps(2);
    for step in 1..=4 {
        window.0.hover_at(edge - vec2(20.0 * step as f32, 0.0));
        window.0.run_steps(2);
        assert!((window.viewport().right() - (edge.x - 20.0 * step as f32)).abs() <= 1.0, "the edge follows");
        assert_eq!(window.asked(), asked, "the picture is kept");
    }
    window.0.drop_at(edge - vec2(80.0, 0.0));
    window.0.run_steps(3);
    assert_eq!(window.asked(), [asked[0] - 80, asked[1]]);
    let kept = Preferences::load(&place.path("home/config")).0;
    assert_eq!(kept.inspector_width, Preferences::default().inspector_width + 80.0);
    let again = place.window_of(vec2(1300.0, 800.0));
    assert_eq!(again.0.state().interface.sides.widths, [kept.side_width, kept.inspector_width]);
}

#[test]
fn an_edge_goes_no_further_than_the_rows_need() {
    let place = Place::new();
    let mut window = opened(&place, vec2(1300.0, 800.0));
    for (by, width) in [(600.0, 280.0), (-900.0, 640.0)] {
        let edge = window.viewport().right_center();
        window.0.drag_at(edge);
        window.0.run_steps(2);
        window.0.hover_at(edge + vec2(by, 0.0));
        window.0.run_steps(2);
        window.0.drop_at(edge + vec2(by, 0.0));
        window.0.run_steps(3);
        assert_eq!(window.0.state().interface.sides.widths[1], width);
    }
}

#[test]
fn the_picture_is_kept_while_the_window_is_resized() {
    let place = Place::new();
    let mut window = opened(&place, vec2(1300.0, 800.0));
    let asked = window.asked();
    window.0.set_size(vec2(1360.0, 830.0));
    window.0.step();
    assert_eq!(window.asked(), asked);
    window.0.run_steps(4);
    assert_eq!(window.asked(), [asked[0] + 60, asked[1] + 30]);
}

#[test]
fn in_a_narrow_window_panels_are_icons_that_open_over_the_picture() {
    let place = Place::new();
    let mut window = opened(&place, vec2(1000.0, 700.0));
    let (viewport, asked) = (window.viewport(), window.asked());
    assert!(viewport.width() > 880.0, "{viewport}");
    assert!(window.0.query_by_label("Roughness value").is_none());
    for tab in Inspector::ALL.map(Inspector::label).into_iter().chain(Side::ALL.map(Side::label)) {
        assert!(window.0.query_all_by_label(tab).next().is_some(), "{tab}");
    }
    window.click("Material");
    window.type_roughness("0.3");
    assert_eq!(window.roughness(), 0.3);
    assert_eq!((window.viewport(), window.asked()), (viewport, asked), "the picture lies under it");
    let pane = window.0.get_by_label("Roughness").rect();
    let selected = window.0.state().work.selection.object;
    window.0.hover_at(pane.left_center() - vec2(60.0, 0.0));
    window.0.drag_at(pane.left_center() - vec2(60.0, 0.0));
    window.0.drop_at(pane.left_center() - vec2(60.0, 0.0));
    window.0.run_steps(3);
    assert_eq!(window.0.state().work.selection.object, selected, "a click on the panel is none on the picture");
    let icon = window.0.get_all_by_label("Material").map(|n| n.rect()).find(|rect| rect.width() <= 40.0).unwrap();
    window.frame_of(hands::click(icon.center()));
    assert!(window.0.query_by_label("Roughness value").is_none(), "the icon closes it again");
    let mut narrow = opened(&place, vec2(1100.0, 700.0));
    narrow.0.step();
    assert!(narrow.0.query_by_label("Roughness value").is_some(), "negative control: there is room");
}

#[test]
fn sliders_and_numbers_of_all_tabs_stand_in_the_same_columns() {
    let place = Place::new();
    // High enough that no tab needs a scroll bar, which takes room beside the columns.
    let mut window = opened(&place, vec2(1300.0, 1100.0));
    let tabs: [(Inspector, &[&str]); 3] = [
        (Inspector::Material, &["Roughness", "Metalness", "Specular", "IOR", "Anisotropy"]),
        (Inspector::Environment, &["Rotation", "Intensity"]),
        (Inspector::View, &["Lit cut error", "Samples", "Frame budget", "Field of view", "Focal length"]),
    ];
    let mut columns = Vec::new();
    for (tab, rows) in tabs {
        window.0.state_mut().work.tabs.inspector = tab;
        window.0.run_steps(3);
        columns.extend(window.columns(rows));
    }
    assert!(columns.iter().all(|c| *c == columns[0]), "{columns:?}");
    let [left, right, number_left, number_right] = columns[0];
    assert!(left < right && right < number_left && number_left < number_right);
}

/// Whether a text is shown in full.
fn is_whole(window: &Window, text: &str) -> bool {
    fn is_it(shape: &Shape, text: &str) -> bool {
        match shape {
            Shape::Vec(shapes) => shapes.iter().any(|shape| is_it(shape, text)),
            Shape::Text(shown) => shown.galley.text() == text && !shown.galley.elided,
            _ => false,
        }
    }
    window.0.output().shapes.iter().any(|clipped| is_it(&clipped.shape, text))
}

#[test]
fn the_numbers_and_the_pivot_of_a_pose_fit_the_narrowest_panel() {
    let place = Place::new();
    let mut window = opened(&place, vec2(1300.0, 1000.0));
    window.perform(Action::Select(SelectAction::Object(Some(0))));
    window.perform(Action::Select(SelectAction::Toggle(1)));
    let moved = Pose { translate: glam::Vec3::splat(-0.383), ..Pose::AS_BAKED };
    window.0.state_mut().work.document.poses.set(1, moved);
    let [narrowest, widest] = SIDE_WIDTHS;
    for (width, is_column) in [(narrowest, true), (230.0, false), (widest, false)] {
        window.0.state_mut().interface.sides.widths[0] = width;
        window.0.run_steps(4);
        let rect = |label: &str| window.0.get_by_label(label).rect();
        let axes = |of: &str| ["X", "Y", "Z"].map(|axis| rect(&format!("{of} {axis}")));
        let (moves, turns) = (axes("Move"), axes("Turn"));
        let pivot = window.0.get_by_role_and_label(Role::ComboBox, "Pivot").rect();
        for rect in moves.iter().chain(&turns).chain([&pivot, &rect("Scale value")]) {
            assert!(rect.left() >= 0.0 && rect.right() <= width - 8.0, "{width}: {rect:?}");
        }
        assert_eq!(moves[0].bottom() < moves[2].top(), is_column, "{width}: {moves:?}");
        assert!(pivot.bottom() < moves[0].top() && moves[2].bottom() < turns[0].top(), "{width}: {moves:?} {turns:?}");
        assert!(is_whole(&window, "Selected last") && is_whole(&window, "-0.383"), "{width}");
    }
    assert!(!is_whole(&window, "Selected las"), "negative control");
}
