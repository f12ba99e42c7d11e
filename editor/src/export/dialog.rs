//! The dialog for an image sequence: turntable, swept parameters, frames and output folder.

use crate::widgets::{check_box, copyable};
use anyhow::{Result, bail};
use egui::{Button, ComboBox, Context, DragValue, Grid, Modal, RichText, TextEdit, Ui};
use glam::Vec3;
use lapidary_core::brdf::BrdfModel;
use lapidary_render::Look;
use lapidary_studies::{
    export::{LayerList, wanted_layers},
    sequence::{
        Domain, Existing, FrameNames, Parameter, SequenceSettings, SequenceTask, SheetTask, Sweep, Target, Turn, Value,
        plan,
    },
};
use std::path::{Path, PathBuf};

/// Width of the dialog in points.
const WIDTH: f32 = 500.0;
/// Width of fields for paths and names in points.
const FIELD: f32 = 290.0;
/// Time of all layers over the picture's alone: 29 s over 8 s, measured on the still life.
const LAYERS: f64 = 3.8;
/// Name of the contact sheet in the folder of the frames.
const SHEET: &str = "contact-sheet.png";

/// The sequence being described.
#[derive(Clone, Debug)]
pub struct SequenceDialog {
    settings: SequenceSettings,
    size: [u32; 2],
    samples: u32,
    png: bool,
    exr: bool,
    layers: bool,
    sheet: bool,
    existing: Existing,
    /// Folder of the frames.
    pub folder: String,
    name: String,
    /// Why it cannot be exported.
    pub problem: Option<String>,
}

/// The answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SequenceAnswer {
    /// Begin.
    Export,
    /// Ask for the folder.
    ChooseFolder,
    /// Leave it.
    Cancel,
}

impl SequenceDialog {
    /// A turntable of a look, whose camera goes around the scene, in `folder`.
    pub fn new(look: &Look, folder: &Path) -> Self {
        Self {
            settings: SequenceSettings { turn: Some(Turn::Camera), ..Default::default() },
            size: look.view.size,
            samples: look.view.aa,
            png: true,
            exr: false,
            layers: false,
            sheet: true,
            existing: Existing::Refuse,
            folder: folder.join("sequence").display().to_string(),
            name: "frame.####".into(),
            problem: None,
        }
    }

    /// The described sequence of a look.
    ///
    /// # Errors
    /// The problem, in words.
    pub fn task(&self, look: &Look) -> Result<SequenceTask> {
        let mut look = look.clone();
        (look.view.size, look.view.aa) = (self.size, self.samples);
        let folder = PathBuf::from(self.folder.trim());
        if self.folder.trim().is_empty() {
            bail!("the frames need a folder; choose one");
        }
        let formats = [("png", self.png), ("exr", self.exr)].into_iter().filter(|(_, wanted)| *wanted);
        let name = |extension| folder.join(format!("{}.{extension}", self.name.trim()));
        let outputs = formats.map(|(e, _)| FrameNames::new(&name(e))).collect::<Result<Vec<_>>>()?;
        if outputs.is_empty() {
            bail!("no format is chosen; choose PNG, EXR or both");
        }
        let list = (self.exr && self.layers).then_some(LayerList::All);
        let layers = wanted_layers(list.as_ref(), &look)?;
        let frames = plan(&look, &self.settings)?;
        let sheet = self.sheet.then(|| SheetTask { path: folder.join(SHEET), columns: None });
        Ok(SequenceTask { frames, outputs, layers, existing: self.existing, sheet })
    }

    /// Shows the dialog; `pixel_secs` is the time of a sample of a pixel, if known.
    pub fn show(&mut self, ctx: &Context, look: &Look, pixel_secs: Option<f64>) -> Option<SequenceAnswer> {
        let modal = Modal::new(egui::Id::unique("sequence")).show(ctx, |ui| {
            ui.set_width(WIDTH);
            ui.heading("Export a sequence");
            ui.add_space(6.0);
            let grid = Grid::new("sequence fields").num_columns(2).spacing([14.0, 7.0]);
            let chosen = grid.show(ui, |ui| {
                self.turn_row(ui);
                self.sweep_rows(ui, look);
                self.frame_rows(ui);
                self.file_rows(ui)
            });
            ui.add_space(6.0);
            ui.weak(self.estimate(pixel_secs));
            if let Some(problem) = &self.problem {
                copyable(ui, RichText::new(problem).color(ui.visuals().error_fg_color));
            }
            buttons(ui).or(chosen.inner)
        });
        modal.inner.or(modal.should_close().then_some(SequenceAnswer::Cancel))
    }

