use super::{
    color::{hex_from_linear, linear_from_hex},
    *,
};
use egui::{Color32, Shape};
use egui_kittest::{Harness, kittest::Queryable};
use glam::Vec3;

#[derive(Default)]
struct Probe {
    value: f32,
    color: Vec3,
    changes: usize,
    ends: usize,
}

impl Probe {
    fn note(&mut self, edited: Edited) {
        self.changes += usize::from(edited.changed);
        self.ends += usize::from(edited.ended);
    }
}

fn slider() -> Harness<'static, Probe> {
    let show = |ui: &mut Ui, probe: &mut Probe| {
        let number = Number::new("Width", "Meters.", 0.0..=1.0, 0.5).entry(0.0..=10.0);
        let edited = slider_row(ui, &number, &mut probe.value);
        probe.note(edited);
    };
    let mut harness =
        Harness::builder().with_size(vec2(320.0, 80.0)).build_ui_state(show, Probe { value: 0.5, ..Probe::default() });
    harness.run();
    harness
}

#[test]
fn typing_changes_once_and_reaches_beyond_the_slider() {
    let mut harness = slider();
    harness.get_by_label("Width value").click();
    harness.run();
    harness.get_by_label("Width value").type_text("7.25");
    harness.run();
    assert_eq!(harness.state().changes, 0, "an unfinished number is no change");
    harness.key_press(egui::Key::Enter);
    harness.run();
    let probe = harness.state();
    assert_eq!((probe.value, probe.changes, probe.ends), (7.25, 1, 1));
}

#[test]
fn expressions_are_taken_and_what_is_wrong_is_told_with_the_reason() {
    for (text, value, told) in [
        ("2*3", 6.0, None),
        ("0,25", 0.25, None),
        ("1/0", 0.5, Some("divided by zero")),
        ("2*30", 10.0, Some("0 to 10")),
    ] {
        let mut harness = slider();
        harness.get_by_label("Width value").click();
        harness.run();
        harness.get_by_label("Width value").type_text(text);
        harness.run_steps(2);
        harness.key_press(egui::Key::Enter);
        harness.run_steps(3);
        assert_eq!(harness.state().value, value, "{text}");
        let says = |words: &str| harness.query_all_by_label_contains(words).next().is_some();
        assert!(told.is_none_or(says), "{text}");
        assert!(told.is_some() || !says(" to ") && !says("zero"), "nothing is told of {text}");
    }
}

#[test]
fn a_drag_changes_often_and_ends_once() {
    let mut harness = slider();
    let rect = harness.get_by_label("Width").rect();
    harness.drag_at(rect.center());
    harness.step();
    for i in 1..5 {
        harness.hover_at(rect.center() + vec2(8.0 * i as f32, 0.0));
        harness.step();
    }
    assert_eq!(harness.state().ends, 0);
    harness.drop_at(rect.center() + vec2(40.0, 0.0));
    harness.run();
    let probe = harness.state();
    assert!(probe.value > 0.6 && probe.changes >= 4, "{} after {}", probe.value, probe.changes);
    assert_eq!(probe.ends, 1);
}

#[test]
fn shift_makes_a_drag_fine() {
    let dragged = |shift: bool| {
        let mut harness = slider();
        let rect = harness.get_by_label("Width").rect();
        harness.event(egui::Event::ModifiersChanged(egui::Modifiers { shift, ..Default::default() }));
        harness.drag_at(rect.center());
        harness.step();
        harness.hover_at(rect.center() + vec2(30.0, 0.0));
        harness.step();
        harness.state().value - 0.5
    };
    let (coarse, fine) = (dragged(false), dragged(true));
    assert!(fine > 0.0 && fine < 0.2 * coarse, "{fine} for {coarse}");
}

#[test]
fn reset_is_there_only_when_the_value_differs() {
    let mut harness = slider();
    assert!(harness.query_by_label("Reset Width").is_none());
    harness.state_mut().value = 0.75;
    harness.run();
    harness.get_by_label("Reset Width").click();
    harness.run();
    let probe = harness.state();
    assert_eq!((probe.value, probe.changes, probe.ends), (0.5, 1, 1));
}

#[test]
fn hex_is_srgb_and_what_is_no_colour_is_refused() {
    let half = linear_from_hex("#808080").unwrap();
    assert!((half.x - 0.2158605).abs() < 1e-5);
    assert_eq!(hex_from_linear(half), "#808080");
    assert_eq!(linear_from_hex("f00"), Some(Vec3::X));
    for wrong in ["", "#12345", "#gg0000", "+12345", "éé", "1234567"] {
        assert_eq!(linear_from_hex(wrong), None, "{wrong}");
    }
}

