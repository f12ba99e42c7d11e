//! Export of sequences, layered pictures and materials: the dialog, the job, and its messages.

use super::{
    output::Answer,
    pictures::PicturesDialog,
    sequence::SequenceDialog,
    state::{Exporting, Run},
};
use crate::{
    actions::{Action, ExportAction},
    document::folder_of,
    looks::PictureOfDocument,
    preferences::FileUse,
    workspace::{Workspace, Written},
};
use egui::Context;
use lapidary_core::scene::Scene;
use lapidary_interchange::{
    formats::{FileFormat, MaterialFormat},
    materialx::Surface,
};
use lapidary_render::{Baked, Look};
use lapidary_studies::{
    export::{
        LayerList,
        materials::{MaterialExport, summary},
    },
    jobs::export::{ExportMessage, ExportRun, ExportTask},
    outputs::{CommandFiles, create_folder},
    sequence::Spin,
    terminal::error_text,
};
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// Why no second export starts.
const UNDER_WAY: &str = "An export is already running; cancel it first";
/// Why there is nothing to export.
const NOTHING: &str = "There is nothing to export; open and bake a scene first";

/// Warning if a glTF file is written with only its materials new.
const KEEPS_PARTS: &str = "The glTF file keeps the scene file's material assignments; only its materials are rewritten";

/// The look and scene of an export.
pub struct Exported {
    /// The look.
    pub look: Look,
    /// The scene.
    pub baked: Baked,
    /// The selected object, which may turn alone, and its name.
    pub selected: Option<(String, Spin)>,
}

impl Exporting {
    /// Performs an action; exports nothing without a picture.
    pub fn perform(&mut self, work: &mut Workspace, exported: Option<Exported>, action: ExportAction) {
        match action {
            ExportAction::Layers(Some(path)) => self.export_layers(work, exported, path),
            ExportAction::Materials(Some(path)) => export_materials(work, path),
            ExportAction::DescribeSequence => self.describe_sequence(work, exported),
            ExportAction::SequenceFolder(Some(folder)) => self.choose_sequence_folder(&folder),
            ExportAction::PicturesFolder(Some(folder)) => {
                self.pictures.iter_mut().for_each(|dialog| dialog.output.folder = folder.display().to_string());
            }
            ExportAction::Cancel => self.cancel(),
            // The picture feature performs `Picture`; a dialog asks for missing paths first.
            ExportAction::Picture(_)
            | ExportAction::Layers(None)
            | ExportAction::Materials(None)
            | ExportAction::SequenceFolder(None)
            | ExportAction::PicturesFolder(None) => {}
        }
    }

    /// Opens the dialog for sequences.
    fn describe_sequence(&mut self, work: &mut Workspace, exported: Option<Exported>) {
        let Some(Exported { look, selected, .. }) = exported else { return work.messages.error(NOTHING) };
        let folder = work.file().map_or_else(|| PathBuf::from("."), folder_of);
        self.dialog = Some(SequenceDialog::new(&look, &folder, selected));
    }

    /// Takes the folder chosen for the frames.
    fn choose_sequence_folder(&mut self, folder: &Path) {
        if let Some(dialog) = &mut self.dialog {
            dialog.output.folder = folder.display().to_string();
        }
    }

    /// Shows the dialog, if it is open, and acts on its answer.
    pub fn show_dialog(
        &mut self,
        ctx: &Context,
        work: &Workspace,
        exported: Option<Exported>,
        pixel_secs: Option<f64>,
        actions: &mut Vec<Action>,
    ) {
        let Some(mut dialog) = self.dialog.take() else { return };
        let Some(Exported { look, baked, .. }) = exported else { return };
        match dialog.show(ctx, &look, pixel_secs) {
            Some(Answer::Cancel) => return,
            Some(Answer::ChooseFolder) => actions.push(Action::Export(ExportAction::SequenceFolder(None))),
            Some(Answer::Export) => match self.begin_sequence(work, &mut dialog, &look, baked) {
                Ok(()) => return,
                Err(error) => dialog.problem = Some(error_text(&error)),
            },
            None => {}
        }
        self.dialog = Some(dialog);
    }

    /// Opens the dialog for pictures of looks.
    pub fn describe_pictures(&mut self, work: &Workspace, shown: &PictureOfDocument) {
        let file = work.file().map_or_else(|| PathBuf::from("picture"), Into::into);
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let last = work.preferences.folders.of(FileUse::Picture);
        let folder = last.unwrap_or_else(|| folder_of(&file).join("pictures"));
        self.pictures = Some(PicturesDialog::new(shown, &folder, &name));
    }

    /// Shows the dialog for pictures of looks, if it is open, and acts on its answer.
    pub fn show_pictures_dialog(
        &mut self,
        ctx: &Context,
        work: &Workspace,
        shown: Option<PictureOfDocument>,
        pixel_secs: Option<f64>,
        actions: &mut Vec<Action>,
    ) {
        let Some(mut dialog) = self.pictures.take() else { return };
        let Some(shown) = shown else { return };
        match dialog.show(ctx, pixel_secs) {
            Some(Answer::Cancel) => return,
            Some(Answer::ChooseFolder) => actions.push(Action::Export(ExportAction::PicturesFolder(None))),
            Some(Answer::Export) => match self.begin_pictures(work, &dialog, &shown) {
                Ok(()) => return,
                Err(error) => dialog.problem = Some(error_text(&error)),
            },
            None => {}
        }
        self.pictures = Some(dialog);
    }

