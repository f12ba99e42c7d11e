//! The `verify` command.

use crate::{
    outputs::CommandFiles,
    terminal::{json_text, print_out},
};
use anyhow::{Result, bail};
use clap::{Args, builder::RangedU64ValueParser};
use lapidary_core::dataset::Dataset;
use lapidary_interchange::image;
use lapidary_precompute::verify;
use std::path::PathBuf;

/// Options of `verify`.
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Dataset to verify
    pub file: PathBuf,
    /// Vertices to retrace, 1 or more, and as many surface sources and functions of the meshless basis (64 at most); the random
    /// choice is always the same
    #[arg(long, value_name = "K", default_value_t = 256, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    pub vertices: usize,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl VerifyArgs {
    /// Files that it reads.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default().reads([&self.file])
    }

    /// Retraces random vertices and functions and prints the difference.
    ///
    /// # Errors
    /// An unreadable dataset, or one that disagrees with the retraced rays.
    pub fn run(&self) -> Result<()> {
        let result = verify(&Dataset::read(&self.file, image::decode)?, self.vertices);
        if self.json {
            print_out(&json_text(&result)?)?;
        } else {
            print_out(&result.text())?;
        }
        if !result.passed {
            bail!("the dataset does not agree with its scene; bake it again ({})", self.file.display());
        }
        Ok(())
    }
}