    fn turn_row(&mut self, ui: &mut Ui) {
        ui.label("Turn");
        ui.horizontal(|ui| {
            let combo = ComboBox::from_id_salt("turn").selected_text(turn_name(self.settings.turn)).width(150.0);
            let combo = combo.show_ui(ui, |ui| {
                for turn in std::iter::once(None).chain(Turn::ALL.map(Some)) {
                    ui.selectable_value(&mut self.settings.turn, turn, turn_name(turn)).on_hover_text(turn_help(turn));
                }
            });
            combo.response.accessible_name("Turntable subject").on_hover_text(turn_help(self.settings.turn));
            let degrees = DragValue::new(&mut self.settings.degrees).range(-3600.0..=3600.0).suffix("°");
            ui.add_enabled(self.settings.turn.is_some(), degrees)
                .accessible_name("Degrees")
                .on_hover_text("How far, counter-clockwise seen from above; 360° loops");
        });
        ui.end_row();
    }

    fn sweep_rows(&mut self, ui: &mut Ui, look: &Look) {
        let mut removed = None;
        for (i, sweep) in self.settings.sweeps.iter_mut().enumerate() {
            ui.label(if i == 0 { "Sweep" } else { "" });
            ui.push_id(i, |ui| {
                if sweep_fields(ui, sweep, look) {
                    removed = Some(i);
                }
            });
            ui.end_row();
        }
        if let Some(i) = removed {
            self.settings.sweeps.remove(i);
        }
        ui.label(if self.settings.sweeps.is_empty() { "Sweep" } else { "" });
        if ui.button("Add a sweep").on_hover_text("Add a parameter that changes over the frames").clicked() {
            self.settings.sweeps.push(new_sweep(Parameter::Brdf("roughness"), look));
        }
        ui.end_row();
    }

    fn frame_rows(&mut self, ui: &mut Ui) {
        ui.label("Frames");
        ui.horizontal(|ui| {
            ui.add(DragValue::new(&mut self.settings.frames).range(1..=108_000)).accessible_name("Frame count");
            ui.label("from number");
            ui.add(DragValue::new(&mut self.settings.first).range(0..=9_999_999)).accessible_name("First frame");
        });
        ui.end_row();
        ui.label("Size");
        ui.horizontal(|ui| {
            let [width, height] = &mut self.size;
            ui.add(DragValue::new(width).range(1..=16_384)).accessible_name("Frame width");
            ui.label("x");
            ui.add(DragValue::new(height).range(1..=16_384)).accessible_name("Frame height");
            ui.label("pixels,");
            ui.add(DragValue::new(&mut self.samples).range(1..=256)).accessible_name("Frame samples");
            ui.label("samples each");
        });
        ui.end_row();
    }

    fn file_rows(&mut self, ui: &mut Ui) -> Option<SequenceAnswer> {
        ui.label("Format");
        ui.horizontal(|ui| {
            check_box(ui, &mut self.png, "PNG").on_hover_text("As displayed");
            check_box(ui, &mut self.exr, "EXR").on_hover_text("Scene-linear, 32-bit float");
            ui.add_enabled_ui(self.exr, |ui| {
                check_box(ui, &mut self.layers, "with layers").on_hover_text(
                    "Write parts of the light, surface data and work as layers; takes about four times as long",
                );
            });
            check_box(ui, &mut self.sheet, "Contact sheet")
                .on_hover_text(format!("All frames in one picture, {SHEET}"));
        });
        ui.end_row();
        ui.label("Folder");
        let chosen = ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut self.folder).desired_width(FIELD);
            ui.add(field).accessible_name("Folder of the frames");
            ui.button("Choose...").clicked().then_some(SequenceAnswer::ChooseFolder)
        });
        ui.end_row();
        ui.label("Name");
        let field = TextEdit::singleline(&mut self.name).desired_width(FIELD);
        ui.add(field).accessible_name("Name of the frames").on_hover_text("#### becomes the frame number");
        ui.end_row();
        ui.label("Existing files");
        ui.horizontal(|ui| {
            for (choice, name, help) in [
                (Existing::Refuse, "Stop", "Stop if any frame already exists"),
                (Existing::Resume, "Keep", "Keep existing frames and render the rest"),
                (Existing::Overwrite, "Replace", "Render all frames again"),
            ] {
                ui.selectable_value(&mut self.existing, choice, name).on_hover_text(help);
            }
        });
        ui.end_row();
        chosen.inner
    }

    /// Number of frames, and their time at the pace of the window's picture.
    fn estimate(&self, pixel_secs: Option<f64>) -> String {
        let frames = self.settings.frames;
        let pixels = f64::from(self.size[0]) * f64::from(self.size[1]) * f64::from(self.samples) * f64::from(frames);
        let layers = if self.exr && self.layers { LAYERS } else { 1.0 };
        let time = pixel_secs.map(|secs| format!(", about {}", duration(secs * pixels * layers)));
        format!("{frames} frames of {} x {} pixels{}", self.size[0], self.size[1], time.unwrap_or_default())
    }
}

