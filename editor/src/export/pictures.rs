//! The dialog for pictures of what is shown and of looks: which, how large, and where.

use super::output::{Answer, Output, dialog, footer, rows};
use crate::{
    document::looks::LookState,
    looks::{Maps, PictureOfDocument, file_names},
    widgets::check_box,
};
use anyhow::{Result, bail};
use egui::{Context, ScrollArea, Ui};
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
    /// The pictures.
    pub output: Output,
    viewport: [u32; 2],
    /// Width over height of the view; `None` for any.
    aspect: Option<f32>,
    /// Whether files that exist are written anew.
    replaces: bool,
    /// Why they cannot be rendered.
    pub problem: Option<String>,
}

impl PicturesDialog {
    /// All looks of a document, or what is shown if it has none, in `folder`, in files that begin with `name`.
    pub fn new(shown: &PictureOfDocument, folder: &Path, name: &str) -> Self {
        let aspect = shown.document.view.aspect;
        let looks = shown.document.looks.iter().map(|look| (look.name.clone(), true));
        Self {
            chosen: [("As shown".to_owned(), looks.len() == 0)].into_iter().chain(looks).collect(),
            output: Output::new(shaped([1920, 1080], aspect), samples_of(shown), folder.into(), name),
            viewport: shown.size,
            aspect,
            replaces: false,
            problem: None,
        }
    }

    /// The described pictures, and their files.
    ///
    /// # Errors
    /// The problem, in words.
    pub fn task(&self, shown: &PictureOfDocument) -> Result<(ExportTask, CommandFiles)> {
        let output = &self.output;
        let (folder, formats) = (output.folder()?, output.formats()?);
        check_memory(output.size, 1 + output.layers().as_ref().map_or(0, LayerList::most))?;
        match output.name.trim() {
            "" => bail!("the pictures need a name"),
            name if name.contains(['/', '\\']) => bail!("\"{name}\" names another folder; choose that folder"),
            _ => {}
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
            let path = |format: &&str| folder.join(format!("{}{name}.{format}", output.name.trim()));
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
        let shown = PictureOfDocument { size: self.output.size, aa: Some(self.output.samples), ..shown.clone() };
        let picture = match look {
            Some(look) => shown.with_look(look),
            None => shown,
        };
        let (layers, maps) = (self.output.layers(), maps.clone());
        let look = move || picture.look(&mut maps.lock().unwrap_or_else(PoisonError::into_inner));
        PictureTask { look: Box::new(look), layers, paths }
    }

    /// Shows the dialog; `pixel_secs` is the time of a sample of a pixel, if known.
    pub fn show(&mut self, ctx: &Context, pixel_secs: Option<f64>) -> Option<Answer> {
        dialog(ctx, "Export pictures", |ui| {
            let chosen = rows(ui, "picture fields", |ui| {
                self.look_rows(ui);
                self.size_rows(ui);
                self.file_rows(ui)
            });
            let pictures = self.chosen.iter().filter(|(_, wanted)| *wanted).count();
            let word = if pictures == 1 { "picture" } else { "pictures" };
            let estimate = format!("{pictures} {word} of {}", self.output.estimate(pictures as u32, pixel_secs));
            footer(ui, &estimate, self.problem.as_deref()).or(chosen)
        })
    }

    fn look_rows(&mut self, ui: &mut Ui) {
        ui.label("Pictures");
        let choices = |ui: &mut Ui| self.chosen.iter_mut().for_each(|(name, wanted)| drop(check_box(ui, wanted, name)));
        ui.vertical(|ui| ScrollArea::vertical().max_height(LIST).show(ui, choices));
        ui.end_row();
    }

    fn size_rows(&mut self, ui: &mut Ui) {
        ui.label("Size");
        ui.horizontal(|ui| {
            self.output.size_entries(ui, "Picture");
            for (size, label) in SIZES.into_iter().chain([(self.viewport, "Viewport")]) {
                let size = if size == self.viewport { size } else { shaped(size, self.aspect) };
                ui.selectable_value(&mut self.output.size, size, label);
            }
        });
        ui.end_row();
        ui.label("Samples");
        self.output.samples_entry(ui, "Picture");
        ui.end_row();
    }

    fn file_rows(&mut self, ui: &mut Ui) -> Option<Answer> {
        ui.label("Format");
        ui.horizontal(|ui| self.output.format_boxes(ui));
        ui.end_row();
        let chosen = self.output.place_rows(ui, "pictures", "The name of each look is added to it");
        ui.label("");
        check_box(ui, &mut self.replaces, "Replace existing").on_hover_text("Write files anew that exist already");
        ui.end_row();
        chosen
    }
}

/// Samples of a pixel that the view asks for.
fn samples_of(shown: &PictureOfDocument) -> u32 {
    shown.document.view.aa.max(shown.document.camera.lens.least_samples())
}

/// A size whose longer side is that of `size`, in another shape. Videos need even numbers.
fn shaped(size: [u32; 2], aspect: Option<f32>) -> [u32; 2] {
    let Some(aspect) = aspect else { return size };
    let longer = size[0].max(size[1]);
    let even = |length: f32| (2 * (0.5 * length).round() as u32).max(2);
    match aspect >= 1.0 {
        true => [longer, even(longer as f32 / aspect)],
        false => [even(longer as f32 * aspect), longer],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_their_longer_side_in_another_shape() {
        assert_eq!(shaped([1920, 1080], None), [1920, 1080]);
        assert_eq!(shaped([3840, 2160], Some(16.0 / 9.0)), [3840, 2160]);
        assert_eq!(shaped([3840, 2160], Some(2.39)), [3840, 1606]);
        assert_eq!(shaped([1920, 1080], Some(9.0 / 16.0)), [1080, 1920]);
        assert_eq!(shaped([1920, 1080], Some(1.0)), [1920, 1920]);
    }
}
