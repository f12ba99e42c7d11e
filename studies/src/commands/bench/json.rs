//! Figures as JSON, printed or in a file.

use crate::terminal::{json_text, print_out, write_json};
use anyhow::Result;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Output of figures.
#[derive(Args, Clone, Debug, Default)]
pub struct JsonArgs {
    /// Print the figures as JSON; with a file name, write them there beside the printed text
    #[arg(long, value_name = "FILE.json", num_args = 0..=1)]
    json: Option<Option<PathBuf>>,
}

impl JsonArgs {
    /// The written file.
    pub fn output(&self) -> Option<&PathBuf> {
        self.json.iter().flatten().next()
    }

    /// Prints figures as `text` or JSON, or writes them to the file.
    ///
    /// # Errors
    /// An unwritable file or standard output.
    pub fn tell(&self, figures: &impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
        match &self.json {
            Some(None) => return print_out(&json_text(figures)?),
            Some(Some(path)) => write_json(path, figures)?,
            None => {}
        }
        print_out(&text())
    }
}
