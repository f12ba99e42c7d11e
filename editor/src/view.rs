//! Settings of the picture and its display, and the camera.

pub mod lens;
#[cfg(test)]
mod tests;

use crate::{
    actions::{Action, CameraAction},
    document::{BackgroundKind, Document, Edit, ShownMaterials, ViewSettings},
    viewport::gate::SHAPES,
    widgets::{
        Edited, Number, check_row, choice_row, color_row, edit_row,
        entries::{Decades, combo_row, decades_row, point_row},
        row, section, slider_row,
    },
};
use egui::{Button, Ui};
use lapidary_core::cut::lit::DEFAULT_TAU;
use lapidary_render::{BrdfSampling, ToneMap, ViewMode};
use std::path::Path;

/// Budgets of the illumination cut from the paper's figures and around them.
const CUT_PRESETS: [u32; 6] = [32, 64, 128, 256, 512, 1024];

/// Input of the panel.
pub struct ViewContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// Whether the next click into the viewport focuses the camera.
    pub focusing: bool,
}

/// Shows the panel. It keeps nothing between frames.
pub fn show(ui: &mut Ui, context: &ViewContext, actions: &mut Vec<Action>) {
    let view = &context.document.view;
    section(ui, "Display", true, |ui| {
        display(ui, view, actions);
        vignette(ui, view, actions);
        background(ui, view, actions);
    });
    section(ui, "Picture", true, |ui| picture(ui, view, actions));
    section(ui, "Camera", true, |ui| camera(ui, context, actions));
}

fn display(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let exposure = Number::new("Exposure", "Brightness in stops; each doubles it.", -8.0..=8.0, 0.0);
    let exposure = exposure.unit(" EV", 2).entry(-30.0..=30.0);
    edit_row(actions, "Exposure", view, Edit::View, |v| slider_row(ui, &exposure, &mut v.post.exposure));
    let curves = ToneMap::ALL.map(|t| (t, t.label(), t.curve().summary));
    edit_row(actions, "Tone map", view, Edit::View, |v| {
        combo_row(ui, "Tone map", "Curve that fits bright values to the display.", &mut v.post.tone_map, &curves)
    });
}

fn vignette(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let help = "How much darker what is rendered is toward the corners; at 1 they have a quarter of their light. A picture behind the scene stays as it is.";
    let vignette = Number::new("Vignette", help, 0.0..=1.0, 0.0);
    edit_row(actions, "Vignette", view, Edit::View, |v| slider_row(ui, &vignette, &mut v.post.vignette));
}

fn background(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let kinds = [
        (BackgroundKind::Environment, "Environment", "The environment, sharp."),
        (BackgroundKind::Blurred, "Blurred environment", "The environment, blurred; the light stays as it is."),
        (BackgroundKind::Flat, "Color", "One color."),
        (BackgroundKind::Picture, "Picture", "A picture of your own; a ground that catches shadows darkens it."),
        (BackgroundKind::Transparent, "Transparent", "No background; exported pictures are transparent there."),
    ];
    edit_row(actions, "Background", view, Edit::View, |v| {
        combo_row(ui, "Background", "Shown where there is no surface.", &mut v.background, &kinds)
    });
    match view.background {
        BackgroundKind::Blurred => {
            let blur = Number::new("Blur", "Width of the blur in degrees.", 3.0..=60.0, 8.0).unit("°", 1);
            edit_row(actions, "Background blur", view, Edit::View, |v| slider_row(ui, &blur, &mut v.blur_degrees));
        }
        BackgroundKind::Flat => {
            let default = ViewSettings::default().background_color;
            edit_row(actions, "Background color", view, Edit::View, |v| {
                color_row(ui, "Color", "Scene-linear color; exposure applies to it.", &mut v.background_color, default)
            });
        }
        BackgroundKind::Picture => {
            let name = view.backplate.as_deref().and_then(Path::file_name);
            let label = name.map_or("Choose...".into(), |name| name.to_string_lossy().into_owned());
            if ui.add(Button::new(label).truncate()).on_hover_text("Choose the picture behind the scene").clicked() {
                actions.push(Action::Camera(CameraAction::Backplate(None)));
            }
        }
        BackgroundKind::Environment | BackgroundKind::Transparent => {}
    }
}

