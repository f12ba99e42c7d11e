//! The running export, and the dialog that describes the next.

use super::{output::duration, pictures::PicturesDialog, sequence::SequenceDialog};
use lapidary_studies::jobs::export::ExportRun;
use std::time::Instant;

/// The export at work, and the dialog that describes the next.
#[derive(Default)]
pub struct Exporting {
    pub run: Option<Run>,
    pub dialog: Option<SequenceDialog>,
    /// The dialog that describes pictures of looks.
    pub pictures: Option<PicturesDialog>,
}

/// A running export.
pub struct Run {
    pub job: ExportRun,
    /// Time and number of pictures at the start of measuring its pace.
    pub since: Option<(Instant, u64)>,
    pub cancelling: bool,
}

impl Exporting {
    /// Whether a dialog is open.
    pub fn is_asking(&self) -> bool {
        self.dialog.is_some() || self.pictures.is_some()
    }

    /// Whether an export is running.
    pub fn is_running(&self) -> bool {
        self.run.is_some()
    }

    /// One line about the running export: its progress and the time left.
    pub fn line(&self) -> Option<String> {
        let run = self.run.as_ref()?;
        let (done, total) = run.job.progress();
        Some(match (run.cancelling, total) {
            (true, _) => "Canceling the export...".into(),
            (false, 0 | 1) => "Exporting...".into(),
            (false, total) => {
                let frame = format!("Exporting picture {} of {total}", (done + 1).min(total));
                match run.since.filter(|&(_, there)| done > there) {
                    Some((since, there)) => {
                        let left = since.elapsed().as_secs_f64() / (done - there) as f64 * (total - done) as f64;
                        format!("{frame}, about {} left", duration(left))
                    }
                    None => frame,
                }
            }
        })
    }
}
