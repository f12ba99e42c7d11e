//! The dialog for pictures of what is shown and of looks: which, how large, and where.

use super::dialog::duration;
use crate::{
    document::looks::LookState,
    looks::{Maps, PictureOfDocument, file_name},
    widgets::{check_box, copyable},
};
use anyhow::{Result, bail};
use egui::{Button, Context, DragValue, Grid, Modal, RichText, ScrollArea, TextEdit, Ui};
use lapidary_core::names::told_apart;
use lapidary_studies::{
    args::check_memory,
    export::LayerList,
    jobs::export::{ExportTask, PictureTask},
    outputs::CommandFiles,
};
use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

/// Width of the dialog in points.
const WIDTH: f32 = 520.0;
/// Width of the field for the folder in points.
const FIELD: f32 = 270.0;
/// Height of the list of looks in points.
const LIST: f32 = 120.0;
/// Common sizes.
const SIZES: [([u32; 2], &str); 4] =
    [([1280, 720], "720p"), ([1920, 1080], "1080p"), ([2560, 1440], "1440p"), ([3840, 2160], "4K")];

/// The pictures being described.
#[derive(Clone, Debug)]
pub struct PicturesDialog {
    /// What the window shows, then the looks: names, and whether each is wanted.
    chosen: Vec<(String, bool)>,
    size: [u32; 2],
    viewport: [u32; 2],
    samples: u32,
    png: bool,
    exr: bool,
    layers: bool,
    /// Whether files that exist are written anew.
    replaces: bool,
    /// Folder of the pictures.
    pub folder: String,
    name: String,
    /// Why they cannot be rendered.
    pub problem: Option<String>,
}

/// The answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PicturesAnswer {
    /// Begin.
    Render,
    /// Ask for the folder.
    ChooseFolder,
    /// Leave it.
    Cancel,
}

impl PicturesDialog {
    /// All looks of a document, or what is shown if it has none, in `folder`, in files that begin with `name`.
    pub fn new(shown: &PictureOfDocument, folder: &Path, name: &str) -> Self {
        let looks = shown.document.looks.iter().map(|look| (look.name.clone(), true));
        Self {
            chosen: [("As shown".to_owned(), looks.len() == 0)].into_iter().chain(looks).collect(),
            size: [1920, 1080],
            viewport: shown.size,
            samples: shown.document.view.aa,
            png: true,
            exr: false,
            layers: false,
            replaces: false,
            folder: folder.display().to_string(),
            name: name.into(),
            problem: None,
        }
    }

    /// The described pictures, and their files.
    ///
    /// # Errors
    /// The problem, in words.
    pub fn task(&self, shown: &PictureOfDocument) -> Result<(ExportTask, CommandFiles)> {
        let folder = PathBuf::from(self.folder.trim());
        if self.folder.trim().is_empty() || self.name.trim().is_empty() {
            bail!("the pictures need a folder and a name");
        }
        let formats: Vec<&str> =
            [("png", self.png), ("exr", self.exr)].into_iter().filter_map(|(e, wanted)| wanted.then_some(e)).collect();
        if formats.is_empty() {
            bail!("no format is chosen; choose PNG, EXR or both");
        }
        let layers = (self.exr && self.layers).then_some(LayerList::All);
        check_memory(self.size, 1 + layers.as_ref().map_or(0, LayerList::most))?;
        if self.name.contains(['/', '\\']) {
            bail!("the name \"{}\" is that of another folder; choose that folder", self.name);
        }
        let (names, maps) = (file_names(self.chosen.iter().map(|(name, _)| name)), Arc::default());
        let mut pictures = Vec::new();
        for (index, (look, _)) in self.chosen.iter().enumerate().filter(|(_, (_, wanted))| *wanted) {
            let state = match shown.document.look(look) {
                _ if index == 0 => None,
                Some(look) => Some(&look.state),
                None => bail!("the look \"{look}\" is gone; open the dialog again"),
            };
            let name = if index == 0 { String::new() } else { format!("-{}", names[index]) };
            let path = |format: &&str| folder.join(format!("{}{name}.{format}", self.name.trim()));
            pictures.push(self.picture(shown, state, formats.iter().map(path).collect(), &maps));
        }
        if pictures.is_empty() {
            bail!("no look is chosen");
        }
        let paths: Vec<PathBuf> = pictures.iter().flat_map(|picture| picture.paths.clone()).collect();
        let there = paths.iter().filter(|path| path.exists()).count();
        if there > 0 && !self.replaces {
            bail!(
                "{there} of {} files are there already; tick \"Replace existing\", or choose another name or folder",
                paths.len()
            );
        }
        Ok((ExportTask::Pictures(pictures), CommandFiles::default().writes(paths)))
    }

    /// A picture of a look, or of what is shown.
    fn picture(
        &self,
        shown: &PictureOfDocument,
        look: Option<&LookState>,
        paths: Vec<PathBuf>,
        maps: &Arc<Mutex<Maps>>,
    ) -> PictureTask {
        let shown = PictureOfDocument { size: self.size, aa: Some(self.samples), ..shown.clone() };
        let picture = match look {
            Some(look) => shown.with_look(look),
            None => shown,
        };
        let layers = (self.exr && self.layers).then_some(LayerList::All);
        let maps = maps.clone();
        let look = move || picture.look(&mut maps.lock().unwrap_or_else(PoisonError::into_inner));
        PictureTask { look: Box::new(look), layers, paths }
    }