fn picture(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let modes = ViewMode::ALL.map(|m| (m, m.label(), view_mode_meaning(m)));
    edit_row(actions, "View mode", view, Edit::View, |v| {
        combo_row(ui, "Show", "Quantity that the pixels show.", &mut v.mode, &modes)
    });
    basis(ui, view, actions);
    let materials = [
        (ShownMaterials::Own, "Original", "Each surface with its own material."),
        (ShownMaterials::Clay, "Clay", "Gray clay on all, to judge light and shape."),
        (ShownMaterials::Gray, "Middle gray", "Albedo 0.18 on all, to judge exposure."),
        (ShownMaterials::Chrome, "Chrome", "A mirror on all, to judge reflections and smoothness."),
    ];
    let solo = matches!(view.materials, ShownMaterials::Solo(_)).then_some((
        view.materials,
        "Solo",
        "One material shown, the others as clay.",
    ));
    let materials: Vec<_> = materials.into_iter().chain(solo).collect();
    edit_row(actions, "Shown materials", view, Edit::View, |v| {
        let help = "Replaces all materials in the picture, not in the scene.";
        combo_row(ui, "Materials", help, &mut v.materials, &materials)
    });
    edit_row(actions, "Mirrors", view, Edit::View, |v| {
        let help = "Sharp reflections show the scene, along a ray for each sample; else the environment alone.";
        check_row(ui, "Mirrors", help, &mut v.mirrors)
    });
    edit_row(actions, "Wireframe", view, Edit::View, |v| {
        check_row(ui, "Wireframe", "Draws the edges of the baked triangles.", &mut v.wireframe)
    });
    let samplings = [
        (BrdfSampling::Lit, "Lit", "Merge lit cuts, refined toward highlights: fast and sharp."),
        (BrdfSampling::Refine, "Refined", "Merge stored cuts and the light cut, refined toward highlights."),
        (
            BrdfSampling::Once,
            "Paper",
            "Merge stored cuts and the light cut, one BRDF sample per node: highlights may break up.",
        ),
    ];
    edit_row(actions, "BRDF sampling", view, Edit::View, |v| {
        choice_row(ui, "Cuts", "Cuts to merge, and how to sample the BRDF on their nodes.", &mut v.sampling, &samplings)
    });
    match view.sampling {
        BrdfSampling::Lit => lit_cuts(ui, view, actions),
        BrdfSampling::Refine | BrdfSampling::Once => illumination_cut(ui, view, actions),
    }
    let samples =
        Decades::count("Samples", "Jittered samples per pixel, averaged at rest, 1 to 256.", 1.0..=256.0, 16.0);
    edit_row(actions, "Samples", view, Edit::View, |v| decades_row(ui, &samples, &mut v.aa));
    let help = "Milliseconds until a change is visible; the detail of the light adapts to it.";
    let budget = Decades { unit: " ms", ..Decades::count("Frame budget", help, 5.0..=2000.0, 100.0) };
    edit_row(actions, "Frame budget", view, Edit::View, |v| decades_row(ui, &budget, &mut v.frame_budget_ms));
}

/// The level and function of the meshless basis to show.
fn basis(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let level = Decades::count("Level", "Level of the meshless basis; 0 is the coarsest.", 0.0..=7.0, 0.0);
    let function = Decades::count("Function", "Number of the function, coarsest first.", 0.0..=1e6, 0.0);
    match view.mode {
        ViewMode::BasisLevel => {
            edit_row(actions, "Level", view, Edit::View, |v| decades_row(ui, &level, &mut v.basis.level));
        }
        ViewMode::BasisFunction => {
            edit_row(actions, "Function", view, Edit::View, |v| decades_row(ui, &function, &mut v.basis.function));
        }
        _ => {}
    }
}

