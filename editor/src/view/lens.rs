//! The lens of the camera: sensor, focal length, aperture, focus and shift.

use super::ViewContext;
use crate::{
    actions::{Action, CameraAction},
    widgets::{
        Edited, Number,
        entries::{Decades, combo_row, limit_row},
        slider_row,
    },
};
use egui::{Button, Ui};
use lapidary_core::camera::{Camera, Lens, MOST_SHIFT};

/// Vertical fields of view in degrees that can be set.
const FIELDS_OF_VIEW: [f32; 2] = [5.0, 120.0];
/// Heights of sensors in millimeters, with their names and widths.
const SENSORS: [(f32, &str, &str); 6] = [
    (24.0, "Full frame", "36 x 24 mm"),
    (14.9, "APS-C", "22.3 x 14.9 mm"),
    (13.0, "Micro four thirds", "17.3 x 13 mm"),
    (18.66, "Super 35", "24.89 x 18.66 mm"),
    (32.9, "Medium format", "43.8 x 32.9 mm"),
    (102.0, "Large format", "127 x 102 mm"),
];
/// The f-number of a lens that is opened.
pub const OPENED: f32 = 2.8;

/// Shows the rows of the lens, and changes the camera. The button asks for a click.
pub fn show(ui: &mut Ui, camera: &mut Camera, context: &ViewContext, actions: &mut Vec<Action>) -> Edited {
    focal_length(ui, camera) | aperture(ui, camera, context, actions) | shift(ui, camera)
}

/// Field of view and focal length, two forms of one value.
fn focal_length(ui: &mut Ui, camera: &mut Camera) -> Edited {
    let [narrowest, widest] = FIELDS_OF_VIEW;
    let field = Number::new("Field of view", "Vertical, in degrees.", narrowest..=widest, 40.0).unit("°", 1);
    let mut degrees = camera.fov_y.to_degrees();
    let field = slider_row(ui, &field, &mut degrees);
    if field.changed {
        camera.fov_y = degrees.to_radians();
    }
    let help = "Sensor behind the lens. It keeps the field of view: focal length and depth of field change.";
    let sensor = combo_row(ui, "Sensor", help, &mut camera.lens.sensor_mm, &SENSORS);
    let sensor_mm = camera.lens.sensor_mm;
    let of = |degrees: f32| focal_from_fov(degrees.to_radians(), sensor_mm);
    let [longest, shortest] = FIELDS_OF_VIEW.map(of);
    let help = "Focal length on this sensor for this vertical field of view.";
    let focal = Number::new("Focal length", help, shortest..=longest, of(40.0));
    let mut focal_mm = 1e3 * camera.focal_length();
    let focal = slider_row(ui, &focal.unit(" mm", 1), &mut focal_mm);
    if focal.changed {
        camera.fov_y = fov_from_focal(focal_mm, sensor_mm);
    }
    field | sensor | focal
}

fn aperture(ui: &mut Ui, camera: &mut Camera, context: &ViewContext, actions: &mut Vec<Action>) -> Edited {
    let help = "Aperture: focal length over its diameter. Small numbers blur what is out of focus; off, all is sharp. \
                A picture with an open lens takes 64 samples or more.";
    let sharp = Some("all is sharp".into());
    let f_number =
        Decades { decimals: 2, note: sharp, ..Decades::count("F-number", help, 0.01..=128.0, OPENED.into()) };
    let opened = limit_row(ui, &f_number, &mut camera.lens.f_number);
    if camera.lens.f_number.is_none() {
        return opened;
    }
    let help =
        "Distance from the camera to the plane of focus, in meters; off, the point that the camera orbits is in focus.";
    let now = f64::from(camera.focus_distance());
    let target = Some(format!("on the target, {now:.2} m"));
    let focus = Decades { unit: " m", decimals: 3, note: target, ..Decades::count("Focus", help, 1e-3..=1e5, now) };
    let focused = limit_row(ui, &focus, &mut camera.lens.focus);
    let by_click = ui.add(Button::new("Focus by click").selected(context.focusing));
    if by_click.on_hover_text("Click in the picture what is to be sharp").clicked() {
        actions.push(Action::Camera(CameraAction::AskForFocus));
    }
    opened | focused
}

fn shift(ui: &mut Ui, camera: &mut Camera) -> Edited {
    let number = |label, help| Number::new(label, help, -1.0..=1.0, 0.0).entry(-MOST_SHIFT..=MOST_SHIFT);
    let help = "Moves the picture to the right, in heights of it, without turning the camera.";
    let right = slider_row(ui, &number("Shift right", help), &mut camera.lens.shift.x);
    let help = "Moves the picture up, in heights of it, without turning the camera: vertical lines stay parallel.";
    right | slider_row(ui, &number("Shift up", help), &mut camera.lens.shift.y)
}

/// The camera focused at a depth in meters, with its lens open.
pub fn focused(camera: &Camera, depth: f32) -> Camera {
    let f_number = camera.lens.f_number.or(Some(OPENED));
    Camera { lens: Lens { f_number, focus: Some(depth), ..camera.lens }, ..camera.clone() }
}

/// Focal length in millimeters for a vertical field of view in radians, on a sensor of a height in millimeters.
pub fn focal_from_fov(fov_y: f32, sensor_mm: f32) -> f32 {
    0.5 * sensor_mm / (0.5 * fov_y).tan()
}

/// Vertical field of view in radians for a focal length, on a sensor of a height, both in millimeters.
pub fn fov_from_focal(focal_mm: f32, sensor_mm: f32) -> f32 {
    2.0 * (0.5 * sensor_mm / focal_mm).atan()
}
