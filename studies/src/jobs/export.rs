//! Exports on a worker with its own renderer: sequences and layered pictures, with progress and cancellation.

use super::{Wake, guarded, shared_progress::SharedProgress, spawn};
use crate::{
    export::{Finished, LayerKind, LayerList, Studio, wanted_layers},
    sequence::{Prepared, SequenceEnd, SequenceTask},
    terminal::Interrupted,
};
use anyhow::{Context, Result};
use lapidary_render::{BackendFactory, Baked, Look, Progress};
use std::{
    path::PathBuf,
    slice,
    sync::{
        Arc,
        mpsc::{Receiver, Sender, channel},
    },
};

/// What to export.
pub enum ExportTask {
    /// A prepared image sequence.
    Sequence {
        /// The sequence.
        task: SequenceTask,
        /// Result of [`SequenceTask::prepare`].
        prepared: Prepared,
    },
    /// A picture with its layers.
    Layers {
        /// The look of the picture.
        look: Box<Look>,
        /// Layers to write.
        layers: Vec<LayerKind>,
        /// The exr file.
        path: PathBuf,
    },
    /// Several pictures, each in a look of its own.
    Pictures(Vec<PictureTask>),
}

/// A picture to write.
pub struct PictureTask {
    /// Makes its look on the export's thread, since that may read files.
    pub look: Box<dyn FnOnce() -> Result<Look> + Send>,
    /// Layers of exr files.
    pub layers: Option<LayerList>,
    /// The files.
    pub paths: Vec<PathBuf>,
}

/// An event of an export. The last three end it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ExportMessage {
    /// An adjustment made to fit limits.
    Remark(String),
    /// Summary of a finished export.
    Done(String),
    /// Summary of a cancelled export.
    Cancelled(String),
    /// Reason for a failure.
    Failed(String),
}

/// A running export. Dropping it cancels.
pub struct ExportRun {
    messages: Receiver<ExportMessage>,
    progress: Arc<SharedProgress>,
}

impl ExportRun {
    /// Starts an export of a scene.
    pub fn start(task: ExportTask, baked: Baked, factory: BackendFactory, wake: Wake) -> Self {
        let (sender, messages) = channel();
        let progress = Arc::new(SharedProgress::new(wake));
        let theirs = progress.clone();
        spawn("export", move || {
            let end = guarded("the export", || run(task, baked, &factory, &theirs, &sender));
            // The receiver is gone if the window is closed.
            let _ = sender.send(end.unwrap_or_else(ExportMessage::Failed));
            theirs.wake();
        });
        Self { messages, progress }
    }

    /// Messages since the last call.
    pub fn messages(&mut self) -> Vec<ExportMessage> {
        self.messages.try_iter().collect()
    }

    /// Completed and total pictures; 0 while unknown.
    pub fn progress(&self) -> (u64, u64) {
        self.progress.counts()
    }

    /// Asks it to stop; [`ExportMessage::Cancelled`] follows when it has.
    pub fn cancel(&self) {
        self.progress.cancel();
    }
}

impl Drop for ExportRun {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn run(
    task: ExportTask,
    baked: Baked,
    factory: &BackendFactory,
    state: &SharedProgress,
    sender: &Sender<ExportMessage>,
) -> Result<ExportMessage> {
    let backend = factory()?;
    let mut studio = Studio::new(backend, baked)?;
    let end = match task {
        ExportTask::Sequence { task, prepared } => sequence(&task, prepared, &mut studio, state),
        ExportTask::Layers { look, layers, path } => picture(&look, &layers, path, &mut studio, state),
        ExportTask::Pictures(pictures) => several(pictures, &mut studio, state),
    };
    for remark in studio.remarks() {
        let _ = sender.send(ExportMessage::Remark(remark));
    }
    end
}

fn sequence(
    task: &SequenceTask,
    prepared: Prepared,
    studio: &mut Studio,
    state: &SharedProgress,
) -> Result<ExportMessage> {
    let SequenceEnd { rendered, kept, cancelled } = task.run(prepared, studio, state)?;
    let (there, all, place) = (rendered + kept, task.frames.len(), task.record_path());
    Ok(if cancelled {
        ExportMessage::Cancelled(format!("Export cancelled: {there} of {all} frames are there ({})", place.display()))
    } else {
        ExportMessage::Done(format!("Sequence written: {there} frames ({})", place.display()))
    })
}

/// Writes each picture when it is ready; a failure keeps those that are there.
fn several(pictures: Vec<PictureTask>, studio: &mut Studio, state: &SharedProgress) -> Result<ExportMessage> {
    let all = pictures.len();
    let mut folder = PathBuf::new();
    for (done, PictureTask { look, layers, paths }) in pictures.into_iter().enumerate() {
        state.advanced(done as u64, all as u64);
        let name = paths.first().map(|path| path.display().to_string()).unwrap_or_default();
        let told = || format!("picture {} of {all} ({name})", done + 1);
        let look = look().with_context(told)?;
        match Finished::take(studio, &look, &wanted_layers(layers.as_ref(), &look)?, &|| state.cancelled()) {
            Err(error) if error.is::<Interrupted>() => {
                return Ok(ExportMessage::Cancelled(format!("Export cancelled: {done} of {all} pictures are written")));
            }
            finished => finished.with_context(told)?.write(&look, &studio.baked().dataset, &paths)?,
        }
        folder = paths.first().and_then(|path| path.parent()).map(Into::into).unwrap_or_default();
    }
    Ok(ExportMessage::Done(format!("{all} pictures written ({})", folder.display())))
}

fn picture(
    look: &Look,
    layers: &[LayerKind],
    path: PathBuf,
    studio: &mut Studio,
    state: &SharedProgress,
) -> Result<ExportMessage> {
    state.advanced(0, 1);
    match Finished::take(studio, look, layers, &|| state.cancelled()) {
        Err(error) if error.is::<Interrupted>() => {
            Ok(ExportMessage::Cancelled("Export cancelled: no file was written".into()))
        }
        finished => {
            finished?.write(look, &studio.baked().dataset, slice::from_ref(&path))?;
            Ok(ExportMessage::Done(format!("Picture with {} layers written ({})", layers.len(), path.display())))
        }
    }
}