fn view_mode_meaning(mode: ViewMode) -> &'static str {
    match mode {
        ViewMode::Shaded => "The lit picture.",
        ViewMode::Normals => "Shading normals after bump and normal maps.",
        ViewMode::Albedo => "Base color after its map.",
        ViewMode::Roughness => "Roughness after its map.",
        ViewMode::VisibilityCut => {
            "Nodes of the baked visibility cuts, which take the memory. Bounced light if the environment was not baked."
        }
        ViewMode::MergedCut => "Nodes of the merged cuts of environment and bounced light, which take the time.",
        ViewMode::BrdfEvaluations => "BRDF evaluations per pixel.",
        ViewMode::BasisLevel => "Light that one level of the meshless basis adds or subtracts.",
        ViewMode::BasisFunction => "One function of the meshless basis.",
        ViewMode::BasisCoefficients => "The functions of the meshless basis that carry light, by level.",
        ViewMode::Gloss => "Light that glossy surfaces send to others, over diffuse ones.",
    }
}

fn lit_cuts(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let help = "Largest share of a vertex's light that one node of its cut may displace, 0.0001 to 1. Smaller is finer and slower.";
    let default = DEFAULT_TAU.into();
    let tau = Decades { decimals: 4, ..Decades::count("Lit cut error", help, 1e-4..=1.0, default) };
    edit_row(actions, "Lit cut error", view, Edit::View, |v| decades_row(ui, &tau, &mut v.tau));
}

fn illumination_cut(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let help = "Most nodes of the illumination cut, 1 to 32,768. More give sharper shadows and take longer.";
    let cut = Decades::count("Light cut", help, 1.0..=32_768.0, 256.0);
    edit_row(actions, "Light cut", view, Edit::View, |v| decades_row(ui, &cut, &mut v.illum_cut));
    edit_row(actions, "Light cut", view, Edit::View, |v| {
        row(ui, "", help, false, |ui, _, _| {
            ui.spacing_mut().item_spacing.x = 1.0;
            ui.spacing_mut().button_padding.x = 3.0;
            let before = v.illum_cut;
            for preset in CUT_PRESETS {
                let button = ui.add(Button::selectable(before == preset, preset.to_string()).small());
                if button.accessible_name(format!("Light cut {preset}")).clicked() {
                    v.illum_cut = preset;
                }
            }
            Edited::at_once(v.illum_cut != before)
        })
    });
}

/// The shape of the pictures, and its safe parts.
fn shape(ui: &mut Ui, view: &ViewSettings, actions: &mut Vec<Action>) {
    let help =
        "Width over height of the pictures to deliver. The viewport takes it on, so that it shows all that they will.";
    edit_row(actions, "Shape", view, Edit::View, |v| combo_row(ui, "Shape", help, &mut v.aspect, &SHAPES));
    let help = "Lines around the parts of the picture that all screens show, and in which titles belong.";
    edit_row(actions, "Safe frames", view, Edit::View, |v| check_row(ui, "Safe frames", help, &mut v.safe_frames));
}

fn camera(ui: &mut Ui, context: &ViewContext, actions: &mut Vec<Action>) {
    let mut camera = context.document.camera.clone();
    shape(ui, &context.document.view, actions);
    let mut edited = lens::show(ui, &mut camera, context, actions);
    edited |= point_row(ui, "Position", "Position of the camera in meters.", &mut camera.eye);
    edited |= point_row(ui, "Target", "Point that the camera looks at and orbits, in meters.", &mut camera.target);
    // A camera at its own target has no direction.
    if edited.changed && camera.eye.distance(camera.target) > 1e-6 && camera.is_valid() {
        actions.push(Action::Camera(CameraAction::To(camera)));
    }
}
