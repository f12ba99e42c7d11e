//! Figures as JSON, printed or in a file.

use crate::terminal::{json_text, print_out, write_json};
use anyhow::Result;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// How figures are told.
#[derive(Args, Clone, Debug, Default)]
pub struct JsonArgs {
    /// Print the figures as JSON; with a file, write them there beside the printed text
    #[arg(long, value_name = "FILE.json", num_args = 0..=1)]
    json: Option<Option<PathBuf>>,
}

impl JsonArgs {
    /// The file that is written.
    pub fn output(&self) -> Option<&PathBuf> {
        self.json.iter().flatten().next()
    }

    /// Prints figures, as `text` or as JSON, or writes them.
    ///
    /// # Errors
    /// A file or a standard output that cannot be written.
    pub fn tell(&self, figures: &impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
        match &self.json {
            Some(None) => return print_out(&json_text(figures)?),
            Some(Some(path)) => write_json(path, figures)?,
            None => {}
        }
        print_out(&text())
    }
}
