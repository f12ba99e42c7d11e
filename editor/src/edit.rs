//! `lapidary edit`: the window.

use crate::app::{self, Launch};
use anyhow::Result;
use clap::Args;
use lapidary_interchange::formats::SceneFormat;
use lapidary_studies::{args::DeviceArgs, terminal::Outcome};
use std::path::PathBuf;

/// Options of `edit`.
#[derive(Args, Clone, Debug, Default)]
pub struct EditArgs {
    /// File to open.
    #[arg(value_name = "FILE", help = opened())]
    file: Option<PathBuf>,
    #[command(flatten)]
    device: DeviceArgs,
    /// Folder with the bundled scenes and environments [default: the source tree's]
    #[arg(long, value_name = "DIR", env = "LAPIDARY_DATA", hide_env_values = true)]
    data: Option<PathBuf>,
}

impl EditArgs {
    /// Without options; the variable for the data folder still counts.
    pub fn of_environment() -> Self {
        let data = std::env::var_os("LAPIDARY_DATA").filter(|value| !value.is_empty()).map(PathBuf::from);
        Self { data, ..Self::default() }
    }
}

fn opened() -> String {
    let scenes = SceneFormat::names_richest_first();
    format!("A scene ({scenes}), a dataset (.cuts) or a session (.lapidary) [default: the bundled still life]")
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// No display, or a data folder without data.
pub fn run(args: &EditArgs) -> Result<Outcome> {
    let EditArgs { file, device, data } = args.clone();
    app::run(&Launch { file, device, data })?;
    Ok(Outcome::Done)
}
