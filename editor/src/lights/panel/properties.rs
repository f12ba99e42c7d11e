//! The numbers of one light.

use super::LightsPanel;
use crate::{
    actions::Action,
    document::{
        Edit,
        lights::{
            ANGLE_DEGREES, CONE_DEGREES, IntensityUnit, LightKind, MOST_INTENSITY, SIDES, color_and_intensity,
            with_kind,
        },
    },
    widgets::{
        Edited, Number, color_row, edit_row,
        entries::{Decades, combo_row, decades_row, point_row},
        slider_row,
    },
};
use egui::{Button, Ui};
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    color::{KELVINS, blackbody, temperature_of},
    lights::{Emission, Light},
};

/// The faintest light in stops.
const LEAST_STOPS: f32 = -30.0;

/// Shows the light and its tools.
pub fn show(
    ui: &mut Ui,
    state: &mut LightsPanel,
    index: usize,
    light: &Light,
    camera: &Camera,
    actions: &mut Vec<Action>,
) {
    let mut rows = Rows { ui, index, light, unit: state.unit, actions };
    rows.kind();
    rows.color();
    // The unit is state of the window, without undo.
    let _ = combo_row(rows.ui, "Unit", "Unit of the intensity.", &mut state.unit, &IntensityUnit::CHOICES);
    rows.shape();
    rows.place();
    tools(ui, state, index, light, camera, actions);
}

struct Rows<'a> {
    ui: &'a mut Ui,
    index: usize,
    light: &'a Light,
    unit: IntensityUnit,
    actions: &'a mut Vec<Action>,
}