    fn begin_pictures(
        &mut self,
        work: &Workspace,
        dialog: &PicturesDialog,
        shown: &PictureOfDocument,
    ) -> anyhow::Result<()> {
        if self.is_running() {
            anyhow::bail!(UNDER_WAY);
        }
        let (task, files) = dialog.task(shown)?;
        create_folder(&dialog.output.folder()?)?;
        files.reads(work.inputs(Written::Other)).check()?;
        self.start(work, task, shown.baked.clone());
        Ok(())
    }

    fn begin_sequence(
        &mut self,
        work: &Workspace,
        dialog: &mut SequenceDialog,
        look: &Look,
        baked: Baked,
    ) -> anyhow::Result<()> {
        if self.is_running() {
            anyhow::bail!(UNDER_WAY);
        }
        let task = dialog.task(look)?;
        dialog.tell_black_frames(&task, &baked)?;
        task.command_files(CommandFiles::default().reads(work.inputs(Written::Other))).check()?;
        let prepared = task.prepare(&baked.dataset)?;
        self.start(work, ExportTask::Sequence { task, prepared }, baked);
        Ok(())
    }

    /// Writes the picture with all its layers.
    fn export_layers(&mut self, work: &mut Workspace, exported: Option<Exported>, path: PathBuf) {
        if self.is_running() {
            return work.messages.note(UNDER_WAY);
        }
        let Some(Exported { look, baked, .. }) = exported else { return work.messages.error(NOTHING) };
        if !work.may_write(&path, Written::Other) {
            return;
        }
        match LayerList::All.of(&look) {
            Ok(layers) => self.start(work, ExportTask::Layers { look: look.into(), layers, path }, baked),
            Err(error) => work.messages.error(error_text(&error)),
        }
    }

    fn start(&mut self, work: &Workspace, task: ExportTask, baked: Baked) {
        let job = ExportRun::start(task, baked, work.factory.clone(), work.wake.clone());
        self.run = Some(Run { job, since: None, cancelling: false });
    }

    /// Stops the export; keeps complete frames.
    pub fn cancel(&mut self) {
        if let Some(run) = &mut self.run {
            run.cancelling = true;
            run.job.cancel();
        }
    }

    /// Takes messages of the export.
    pub fn collect(&mut self, work: &mut Workspace) {
        let Some(run) = &mut self.run else { return };
        let (done, total) = run.job.progress();
        if run.since.is_none() && total > 0 {
            run.since = Some((Instant::now(), done));
        }
        for message in run.job.messages() {
            match message {
                ExportMessage::Remark(text) => work.messages.warning(text),
                ExportMessage::Done(text) | ExportMessage::Cancelled(text) => {
                    self.run = None;
                    work.messages.withdraw(UNDER_WAY);
                    work.messages.note(text);
                }
                ExportMessage::Failed(text) => {
                    self.run = None;
                    work.messages.withdraw(UNDER_WAY);
                    work.messages.error(format!("The export failed: {text}"));
                }
            }
        }
    }
}

/// Writes the materials of the document. A glTF scene is written with these materials in place of its own.
fn export_materials(work: &mut Workspace, path: PathBuf) {
    let Some(baked) = work.scene.rendered().cloned() else { return work.messages.error(NOTHING) };
    let copies = |path: &Path| MaterialFormat::of(path).is_some_and(|format| format.copies_scene);
    let original = work.document.scene.clone().filter(|scene| copies(scene) && copies(&path));
    let export =
        MaterialExport { path, surface: Surface::default(), original, scene: work.document.scene_in_file.clone() };
    let written = export
        .files(CommandFiles::default().reads(work.inputs(Written::Other)))
        .check()
        .and_then(|()| export.write(&scene_of_document(work, &baked)));
    match written {
        Ok(exported) => {
            let text = format!("Materials written: {}", summary(&exported, &export.path));
            exported.remarks.into_iter().for_each(|remark| work.messages.warning(remark));
            if export.original.is_some() && !work.document.assigned.is_empty() {
                work.messages.warning(KEEPS_PARTS);
            }
            work.messages.note(text);
        }
        Err(error) => work.messages.error(error_text(&error)),
    }
}

/// The scene with the edited materials and textures.
fn scene_of_document(work: &Workspace, baked: &Baked) -> Scene {
    let textures = work.document.shared_textures();
    let materials = work.document.materials.clone();
    let mut scene = Scene { materials, textures, part_opacities: Vec::new(), ..baked.dataset.scene.clone() };
    if let Some(assigned) = work.document.assigned_to(&scene.mesh) {
        scene.mesh.triangle_material = assigned.to_vec();
    }
    scene
}
