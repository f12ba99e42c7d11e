//! The environment: its map, rotation and intensity, with a picture of it that rotates with the light.

mod library;
mod map_view;
mod overlay;
#[cfg(test)]
mod tests;
mod thumbnail;

pub use library::LibraryEntry;
pub use thumbnail::thumbnail;

use crate::{
    actions::{Action, EnvironmentAction},
    document::{Document, Edit, EnvironmentSettings, Orientation, SunChoice},
    widgets::{
        Edited, Layers, Number, check_row, choice_row, color_row, edit_row,
        entries::{Decades, GIVEN_SPACES, combo_row, decades_row},
        section, slider_row,
    },
};
use egui::{RichText, Ui};
use glam::Vec3;
use lapidary_core::{
    dataset::BakeSettings,
    environment::{Environment, Sun},
    ground::Ground,
    light_tree::LightTree,
    texture::ColorSpace,
};
use lapidary_render::EnvironmentLight;
use std::sync::Arc;

/// Default elevation of the sun in degrees.
const SUN_ELEVATION: f32 = 45.0;

/// Input of the panel.
pub struct EnvironmentContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// The map, once it is loaded.
    pub environment: Option<&'a Arc<Environment>>,
    /// Maps to choose from; formulas are added to them.
    pub library: &'a [LibraryEntry],
    /// The light tree of the dataset.
    pub tree: Option<&'a LightTree>,
    /// The tree under the present light, with its illumination cut.
    pub lighting: Option<&'a Arc<EnvironmentLight>>,
    /// Changes whenever tree or lighting change.
    pub light_revision: u64,
    /// Whether the rendered scene has no ground, and no scene file to bake one.
    pub lacks_ground: bool,
    /// A message about the map: loading, or why it could not be read.
    pub message: Option<&'a str>,
}

/// State of the panel between frames.
#[derive(Default)]
pub struct EnvironmentPanel {
    map_view: map_view::MapView,
    formulas: library::FormulaThumbnails,
    layers: Layers,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, state: &mut EnvironmentPanel, context: &EnvironmentContext, actions: &mut Vec<Action>) {
    map_view::show(ui, &mut state.map_view, context, actions);
    if let Some(message) = context.message {
        ui.label(RichText::new(message).color(ui.visuals().warn_fg_color));
    }
    if let Some(map) = context.document.environment.file() {
        let chosen = state.layers.row(ui, map).map(Some);
        actions.extend(chosen.map(EnvironmentAction::Load).map(Action::Environment));
    }
    placement(ui, &context.document.environment, actions);
    color_space(ui, &context.document.environment, actions);
    formula(ui, &context.document.environment, actions);
    section(ui, "Sun", true, |ui| sun(ui, context, actions));
    section(ui, "Ground", true, |ui| ground(ui, context, actions));
}

/// Shows the library: formulas and maps to choose from.
pub fn show_library(
    ui: &mut Ui,
    state: &mut EnvironmentPanel,
    context: &EnvironmentContext,
    actions: &mut Vec<Action>,
) {
    library::show(ui, &mut state.formulas, context, actions);
}

fn placement(ui: &mut Ui, light: &EnvironmentSettings, actions: &mut Vec<Action>) {
    let help = "Turns the environment, counter-clockwise seen from above. Also: drag the picture.";
    let rotation = Number::new("Rotation", help, -180.0..=180.0, 0.0).unit("°", 1).entry(-36_000.0..=36_000.0);
    edit_row(actions, "Rotation", light, Edit::Environment, |l| {
        let edited = slider_row(ui, &rotation, &mut l.rotation_degrees);
        if edited.changed {
            l.rotation_degrees = wrapped(l.rotation_degrees);
        }
        edited
    });
    let intensity = Decades {
        decimals: 2,
        note: Some(stops_text(light.intensity)),
        ..Decades::count("Intensity", "Scales the light, 0 to 10; the value in stops is below.", 0.0..=10.0, 1.0)
    };
    edit_row(actions, "Intensity", light, Edit::Environment, |l| decades_row(ui, &intensity, &mut l.intensity));
    let orientations = [
        (Orientation::OpenExr, "OpenEXR", "The center of the map is +Z, as in OpenEXR, Mitsuba and MaterialX."),
        (Orientation::Blender, "Blender, three.js", "The center of the map is +X, as in Blender and three.js."),
    ];
    edit_row(actions, "Orientation", light, Edit::Environment, |l| {
        choice_row(ui, "Orientation", "Direction of the center of the map.", &mut l.orientation, &orientations)
    });
}

/// The color space of a map, with what its file says first.
fn color_space(ui: &mut Ui, light: &EnvironmentSettings, actions: &mut Vec<Action>) {
    if light.file().is_none() {
        return;
    }
    let mut spaces = vec![
        (ColorSpace::Srgb, "Of the file", "The primaries that the file names, else Rec. 709; 8 bits are sRGB encoded."),
        (ColorSpace::Linear, "Linear Rec. 709", "Linear colors in Rec. 709, whatever the file says."),
    ];
    spaces.extend(GIVEN_SPACES);
    edit_row(actions, "Color space of the environment", light, Edit::Environment, |l| {
        combo_row(ui, "Color space", "The colors of the map's file.", &mut l.color_space, &spaces)
    });
}