#[test]
fn a_typed_hex_colour_arrives_when_the_field_is_left() {
    let show = |ui: &mut Ui, probe: &mut Probe| {
        let edited = color_row(ui, "Tint", "A color.", &mut probe.color, Vec3::ONE);
        probe.note(edited);
    };
    let mut harness = Harness::builder().with_size(vec2(320.0, 80.0)).build_ui_state(show, Probe::default());
    harness.run();
    for (typed, expected) in [("nonsense", 0.0), ("#ff0000", 1.0)] {
        harness.get_by_label("Tint hex").click();
        harness.run();
        harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
        harness.get_by_label("Tint hex").type_text(typed);
        harness.run();
        harness.key_press(egui::Key::Enter);
        harness.run();
        assert_eq!(harness.state().color.x, expected, "{typed}");
    }
    assert_eq!((harness.state().changes, harness.state().ends), (1, 1));
}

/// Number of shapes with an outline from [`outline`].
fn outlined(show: fn(&mut Ui)) -> usize {
    fn count(shape: &Shape, color: Color32) -> usize {
        match shape {
            Shape::Vec(shapes) => shapes.iter().map(|shape| count(shape, color)).sum(),
            Shape::Rect(rect) => usize::from(rect.stroke == Stroke::new(1.0, color)),
            _ => 0,
        }
    }
    let mut harness = Harness::builder().build_ui(move |ui| {
        ui.ctx().set_theme(egui::Theme::Light);
        show(ui);
    });
    harness.run();
    let color = harness.ctx.style_of(egui::Theme::Light).visuals.weak_text_color();
    harness.output().shapes.iter().map(|clipped| count(&clipped.shape, color)).sum()
}

#[test]
fn unticked_boxes_and_white_swatches_are_set_off_from_the_panel() {
    let ticked = |ui: &mut Ui| _ = check_box(ui, &mut false, "On");
    let color = |ui: &mut Ui| _ = color_row(ui, "Color", "", &mut Vec3::ONE.clone(), Vec3::ONE);
    assert_eq!([outlined(ticked), outlined(color)], [1, 1]);
    assert_eq!(outlined(|ui| _ = ui.checkbox(&mut false, "On")), 0, "negative control");
}

/// A row with a color, whose picker is open.
fn picking(color: Vec3) -> Harness<'static, Probe> {
    let show = |ui: &mut Ui, probe: &mut Probe| {
        let edited = color_row(ui, "Tint", "A color.", &mut probe.color, Vec3::ONE);
        probe.note(edited);
    };
    let builder = Harness::builder().with_size(vec2(460.0, 520.0));
    let mut harness = builder.build_ui_state(show, Probe { color, ..Probe::default() });
    harness.run();
    harness.get_by_label("Tint").click();
    harness.run();
    harness
}

#[test]
fn hue_saturation_and_value_are_those_of_the_color_as_displayed() {
    let mut harness = picking(linear_from_hex("#804020").unwrap());
    let number = |harness: &Harness<Probe>, name| harness.get_by_label(name).value().unwrap();
    assert_eq!(["Hue", "Saturation", "Value"].map(|name| number(&harness, name)), ["20°", "75.0 %", "50.2 %"]);
    harness.get_by_label("Hue").click();
    harness.run();
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.get_by_label("Hue").type_text("2*70");
    harness.key_press(egui::Key::Enter);
    harness.run();
    assert_eq!(hex_from_linear(harness.state().color), "#208040");
}

#[test]
fn the_eyedropper_takes_a_color_of_the_window_and_colors_used_before_come_back() {
    let mut harness = picking(Vec3::X);
    harness.get_by_label("Eyedropper").click();
    harness.run();
    let at = egui::pos2(300.0, 400.0);
    harness.event(egui::Event::PointerMoved(at));
    harness.run();
    harness.drag_at(at);
    harness.step();
    harness.drop_at(at);
    harness.run();
    let image = egui::ColorImage::filled([460, 520], egui::Color32::from_rgb(0, 0, 255));
    super::color::eyedropper::tests::answer(&harness.ctx, &image, at);
    harness.run();
    assert_eq!(harness.state().color, Vec3::Z);
    harness.get_by_label("Tint").click();
    harness.run();
    assert!(harness.query_by_label("Recent #0000ff").is_some(), "it was chosen");
    assert!(harness.query_by_label("Recent #ff0000").is_none(), "negative control: it was there before");
}
