//! What dialogs of exports share: size, samples, formats and place of the files, and the frame around their rows.

use crate::widgets::{check_box, copyable};
use anyhow::{Result, bail};
use egui::{Button, Context, DragValue, Grid, Id, Modal, RichText, TextEdit, Ui};
use lapidary_studies::export::LayerList;
use std::path::PathBuf;

/// Width of a dialog in points.
const WIDTH: f32 = 520.0;
/// Width of fields for paths and names in points.
const FIELD: f32 = 290.0;
/// Time of all layers over the picture's alone: 29 s over 8 s, measured on the still life.
const LAYERS: f64 = 3.8;

/// The answer to a dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Begin.
    Export,
    /// Ask for the folder.
    ChooseFolder,
    /// Leave it.
    Cancel,
}

/// Files to write.
#[derive(Clone, Debug)]
pub struct Output {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples: u32,
    pub png: bool,
    pub exr: bool,
    /// Whether exr files have layers.
    pub layers: bool,
    /// The folder, as it is typed.
    pub folder: String,
    /// The name of the files, without extension.
    pub name: String,
}

impl Output {
    /// PNG files of this size.
    pub fn new(size: [u32; 2], samples: u32, folder: PathBuf, name: &str) -> Self {
        let folder = folder.display().to_string();
        Self { size, samples, png: true, exr: false, layers: false, folder, name: name.into() }
    }

    /// The folder.
    ///
    /// # Errors
    /// None is typed.
    pub fn folder(&self) -> Result<PathBuf> {
        match self.folder.trim() {
            "" => bail!("the pictures need a folder; choose one"),
            folder => Ok(folder.into()),
        }
    }

    /// Extensions of the chosen formats.
    ///
    /// # Errors
    /// None is chosen.
    pub fn formats(&self) -> Result<Vec<&'static str>> {
        let formats = [("png", self.png), ("exr", self.exr)].into_iter();
        let chosen: Vec<_> = formats.filter_map(|(format, wanted)| wanted.then_some(format)).collect();
        match chosen.is_empty() {
            true => bail!("no format is chosen; choose PNG, EXR or both"),
            false => Ok(chosen),
        }
    }

    /// Layers of exr files.
    pub fn layers(&self) -> Option<LayerList> {
        (self.exr && self.layers).then_some(LayerList::All)
    }

    /// The size and, if a sample of a pixel is known to take so long, the time of some pictures, in words.
    pub fn estimate(&self, pictures: u32, pixel_secs: Option<f64>) -> String {
        let [width, height] = self.size;
        let samples = [width, height, self.samples, pictures].map(f64::from).iter().product::<f64>();
        let layers = if self.layers().is_some() { LAYERS } else { 1.0 };
        let time = pixel_secs.map(|secs| format!(", about {}", duration(secs * samples * layers)));
        format!("{width} x {height} pixels{}", time.unwrap_or_default())
    }

    /// Entries for the size of a frame or a picture.
    pub fn size_entries(&mut self, ui: &mut Ui, of: &str) {
        let [width, height] = &mut self.size;
        ui.add(DragValue::new(width).range(1..=16_384)).accessible_name(format!("{of} width"));
        ui.label("x");
        ui.add(DragValue::new(height).range(1..=16_384)).accessible_name(format!("{of} height"));
    }

    /// The entry for its samples.
    pub fn samples_entry(&mut self, ui: &mut Ui, of: &str) {
        let entry = ui.add(DragValue::new(&mut self.samples).range(1..=256)).accessible_name(format!("{of} samples"));
        entry.on_hover_text("Per pixel; 16 are smooth, 64 very smooth");
    }

    /// Boxes for the formats.
    pub fn format_boxes(&mut self, ui: &mut Ui) {
        check_box(ui, &mut self.png, "PNG").on_hover_text("As displayed");
        check_box(ui, &mut self.exr, "EXR").on_hover_text("Scene-linear, 32-bit float");
        ui.add_enabled_ui(self.exr, |ui| {
            check_box(ui, &mut self.layers, "with layers").on_hover_text(
                "Write parts of the light, surface data and work as layers; takes about four times as long",
            );
        });
    }

    /// Rows for the folder and the name of frames or pictures.
    pub fn place_rows(&mut self, ui: &mut Ui, of: &str, name_help: &str) -> Option<Answer> {
        ui.label("Folder");
        let chosen = ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut self.folder).desired_width(FIELD);
            ui.add(field).accessible_name(format!("Folder of the {of}"));
            ui.button("Choose...").clicked().then_some(Answer::ChooseFolder)
        });
        ui.end_row();
        ui.label("Name");
        let field = TextEdit::singleline(&mut self.name).desired_width(FIELD);
        ui.add(field).accessible_name(format!("Name of the {of}")).on_hover_text(name_help);
        ui.end_row();
        chosen.inner
    }
}

/// Shows a dialog with a heading, whose contents may answer.
pub fn dialog(ctx: &Context, heading: &str, contents: impl FnOnce(&mut Ui) -> Option<Answer>) -> Option<Answer> {
    let modal = Modal::new(Id::unique(heading)).show(ctx, |ui| {
        ui.set_width(WIDTH);
        ui.heading(heading);
        ui.add_space(6.0);
        contents(ui)
    });
    modal.inner.or(modal.should_close().then_some(Answer::Cancel))
}

/// The rows of a dialog, labels before controls.
pub fn rows<T>(ui: &mut Ui, name: &str, contents: impl FnOnce(&mut Ui) -> T) -> T {
    Grid::new(name).num_columns(2).spacing([14.0, 7.0]).show(ui, contents).inner
}

/// The end of a dialog: what will be written, the problem, if any, and the buttons.
pub fn footer(ui: &mut Ui, estimate: &str, problem: Option<&str>) -> Option<Answer> {
    ui.add_space(6.0);
    ui.weak(estimate);
    if let Some(problem) = problem {
        copyable(ui, RichText::new(problem).color(ui.visuals().error_fg_color));
    }
    ui.add_space(10.0);
    let mut answer = None;
    ui.horizontal(|ui| {
        for (text, meaning) in [("Export", Answer::Export), ("Cancel", Answer::Cancel)] {
            if ui.add(Button::new(text).min_size([84.0, 24.0].into())).clicked() {
                answer = Some(meaning);
            }
        }
    });
    answer
}

/// Seconds in the unit that fits.
pub fn duration(secs: f64) -> String {
    match secs {
        secs if secs < 90.0 => format!("{:.0} s", secs.max(1.0)),
        secs if secs < 5400.0 => format!("{:.0} min", secs / 60.0),
        secs => format!("{:.1} h", secs / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_the_unit_that_fits() {
        assert_eq!([0.2, 45.0, 600.0, 7200.0].map(duration), ["1 s", "45 s", "10 min", "2.0 h"]);
    }
}