/// Seconds in the unit that fits.
pub fn duration(secs: f64) -> String {
    match secs {
        secs if secs < 90.0 => format!("{:.0} s", secs.max(1.0)),
        secs if secs < 5400.0 => format!("{:.0} min", secs / 60.0),
        secs => format!("{:.1} h", secs / 3600.0),
    }
}

fn turn_name(turn: Option<Turn>) -> &'static str {
    match turn {
        None => "Nothing",
        Some(Turn::Object) => "Object",
        Some(Turn::Camera) => "Camera",
        Some(Turn::Environment) => "Environment",
        Some(Turn::Lights) => "Local lights",
    }
}

fn turn_help(turn: Option<Turn>) -> &'static str {
    match turn {
        None => "Change swept parameters only",
        Some(Turn::Object) => "Turn the whole baked scene under fixed camera and lights",
        Some(Turn::Camera) => "Orbit the camera around its target",
        Some(Turn::Environment) => "Turn the environment",
        Some(Turn::Lights) => "Turn the local lights around the camera's target",
    }
}

fn buttons(ui: &mut Ui) -> Option<SequenceAnswer> {
    ui.add_space(10.0);
    let mut answer = None;
    ui.horizontal(|ui| {
        for (text, meaning) in [("Export", SequenceAnswer::Export), ("Cancel", SequenceAnswer::Cancel)] {
            if ui.add(Button::new(text).min_size([84.0, 24.0].into())).clicked() {
                answer = Some(meaning);
            }
        }
    });
    answer
}

/// Shows one sweep; returns whether to remove it.
fn sweep_fields(ui: &mut Ui, sweep: &mut Sweep, look: &Look) -> bool {
    let mut parameter = sweep.parameter;
    let removed = ui.vertical(|ui| {
        let removed = ui.horizontal(|ui| {
            let combo = ComboBox::from_id_salt("parameter").selected_text(words(parameter)).width(130.0);
            let combo = combo.height(400.0).show_ui(ui, |ui| {
                for choice in Parameter::all().filter(|choice| choice.applies_to(look)) {
                    ui.selectable_value(&mut parameter, choice, words(choice));
                }
            });
            combo.response.accessible_name("Swept parameter");
            owner(ui, sweep, look);
            let is_number = matches!(sweep.parameter.domain(), Domain::Number(..));
            ui.add_enabled_ui(is_number, |ui| {
                check_box(ui, &mut sweep.logarithmic, "log").on_hover_text("Equal ratios instead of equal steps");
            });
            ui.button("Remove").clicked()
        });
        ui.horizontal(|ui| {
            value_fields(ui, sweep.parameter, &mut sweep.from, "From");
            ui.label("to");
            value_fields(ui, sweep.parameter, &mut sweep.to, "To");
        });
        removed.inner
    });
    if parameter != sweep.parameter {
        *sweep = new_sweep(parameter, look);
    }
    removed.inner
}

/// The swept material or light.
fn owner(ui: &mut Ui, sweep: &mut Sweep, look: &Look) {
    let names: Vec<&str> = match sweep.parameter.target() {
        Target::Material => look.appearance.materials.iter().map(|m| m.name.as_str()).collect(),
        Target::Light => look.lights.iter().map(|light| light.name.as_str()).collect(),
        Target::Picture => return,
    };
    let all = if sweep.parameter.target() == Target::Material { "all materials" } else { "all lights" };
    let shown = sweep.of.as_deref().unwrap_or(all).to_owned();
    let combo = ComboBox::from_id_salt("owner").selected_text(shown).width(110.0).show_ui(ui, |ui| {
        ui.selectable_value(&mut sweep.of, None, all);
        for name in names.into_iter().filter(|name| !name.is_empty()) {
            ui.selectable_value(&mut sweep.of, Some(name.to_owned()), name);
        }
    });
    combo.response.accessible_name("Swept material or light");
}

fn value_fields(ui: &mut Ui, parameter: Parameter, value: &mut Value, name: &str) {
    let mut parts = value.vector().to_array();
    let (range, count) = match parameter.domain() {
        Domain::Number(low, high) => (low..=high, 1),
        Domain::Color => (0.0..=1.0, 3),
        Domain::Place => (-1e5..=1e5, 3),
    };
    let speed =
        if parameter.domain() == Domain::Place { 0.02 } else { 0.002 * (range.end() - range.start()).min(200.0) };
    for (i, part) in parts.iter_mut().take(count).enumerate() {
        let entry = DragValue::new(part).range(range.clone()).speed(speed).max_decimals(3);
        let axis = if count == 1 { String::new() } else { format!(" {}", ["x", "y", "z"][i]) };
        ui.add(entry).accessible_name(format!("{name}{axis}"));
    }
    *value = if count == 1 { Value::Number(parts[0]) } else { Value::Vector(parts.into()) };
}