impl Rows<'_> {
    /// One row. Its change counts only if the resulting light is valid.
    fn row(&mut self, label: &'static str, row: impl FnOnce(&mut Ui, &mut Light) -> Edited) {
        let (ui, index) = (&mut *self.ui, self.index);
        let edit = |light| Edit::Light { index, light: Box::new(light) };
        edit_row(self.actions, label, self.light, edit, |light| {
            let mut edited = row(ui, light);
            edited.changed &= light.validate().is_ok();
            edited
        });
    }

    fn kind(&mut self) {
        let choices = LightKind::ALL.map(|kind| (kind, kind.label(), kind.meaning()));
        self.row("Light kind", |ui, light| {
            let mut kind = LightKind::of(light);
            let edited = combo_row(ui, "Kind", "Kind of light source.", &mut kind, &choices);
            if edited.changed {
                *light = with_kind(light, kind);
            }
            edited
        });
    }

    /// Color and intensity separately: the color's brightest channel is 1.
    fn color(&mut self) {
        let (color, intensity) = color_and_intensity(self.light.intensity);
        self.row("Light color", |ui, light| {
            let mut picked = color;
            let help = "Color without brightness, which Intensity sets.";
            let edited = color_row(ui, "Color", help, &mut picked, Vec3::ONE);
            // A light cannot be black.
            if edited.changed && picked.max_element() > 0.0 {
                light.intensity = intensity * color_and_intensity(picked).0;
            }
            edited
        });
        self.temperature(color, intensity);
        self.intensity(color, intensity);
    }

    /// The color by the temperature of a hot body.
    fn temperature(&mut self, color: Vec3, intensity: f32) {
        let [coldest, hottest] = KELVINS.map(f64::from);
        let help = "Color of a hot body: 2,700 K for bulbs, 6,500 K for daylight. Grayed out for other colors.";
        let found = temperature_of(color);
        let rows = Decades { unit: " K", ..Decades::count("Temperature", help, coldest..=hottest, 6500.0) };
        self.row("Light color", |ui, light| {
            let mut kelvin = found.unwrap_or(6500.0).round();
            if found.is_none() {
                ui.visuals_mut().override_text_color = Some(ui.visuals().weak_text_color());
            }
            let edited = decades_row(ui, &rows, &mut kelvin);
            ui.visuals_mut().override_text_color = None;
            if edited.changed {
                light.intensity = intensity * blackbody(kelvin);
            }
            edited
        });
    }

    fn intensity(&mut self, color: Vec3, intensity: f32) {
        let (unit, of) = (self.unit, self.light);
        let help = format!("In {}, of the brightest color channel.", unit.label(of));
        let shown = unit.of(intensity, of);
        if unit == IntensityUnit::Stops {
            let stops = Number::new("Intensity", &help, -10.0..=20.0, shown.max(LEAST_STOPS))
                .entry(LEAST_STOPS..=29.0)
                .unit(" EV", 2);
            self.row("Light intensity", |ui, light| {
                let mut value = shown.max(LEAST_STOPS);
                let edited = slider_row(ui, &stops, &mut value);
                if edited.changed {
                    light.intensity = unit.intensity(value, of) * color;
                }
                edited
            });
            return;
        }
        let most = f64::from(unit.of(MOST_INTENSITY, of));
        let decades = Decades {
            decimals: 2,
            note: Some(unit.label(of).into()),
            ..Decades::count("Intensity", &help, 0.0..=most, f64::from(shown))
        };
        self.row("Light intensity", |ui, light| {
            let mut value = shown;
            let edited = decades_row(ui, &decades, &mut value);
            if edited.changed {
                light.intensity = unit.intensity(value, of).min(MOST_INTENSITY) * color;
            }
            edited
        });
    }

    fn shape(&mut self) {
        match self.light.emission {
            Emission::Spot { .. } => self.cone(),
            Emission::Rectangle { .. } => self.sides(),
            Emission::Directional { .. } => self.angle(),
            Emission::Point => {}
        }
    }

    fn angle(&mut self) {
        let [least, most] = ANGLE_DEGREES;
        let help = "Angular diameter in degrees: 0 for sharp shadows, 0.53 for the sun.";
        let angle = Number::new("Angle", help, least..=most, 0.53).unit("°", 2);
        self.row("Angle", |ui, light| match &mut light.emission {
            Emission::Directional { angle_degrees } => slider_row(ui, &angle, angle_degrees),
            _ => Edited::default(),
        });
    }

    fn cone(&mut self) {
        let [narrowest, widest] = CONE_DEGREES;
        let cone = Number::new("Cone", "From the axis to the edge, in degrees.", narrowest..=widest, 35.0).unit("°", 1);
        self.row("Cone", |ui, light| {
            let Emission::Spot { cone_degrees, penumbra_degrees } = &mut light.emission else {
                return Edited::default();
            };
            let edited = slider_row(ui, &cone, cone_degrees);
            *penumbra_degrees = penumbra_degrees.min(*cone_degrees);
            edited
        });
        self.row("Penumbra", |ui, light| {
            let Emission::Spot { cone_degrees, penumbra_degrees } = &mut light.emission else {
                return Edited::default();
            };
            let help = "Width of the soft edge inside the cone, in degrees.";
            let soft = Number::new("Penumbra", help, 0.0..=*cone_degrees, cone_degrees.min(8.0)).unit("°", 1);
            slider_row(ui, &soft, penumbra_degrees)
        });
    }

    fn sides(&mut self) {
        let [smallest, largest] = SIDES.map(f64::from);
        for (label, is_width) in [("Width", true), ("Height", false)] {
            self.row(label, |ui, light| {
                let Emission::Rectangle { width, height } = &mut light.emission else { return Edited::default() };
                let side = if is_width { width } else { height };
                let help = "In meters: larger lights give softer shadows.";
                let decades = Decades::count(label, help, smallest..=largest, f64::from(*side));
                decades_row(ui, &Decades { unit: " m", decimals: 2, ..decades }, side)
            });
        }
    }

    fn place(&mut self) {
        self.row("Move light", |ui, light| {
            point_row(ui, "Position", "Position of the light in meters.", &mut light.position)
        });
        if self.light.emission.is_aimed() {
            self.row("Aim light", |ui, light| {
                point_row(ui, "Target", "Point that the light aims at, in meters.", &mut light.target)
            });
        }
    }
}

fn tools(
    ui: &mut Ui,
    state: &mut LightsPanel,
    index: usize,
    light: &Light,
    camera: &Camera,
    actions: &mut Vec<Action>,
) {
    ui.horizontal_wrapped(|ui| {
        let place =
            ui.button("Place at camera").on_hover_text("Moves the light to the camera and aims it along the view");
        if place.clicked() {
            let light = Box::new(Light { position: camera.eye, target: camera.target, ..light.clone() });
            let edit = Edit::Light { index, light };
            actions.extend([Action::Edit { edit, label: "Place light at camera" }, Action::EndGesture]);
        }
        if light.emission.is_aimed() {
            let aim = ui.add(Button::new("Aim by click").selected(state.aiming));
            if aim.on_hover_text("Click a point in the viewport to aim the light at it").clicked() {
                state.aiming = !state.aiming;
            }
        }
    });
}
