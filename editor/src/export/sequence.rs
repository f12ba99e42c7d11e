//! The dialog for an image sequence: turntable, swept parameters, frames and output folder.

use super::output::{Answer, Output, dialog, footer, rows};
use crate::widgets::check_box;
use anyhow::{Result, bail};
use egui::{ComboBox, Context, DragValue, Ui};
use glam::Vec3;
use lapidary_core::brdf::BrdfModel;
use lapidary_render::{Baked, Look};
use lapidary_studies::{
    export::wanted_layers,
    sequence::{
        Domain, Existing, FrameNames, Parameter, SequenceSettings, SequenceTask, SheetTask, Spin, Sweep, Target, Turn,
        Value, blocked_frames, blocked_words, plan,
    },
};
use std::path::Path;

/// Name of the contact sheet in the folder of the frames.
const SHEET: &str = "contact-sheet.png";

/// The sequence being described.
#[derive(Clone, Debug)]
pub struct SequenceDialog {
    settings: SequenceSettings,
    /// The selected object, which may turn alone, and its name.
    selected: Option<(String, Spin)>,
    /// Black frames that were told; the next answer takes them as they are.
    told: Vec<u32>,
    /// The frames.
    pub output: Output,
    sheet: bool,
    existing: Existing,
    /// Why it cannot be exported.
    pub problem: Option<String>,
}

impl SequenceDialog {
    /// A turntable of a look, whose camera goes around the scene, in `folder`.
    pub fn new(look: &Look, folder: &Path, selected: Option<(String, Spin)>) -> Self {
        Self {
            settings: SequenceSettings { turn: Some(Turn::Camera), ..Default::default() },
            selected,
            told: Vec::new(),
            output: Output::new(look.view.size, look.view.aa, folder.join("sequence"), "frame.####"),
            sheet: true,
            existing: Existing::Refuse,
            problem: None,
        }
    }

    /// The described sequence of a look.
    ///
    /// # Errors
    /// The problem, in words.
    pub fn task(&self, look: &Look) -> Result<SequenceTask> {
        let (mut look, output) = (look.clone(), &self.output);
        (look.view.size, look.view.aa) = (output.size, output.samples);
        let folder = output.folder()?;
        let name = |extension| folder.join(format!("{}.{extension}", output.name.trim()));
        let outputs = output.formats()?.into_iter().map(|format| FrameNames::new(&name(format)));
        let outputs = outputs.collect::<Result<Vec<_>>>()?;
        let layers = wanted_layers(output.layers().as_ref(), &look)?;
        let frames = plan(&look, &self.settings)?;
        let sheet = self.sheet.then(|| SheetTask { path: folder.join(SHEET), columns: None });
        Ok(SequenceTask { frames, outputs, layers, existing: self.existing, sheet })
    }

    /// Says before which frames of a task are black, once.
    ///
    /// # Errors
    /// There are such frames, and they were not told yet.
    pub fn tell_black_frames(&mut self, task: &SequenceTask, baked: &Baked) -> Result<()> {
        let black = blocked_frames(&task.frames, baked);
        let told = std::mem::replace(&mut self.told, black);
        match blocked_words(&self.told, task.frames.len()).filter(|_| told != self.told) {
            Some(words) => bail!("{words}. Or export again to have them black"),
            None => Ok(()),
        }
    }

    /// Shows the dialog; `pixel_secs` is the time of a sample of a pixel, if known.
    pub fn show(&mut self, ctx: &Context, look: &Look, pixel_secs: Option<f64>) -> Option<Answer> {
        dialog(ctx, "Export a sequence", |ui| {
            let chosen = rows(ui, "sequence fields", |ui| {
                self.turn_row(ui);
                self.sweep_rows(ui, look);
                self.frame_rows(ui);
                self.file_rows(ui)
            });
            let frames = self.settings.frames;
            let estimate = format!("{frames} frames of {}", self.output.estimate(frames, pixel_secs));
            footer(ui, &estimate, self.problem.as_deref()).or(chosen)
        })
    }

    fn turn_row(&mut self, ui: &mut Ui) {
        ui.label("Turn");
        ui.horizontal(|ui| {
            let name = match (&self.selected, self.settings.spin) {
                (Some((name, _)), Some(_)) => name.as_str(),
                _ => turn_name(self.settings.turn),
            };
            let before = (self.settings.turn, self.settings.spin);
            let combo = ComboBox::from_id_salt("turn").selected_text(name).width(150.0);
            let combo = combo.show_ui(ui, |ui| {
                for turn in std::iter::once(None).chain(Turn::ALL.map(Some)) {
                    let chosen = ui.selectable_label(before == (turn, None), turn_name(turn));
                    if chosen.on_hover_text(turn_help(turn)).clicked() {
                        (self.settings.turn, self.settings.spin) = (turn, None);
                    }
                }
                if let Some((name, spin)) = &self.selected {
                    let chosen = ui.selectable_label(self.settings.spin.is_some(), format!("{name} alone"));
                    if chosen
                        .on_hover_text("Turn the selected object about its pivot; its shadows are a preview")
                        .clicked()
                    {
                        (self.settings.turn, self.settings.spin) = (Some(Turn::Object), Some(*spin));
                    }
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
            self.output.size_entries(ui, "Frame");
            ui.label("pixels,");
            self.output.samples_entry(ui, "Frame");
            ui.label("samples each");
        });
        ui.end_row();
    }

    fn file_rows(&mut self, ui: &mut Ui) -> Option<Answer> {
        ui.label("Format");
        ui.horizontal(|ui| {
            self.output.format_boxes(ui);
            check_box(ui, &mut self.sheet, "Contact sheet")
                .on_hover_text(format!("All frames in one picture, {SHEET}"));
        });
        ui.end_row();
        let chosen = self.output.place_rows(ui, "frames", "#### becomes the frame number");
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
        chosen
    }
}

fn turn_name(turn: Option<Turn>) -> &'static str {
    match turn {
        None => "Nothing",
        Some(Turn::Object) => "Whole scene",
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
        Parameter::FNumber => from_to(16.0, 1.4),
        Parameter::Focus => from_to(0.5 * camera.focus_distance(), 2.0 * camera.focus_distance()),
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
        logarithmic: matches!(parameter, Parameter::IllumCut | Parameter::LitCuts | Parameter::FNumber),
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
            let mut dialog = SequenceDialog::new(look, Path::new("/scenes"), None);
            dialog.settings.turn = None;
            dialog.settings.sweeps = vec![new_sweep(parameter, look)];
            let task = dialog.task(look).unwrap();
            assert_eq!((task.frames.len(), task.outputs.len()), (48, 1), "{parameter:?}");
        }
    }

    #[test]
    fn what_makes_no_sequence_is_told_in_words() {
        let look = test_look();
        let dialog = SequenceDialog::new(&look, Path::new("/scenes"), None);
        assert!(dialog.task(&look).is_ok(), "negative control");
        let problem = |change: &dyn Fn(&mut SequenceDialog)| {
            let mut dialog = dialog.clone();
            change(&mut dialog);
            dialog.task(&look).unwrap_err().to_string()
        };
        assert!(problem(&|d| d.output.png = false).contains("no format"));
        assert!(problem(&|d| d.output.folder = "  ".into()).contains("folder"));
        assert!(problem(&|d| d.output.name = "frame".into()).contains("####"));
        assert!(problem(&|d| d.settings.turn = None).contains("nothing changes"));
    }
}