/// "light-position" in words.
fn words(parameter: Parameter) -> String {
    let text = parameter.name().replace('-', " ");
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().collect::<String>() + letters.as_str()).unwrap_or_default()
}

/// A sweep over the usual range of a parameter, or from its present value.
fn new_sweep(parameter: Parameter, look: &Look) -> Sweep {
    let light = look.lights.first();
    let from_to = |from: f32, to: f32| (Value::Number(from), Value::Number(to));
    let moved = |place: Vec3| (Value::Vector(place), Value::Vector(place + 0.5 * Vec3::X));
    let camera = &look.view.camera;
    let (from, to) = match parameter {
        Parameter::Brdf("roughness") => from_to(0.05, 0.8),
        Parameter::Brdf("anisotropy") => from_to(-0.9, 0.9),
        Parameter::Brdf(name) => match BrdfModel::declared(name) {
            Some(p) if !p.is_color() => from_to(p.slider[0], p.slider[1]),
            _ => (Value::Vector(Vec3::splat(0.1)), Value::Vector(Vec3::splat(0.9))),
        },
        Parameter::Bump => from_to(0.0, 0.005),
        Parameter::Normal => from_to(0.0, 1.0),
        Parameter::Rotation => from_to(0.0, 180.0),
        Parameter::Intensity | Parameter::LightIntensity => from_to(0.25, 4.0),
        Parameter::Exposure => from_to(-2.0, 2.0),
        Parameter::IllumCut => from_to(1.0, 512.0),
        Parameter::LitCuts => from_to(0.001, 1.0),
        Parameter::Fov => from_to(camera.fov_y.to_degrees(), 0.5 * camera.fov_y.to_degrees()),
        Parameter::LightPosition => moved(light.map_or(Vec3::Y, |light| light.position)),
        Parameter::LightTarget => moved(light.map_or(Vec3::ZERO, |light| light.target)),
        Parameter::Eye => moved(camera.eye),
        Parameter::Target => moved(camera.target),
    };
    let of = (look.lights.len() > 1).then(|| light.map(|light| light.name.clone())).flatten();
    let moves_light = matches!(parameter, Parameter::LightPosition | Parameter::LightTarget);
    Sweep {
        parameter,
        of: of.filter(|_| moves_light),
        from,
        to,
        logarithmic: matches!(parameter, Parameter::IllumCut | Parameter::LitCuts),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_render::{BrdfSampling, test_looks::look as test_look};

    #[test]
    fn every_sweep_that_is_proposed_makes_a_sequence() {
        let [lit, refined] = [BrdfSampling::Lit, BrdfSampling::Refine].map(|sampling| Look { sampling, ..test_look() });
        let proposed = |look: &Look| Parameter::all().filter(|p| p.applies_to(look)).collect::<Vec<_>>();
        assert!(!proposed(&lit).contains(&Parameter::IllumCut) && !proposed(&refined).contains(&Parameter::LitCuts));
        let each = |look| proposed(look).into_iter().map(move |parameter| (look, parameter));
        for (look, parameter) in [&lit, &refined].into_iter().flat_map(each) {
            let mut dialog = SequenceDialog::new(look, Path::new("/scenes"));
            dialog.settings.turn = None;
            dialog.settings.sweeps = vec![new_sweep(parameter, look)];
            let task = dialog.task(look).unwrap();
            assert_eq!((task.frames.len(), task.outputs.len()), (48, 1), "{parameter:?}");
        }
    }

    #[test]
    fn what_makes_no_sequence_is_told_in_words() {
        let look = test_look();
        let dialog = SequenceDialog::new(&look, Path::new("/scenes"));
        assert!(dialog.task(&look).is_ok(), "negative control");
        let problem = |change: &dyn Fn(&mut SequenceDialog)| {
            let mut dialog = dialog.clone();
            change(&mut dialog);
            dialog.task(&look).unwrap_err().to_string()
        };
        assert!(problem(&|d| d.png = false).contains("no format"));
        assert!(problem(&|d| d.folder = "  ".into()).contains("folder"));
        assert!(problem(&|d| d.name = "frame".into()).contains("####"));
        assert!(problem(&|d| d.settings.turn = None).contains("nothing changes"));
    }

    #[test]
    fn times_are_in_the_unit_that_fits() {
        assert_eq!([0.2, 45.0, 600.0, 7200.0].map(duration), ["1 s", "45 s", "10 min", "2.0 h"]);
    }
}
