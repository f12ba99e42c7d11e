//! The `verify` command.

use crate::{
    outputs::CommandFiles,
    terminal::{json_text, print_out},
};
use anyhow::{Result, bail};
use clap::{Args, builder::RangedU64ValueParser};
use lapidary_core::dataset::Dataset;
use lapidary_interchange::image;
use lapidary_precompute::{Verification, verify};
use std::path::PathBuf;

/// Options of `verify`.
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Dataset to verify
    pub file: PathBuf,
    /// Vertices to trace again, 1 or more, and as many surface sources and functions of the meshless basis (64 at
    /// most); the random choice is always the same
    #[arg(long, value_name = "K", default_value_t = 256, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    pub vertices: usize,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl VerifyArgs {
    /// What it reads.
    pub fn files(&self) -> CommandFiles {
        CommandFiles::default().reads([&self.file])
    }

    /// Traces random vertices and functions again and prints the difference.
    ///
    /// # Errors
    /// A dataset that cannot be read, or that does not agree with what was traced.
    pub fn run(&self) -> Result<()> {
        let result = verify(&Dataset::read(&self.file, image::decode)?, self.vertices);
        if self.json {
            print_out(&json_text(&result)?)?;
        } else {
            print_out(&verification_text(&result))?;
        }
        if !result.passed {
            bail!("the dataset does not agree with its scene; bake it again ({})", self.file.display());
        }
        Ok(())
    }
}

fn verification_text(v: &Verification) -> String {
    let mut text = String::new();
    if v.vertices > 0 || (v.source_vertices == 0 && v.meshless.is_none()) {
        text += &format!(
            "traced {} vertices again: RMS of visibility {:.4} (whole bake {:.4}, worst vertex {:.4}), {} cuts differ\n",
            v.vertices, v.rms_visibility, v.expected_rms, v.worst_rms, v.different_cuts
        );
        if v.leaves_wrong > 0.0 {
            text += &format!(
                "boundaries have missed {:.3} % of their visibility; cuts of all that was traced have an RMS of {:.4}\n",
                100.0 * v.leaves_wrong,
                v.exhaustive_rms
            );
        }
    }
    if v.source_vertices > 0 {
        text += &format!(
            "traced the sources from {} vertices again: {} cuts differ\n",
            v.source_vertices, v.different_source_cuts
        );
        if v.sources_wrong > 0.0 {
            text += &format!(
                "boundaries have missed {:.3} % of these sources; the error of solid angles is {:.2} %, of all that was \
                 traced {:.2} %\n",
                100.0 * v.sources_wrong,
                100.0 * v.source_error,
                100.0 * v.exhaustive_source_error
            );
        }
    }
    if v.sources > 0 {
        text += &format!(
            "traced the environment from {} sources again: {} cuts differ\n",
            v.sources, v.different_source_environment_cuts
        );
    }
    if let Some(m) = &v.meshless {
        text += &format!(
            "made the links of {} functions again: {} differ; a smooth light at {} points: {:.1} % error against rays, \
             {:.3} of the energy\n",
            m.functions,
            m.different_functions,
            m.points,
            100.0 * m.error,
            m.energy
        );
    }
    text
}
