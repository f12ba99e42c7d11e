//! Export of sequences, layered pictures and materials: the dialog, the job, and its messages.

mod output;
mod pictures;
mod run;
mod sequence;
mod state;

pub use run::Exported;
pub use state::Exporting;