/// Settings of suns, and the suns of the map.
fn sun(ui: &mut Ui, context: &EnvironmentContext, actions: &mut Vec<Action>) {
    let light = &context.document.environment;
    let help = "Turns small bright parts of the map into directional lights with sharp shadows.";
    edit_row(actions, "Sun", light, Edit::Environment, |l| check_row(ui, "Sun", help, &mut l.sun.enabled));
    let Some(settings) = light.suns() else { return };
    let usual = SunChoice::default();
    let help = "Least brightness of a sun, as a multiple of the map's mean.";
    let threshold = Decades { decimals: 0, ..Decades::count("Threshold", help, 1.0..=1e6, f64::from(usual.threshold)) };
    edit_row(actions, "Threshold of suns", light, Edit::Environment, |l| {
        decades_row(ui, &threshold, &mut l.sun.threshold)
    });
    let help = "Largest angular diameter of a sun. Larger lights stay in the map.";
    let largest = Number::new("Largest angle", help, 0.1..=90.0, usual.largest_degrees).unit("°", 1);
    edit_row(actions, "Largest angle of suns", light, Edit::Environment, |l| {
        slider_row(ui, &largest, &mut l.sun.largest_degrees)
    });
    if let Some(environment) = context.environment {
        ui.label(RichText::new(suns_text(&environment.suns(settings).suns)).weak());
    }
}

/// The ground under the scene.
fn ground(ui: &mut Ui, context: &EnvironmentContext, actions: &mut Vec<Action>) {
    let bake = &context.document.bake;
    let kinds = [
        (Ground::Off, "None", "No ground: light also reaches the scene from below."),
        (
            Ground::Shadow,
            "Shadow",
            "An invisible ground catches shadows and bounced light over the background, or in the alpha channel.",
        ),
        (Ground::On, "Surface", "A visible ground with its own material."),
    ];
    let wrap = |bake: BakeSettings| Edit::Bake(Box::new(bake));
    edit_row(actions, "Ground", bake, wrap, |bake| {
        combo_row(ui, "Ground", "Plane under the scene, baked with it.", &mut bake.ground, &kinds)
    });
    if context.lacks_ground && bake.ground != Ground::Off {
        let text = "This bake has no ground. Open its scene file to bake one.";
        ui.label(RichText::new(text).color(ui.visuals().warn_fg_color));
    }
}

/// Number of suns, and size of the brightest.
fn suns_text(suns: &[Sun]) -> String {
    let size = |sun: &Sun| format!("{:.1}°", sun.angle.to_degrees());
    match suns {
        [] => "This map has no sun.".into(),
        [sun] => format!("One sun, {} wide.", size(sun)),
        [sun, ..] => format!("{} suns, the brightest {} wide.", suns.len(), size(sun)),
    }
}

/// An angle in degrees from -180 to 180.
fn wrapped(degrees: f32) -> f32 {
    if degrees.abs() <= 180.0 { degrees } else { (degrees + 180.0).rem_euclid(360.0) - 180.0 }
}

fn stops_text(intensity: f32) -> String {
    if intensity > 0.0 { format!("{:+.1} EV", intensity.log2()) } else { "off".into() }
}

/// The parameters of the map's formula, if it has one.
fn formula(ui: &mut Ui, light: &EnvironmentSettings, actions: &mut Vec<Action>) {
    if let Some(now) = sun_elevation(&light.spec) {
        let elevation = Number::new("Sun height", "Degrees above the horizon.", 0.0..=90.0, SUN_ELEVATION);
        let elevation = elevation.unit("°", 1);
        spec_row(actions, "Sun height", light, |spec| {
            let mut degrees = now;
            let edited = slider_row(ui, &elevation, &mut degrees);
            if edited.changed {
                *spec = format!("sun-sky:{}", (10.0 * degrees).round() / 10.0);
            }
            edited
        });
    }
    if let Some(now) = constant_radiance(&light.spec) {
        spec_row(actions, "Constant color", light, |spec| {
            let mut color = now;
            let edited = color_row(ui, "Color", "Same radiance from all directions.", &mut color, Vec3::ONE);
            if edited.changed {
                let [r, g, b] = color.to_array().map(|c| (1e4 * c).round() / 1e4);
                *spec = format!("constant:{r},{g},{b}");
            }
            edited
        });
    }
}

fn spec_row(
    actions: &mut Vec<Action>,
    label: &'static str,
    light: &EnvironmentSettings,
    row: impl FnOnce(&mut String) -> Edited,
) {
    edit_row(actions, label, light, Edit::Environment, |l| row(&mut l.spec));
}

/// The sun's elevation in degrees, if the specification is a sun and sky.
fn sun_elevation(spec: &str) -> Option<f32> {
    match spec.split_once(':') {
        Some(("sun-sky", degrees)) => Some(degrees.trim().parse().unwrap_or(SUN_ELEVATION)),
        None if spec == "sun-sky" => Some(SUN_ELEVATION),
        _ => None,
    }
}

/// The radiance, if the specification is a constant.
fn constant_radiance(spec: &str) -> Option<Vec3> {
    let Some(("constant", numbers)) = spec.split_once(':') else {
        return (spec == "constant").then_some(Vec3::ONE);
    };
    let numbers: Option<Vec<f32>> = numbers.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers?[..] {
        [gray] => Some(Vec3::splat(gray)),
        [r, g, b] => Some(Vec3::new(r, g, b)),
        _ => None,
    }
}
