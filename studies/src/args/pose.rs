//! The options that pose objects.

use crate::outputs::CommandFiles;
use anyhow::Result;
use clap::Args;
use lapidary_core::scene::{Scene, pose::Poses};
use std::path::PathBuf;

/// Where objects are.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Pose")]
pub struct PoseArgs {
    /// Objects that are not where they were baked: {"objects": {"NAME": {"translate": [X,Y,Z], "rotate_degrees": [X,Y,Z],
    /// "scale": S}}}, each turned about its centre in the order X, Y, Z
    #[arg(long, value_name = "FILE.json")]
    pose: Option<PathBuf>,
}

impl PoseArgs {
    /// The files that are read beside others.
    pub fn files(&self, files: CommandFiles) -> CommandFiles {
        files.reads(&self.pose)
    }

    /// The poses of a scene's objects; none without a file.
    ///
    /// # Errors
    /// A file that cannot be read, or that poses what is not there.
    pub fn read(&self, scene: &Scene) -> Result<Poses> {
        Ok(self.pose.as_deref().map(|path| Poses::read(path, scene)).transpose()?.unwrap_or_default())
    }
}