    /// Shows the dialog; `pixel_secs` is the time of a sample of a pixel, if known.
    pub fn show(&mut self, ctx: &Context, pixel_secs: Option<f64>) -> Option<PicturesAnswer> {
        let modal = Modal::new(egui::Id::unique("pictures")).show(ctx, |ui| {
            ui.set_width(WIDTH);
            ui.heading("Export pictures");
            ui.add_space(6.0);
            let grid = Grid::new("picture fields").num_columns(2).spacing([14.0, 7.0]);
            let chosen = grid.show(ui, |ui| {
                self.look_rows(ui);
                self.size_rows(ui);
                self.file_rows(ui)
            });
            ui.add_space(6.0);
            ui.weak(self.estimate(pixel_secs));
            if let Some(problem) = &self.problem {
                copyable(ui, RichText::new(problem).color(ui.visuals().error_fg_color));
            }
            buttons(ui).or(chosen.inner)
        });
        modal.inner.or(modal.should_close().then_some(PicturesAnswer::Cancel))
    }

    fn look_rows(&mut self, ui: &mut Ui) {
        ui.label("Pictures");
        ScrollArea::vertical().max_height(LIST).show(ui, |ui| {
            for (name, wanted) in &mut self.chosen {
                check_box(ui, wanted, name);
            }
        });
        ui.end_row();
    }

    fn size_rows(&mut self, ui: &mut Ui) {
        ui.label("Size");
        ui.horizontal(|ui| {
            let [width, height] = &mut self.size;
            ui.add(DragValue::new(width).range(1..=16_384)).accessible_name("Picture width");
            ui.label("x");
            ui.add(DragValue::new(height).range(1..=16_384)).accessible_name("Picture height");
            for (size, label) in SIZES.into_iter().chain([(self.viewport, "Viewport")]) {
                ui.selectable_value(&mut self.size, size, label);
            }
        });
        ui.end_row();
        ui.label("Samples");
        let samples = DragValue::new(&mut self.samples).range(1..=256);
        ui.add(samples).accessible_name("Picture samples").on_hover_text("Per pixel; 16 are smooth, 64 very smooth");
        ui.end_row();
    }

    fn file_rows(&mut self, ui: &mut Ui) -> Option<PicturesAnswer> {
        ui.label("Format");
        ui.horizontal(|ui| {
            check_box(ui, &mut self.png, "PNG").on_hover_text("As displayed");
            check_box(ui, &mut self.exr, "EXR").on_hover_text("Scene-linear, 32-bit float");
            ui.add_enabled_ui(self.exr, |ui| {
                let help = "Write parts of the light, surface data and work as layers";
                check_box(ui, &mut self.layers, "with layers").on_hover_text(help);
            });
        });
        ui.end_row();
        ui.label("Folder");
        let chosen = ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut self.folder).desired_width(FIELD);
            ui.add(field).accessible_name("Folder of the pictures");
            ui.button("Choose...").clicked().then_some(PicturesAnswer::ChooseFolder)
        });
        ui.end_row();
        ui.label("Name");
        let field = TextEdit::singleline(&mut self.name).desired_width(FIELD);
        ui.add(field).accessible_name("Name of the pictures").on_hover_text("The name of each look is added to it");
        ui.end_row();
        ui.label("");
        check_box(ui, &mut self.replaces, "Replace existing").on_hover_text("Write files anew that exist already");
        ui.end_row();
        chosen.inner
    }

    /// Number of pictures, and their time at the pace of the window's picture.
    fn estimate(&self, pixel_secs: Option<f64>) -> String {
        let pictures = self.chosen.iter().filter(|(_, wanted)| *wanted).count();
        let [width, height] = self.size.map(f64::from);
        let samples = width * height * f64::from(self.samples) * pictures as f64;
        let time = pixel_secs.map(|secs| format!(", about {}", duration(secs * samples))).unwrap_or_default();
        let word = if pictures == 1 { "picture" } else { "pictures" };
        format!("{pictures} {word} of {width} x {height} pixels{time}")
    }
}

/// Names of files for looks, which differ in more than upper and lower case: some systems take no notice of that.
fn file_names<'a>(looks: impl Iterator<Item = &'a String>) -> Vec<String> {
    let plain: Vec<String> = looks.map(|look| file_name(look)).collect();
    let apart = told_apart(plain.iter().map(|name| name.to_lowercase()).collect());
    let numbered = |(name, apart): (&String, &String)| format!("{name}{}", &apart[name.to_lowercase().len()..]);
    plain.iter().zip(&apart).map(numbered).collect()
}

fn buttons(ui: &mut Ui) -> Option<PicturesAnswer> {
    ui.add_space(10.0);
    let buttons = ui.horizontal(|ui| {
        let render = ui.add(Button::new("Render")).clicked().then_some(PicturesAnswer::Render);
        render.or(ui.button("Cancel").clicked().then_some(PicturesAnswer::Cancel))
    });
    buttons.inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_looks_are_told_apart_on_every_system() {
        let names = ["Day", "day", "Red/1", "Red-1"].map(String::from);
        assert_eq!(file_names(names.iter()), ["Day", "day 2", "Red-1", "Red-1 2"]);
    }
}
