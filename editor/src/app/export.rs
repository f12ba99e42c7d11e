//! Export of sequences, layered pictures and materials: the dialog, the job, and its messages.

use super::{
    files::Written,
    sequence_dialog::{SequenceAnswer, SequenceDialog},
    state::{EditorState, exporting::Run},
};
use crate::{actions::Action, document::folder_of};
use egui::Context;
use lapidary_core::scene::Scene;
use lapidary_interchange::{
    formats::{FileFormat, MaterialFormat},
    materialx::Surface,
};
use lapidary_render::{Baked, Look};
use lapidary_studies::jobs::export::{ExportMessage, ExportRun, ExportTask};
use lapidary_studies::{
    export::{
        LayerList,
        materials::{MaterialExport, summary},
    },
    outputs::CommandFiles,
    terminal::error_text,
};
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// Why an export does not start while there is one.
const UNDER_WAY: &str = "An export is under way; cancel it first";
/// Why there is nothing to export.
const NOTHING: &str = "There is nothing to export; open and bake a scene first";

/// What is told where a glTF file is written with its materials alone anew.
const KEEPS_PARTS: &str = "Surfaces that were given other materials have those of the scene's file there: only its materials are written anew";

impl EditorState {
    /// The picture that is exported, and its scene; `None` while there is none.
    fn exported(&mut self) -> Option<(Look, Baked)> {
        let baked = self.scene.rendered()?.clone();
        Some((self.look(self.interface.viewport_size)?, baked))
    }

    /// Opens the dialog for sequences.
    pub(super) fn describe_sequence(&mut self) {
        let Some((look, _)) = self.exported() else { return self.messages.error(NOTHING) };
        let document = &self.document;
        let open = self.scene.session.as_deref().or(document.scene.as_deref()).or(document.dataset.as_deref());
        let folder = open.map_or_else(|| PathBuf::from("."), folder_of);
        self.exporting.dialog = Some(SequenceDialog::new(&look, &folder));
    }

    /// The folder that was chosen for the frames.
    pub(super) fn choose_sequence_folder(&mut self, folder: &Path) {
        if let Some(dialog) = &mut self.exporting.dialog {
            dialog.folder = folder.display().to_string();
        }
    }

    /// Shows the dialog, if it is open, and does what is answered.
    pub(super) fn show_sequence_dialog(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        if self.dialogs.is_open() {
            return;
        }
        let Some(mut dialog) = self.exporting.dialog.take() else { return };
        let Some((look, baked)) = self.exported() else { return };
        match dialog.show(ctx, &look, self.pixel_secs()) {
            Some(SequenceAnswer::Cancel) => return,
            Some(SequenceAnswer::ChooseFolder) => actions.push(Action::SequenceFolder(None)),
            Some(SequenceAnswer::Export) => match self.begin_sequence(&dialog, &look, baked) {
                Ok(()) => return,
                Err(error) => dialog.problem = Some(error_text(&error)),
            },
            None => {}
        }
        self.exporting.dialog = Some(dialog);
    }

    /// How long a sample of a pixel takes, by the picture in the window.
    fn pixel_secs(&self) -> Option<f64> {
        let shown = self.pictures.shown()?;
        let samples = f64::from(shown.size[0]) * f64::from(shown.size[1]) * f64::from(shown.samples);
        (samples > 0.0 && shown.millis > 0.0).then(|| 1e-3 * shown.millis / samples)
    }

    fn begin_sequence(&mut self, dialog: &SequenceDialog, look: &Look, baked: Baked) -> anyhow::Result<()> {
        if self.exporting.is_running() {
            anyhow::bail!(UNDER_WAY);
        }
        let task = dialog.task(look)?;
        task.command_files(CommandFiles::default().reads(self.inputs(Written::Other))).check()?;
        let prepared = task.prepare(&baked.dataset)?;
        self.start_export(ExportTask::Sequence { task, prepared }, baked);
        Ok(())
    }

    /// Writes the picture with all layers that it has.
    pub(super) fn export_layers(&mut self, path: PathBuf) {
        if self.exporting.is_running() {
            return self.messages.note(UNDER_WAY);
        }
        let Some((look, baked)) = self.exported() else { return self.messages.error(NOTHING) };
        if !self.may_write(&path, Written::Other) {
            return;
        }
        match LayerList::All.of(&look) {
            Ok(layers) => self.start_export(ExportTask::Layers { look: look.into(), layers, path }, baked),
            Err(error) => self.messages.error(error_text(&error)),
        }
    }

    /// Writes the materials of the document. A glTF scene is written with the materials in place of its own.
    pub(super) fn export_materials(&mut self, path: PathBuf) {
        let Some(baked) = self.scene.rendered().cloned() else { return self.messages.error(NOTHING) };
        let copies = |path: &Path| MaterialFormat::of(path).is_some_and(|format| format.copies_scene);
        let original = self.document.scene.clone().filter(|scene| copies(scene) && copies(&path));
        let export = MaterialExport { path, surface: Surface::default(), original };
        let written = export
            .files(CommandFiles::default().reads(self.inputs(Written::Other)))
            .check()
            .and_then(|()| export.write(&self.scene_of_document(&baked)));
        match written {
            Ok(exported) => {
                let text = format!("Materials written: {}", summary(&exported, &export.path));
                exported.remarks.into_iter().for_each(|remark| self.messages.warning(remark));
                if export.original.is_some() && !self.document.assigned.is_empty() {
                    self.messages.warning(KEEPS_PARTS);
                }
                self.messages.note(text);
            }
            Err(error) => self.messages.error(error_text(&error)),
        }
    }

    /// The scene with the materials and textures as they are edited.
    fn scene_of_document(&self, baked: &Baked) -> Scene {
        let textures = self.document.shared_textures();
        let materials = self.document.materials.clone();
        let mut scene = Scene { materials, textures, part_opacities: Vec::new(), ..baked.dataset.scene.clone() };
        if let Some(assigned) = self.document.assigned_to(&scene.mesh) {
            scene.mesh.triangle_material = assigned.to_vec();
        }
        scene
    }

    fn start_export(&mut self, task: ExportTask, baked: Baked) {
        let job = ExportRun::start(task, baked, self.factory.clone(), self.wake.clone());
        self.exporting.run = Some(Run { job, since: None, cancelling: false });
    }

    pub(super) fn cancel_export(&mut self) {
        if let Some(run) = &mut self.exporting.run {
            run.cancelling = true;
            run.job.cancel();
        }
    }

    pub(super) fn collect_export(&mut self) {
        let Some(run) = &mut self.exporting.run else { return };
        let (done, total) = run.job.progress();
        if run.since.is_none() && total > 0 {
            run.since = Some((Instant::now(), done));
        }
        for message in run.job.messages() {
            match message {
                ExportMessage::Remark(text) => self.messages.warning(text),
                ExportMessage::Done(text) | ExportMessage::Cancelled(text) => {
                    self.exporting.run = None;
                    self.messages.withdraw(UNDER_WAY);
                    self.messages.note(text);
                }
                ExportMessage::Failed(text) => {
                    self.exporting.run = None;
                    self.messages.withdraw(UNDER_WAY);
                    self.messages.error(format!("The export failed: {text}"));
                }
            }
        }
    }
}
