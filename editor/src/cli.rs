//! The command line: the window, and the commands of `lapidary_studies`.

use crate::{
    check::CheckArgs,
    edit::{self, EditArgs},
    looks::command::{LooksArgs, RenderSessionArgs},
};
use anyhow::Result;
use clap::{CommandFactory, Parser, Subcommand};
use lapidary_studies::{
    commands,
    terminal::{Console, Outcome},
};
use std::{ffi::OsString, path::Path};

const ABOUT: &str = "Relights scenes whose visibility was baked once. Shadows and reflections of whole environments are \
free of noise, for any material, and are measured against ray tracing.";

const TUTORIAL: &str = "\
`lapidary` without a command opens the window with a still life.

To try the command line on the bundled data:

  lapidary demo
      bakes a still life, renders it, traces the references, and writes a report:
      out/demo/report.html

With your own scene:

  lapidary bake scene.gltf -o scene.cuts --preset draft
      bakes its visibility; draft takes up to a minute, normal and high are finer and take longer
  lapidary info scene.cuts
      describes the dataset: mesh, light tree, cut sizes, error, bytes, times
  lapidary verify scene.cuts
      traces some vertices again and compares
  lapidary check look.lapidary
      checks that all files of a session can be read
  lapidary render scene.cuts --env sky.hdr --rotate 30 --out sky.png
      relights it by any environment at any rotation, without a new bake
  lapidary render car.lapidary --all --out pictures/car.png
      renders all looks of a session
  lapidary render scene.cuts --env studio --roughness 0.3 --metalness 1 --out metal.png
      gives the whole scene another material
  lapidary render scene.cuts --lights lamps.json --out night.png
      lights it by local lights: {\"lights\": [{\"kind\": \"point\", \"position\": [0, 2, 0], \"intensity\": [9, 8, 6]}]}
  lapidary render scene.cuts --env sky.hdr --rotate 30 --aa 1 --out sky.exr
  lapidary reference scene.cuts --env sky.hdr --rotate 30 --aa 1 --out truth.exr
      renders the same picture by ray tracing, as a reference, both at the centers of the pixels
  lapidary compare sky.exr truth.exr --map rel --out error.png
      measures the error and draws it as a map
  lapidary ladder scene.cuts --env sky.hdr --size 160x120 --out ladder
      finds the size of the illumination cut that is enough, against ray tracing

`lapidary COMMAND --help` explains every option.

Exit codes:
  0    done
  1    an error; standard error says which
  2    wrong options
  3    `compare` found a metric out of bounds, or `bench --against` a ratio
  130  stopped by Ctrl-C";

/// The command line.
#[derive(Parser)]
#[command(name = "lapidary", version, about = ABOUT, after_help = TUTORIAL, max_term_width = 110)]
pub struct Cli {
    /// Print no progress, warnings, notes or summaries; errors and the output of `info`, `verify`, `check` and `looks` are
    /// still printed
    #[arg(long, global = true)]
    pub quiet: bool,
    /// The command; without one the window opens.
    #[command(subcommand)]
    command: Option<Command>,
}

/// The command line of `render` with a session, which has its looks and no options for light and materials.
#[derive(Parser)]
#[command(name = "lapidary", version, max_term_width = 110)]
pub struct SessionCli {
    /// Print no progress, warnings, notes or summaries
    #[arg(long, global = true)]
    pub quiet: bool,
    #[command(subcommand)]
    command: SessionCommand,
}

#[derive(Clone, Subcommand)]
enum SessionCommand {
    /// Render what a session shows, or its looks
    Render(RenderSessionArgs),
}

impl SessionCli {
    /// Runs the command.
    ///
    /// # Errors
    /// As [`RenderSessionArgs::run`].
    pub fn run(&self) -> Result<Outcome> {
        let SessionCommand::Render(args) = &self.command;
        args.run(Console { quiet: self.quiet })
    }
}

/// The arguments with the command `edit` before a file that stands alone, as a file manager gives it.
pub fn with_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let is_file = |name: &OsString| Path::new(name).is_file() && Cli::command().find_subcommand(name).is_none();
    if arguments.get(1).is_some_and(is_file) {
        arguments.insert(1, "edit".into());
    }
    arguments
}

impl Cli {
    /// The command.
    pub fn chosen(&self) -> Command {
        self.command.clone().unwrap_or_else(|| Command::Edit(EditArgs::of_environment()))
    }
}

/// A command.
#[derive(Clone, Subcommand)]
pub enum Command {
    /// Open the window: load a scene, bake it, edit materials and light (the default command)
    #[command(after_help = "\
Without a file the bundled still life opens. The first start bakes it and keeps the bake in the cache folder.
The bake of a scene is expected beside it (NAME.cuts). F1 shows the keys.

Examples:
  lapidary
  lapidary scene.gltf
  lapidary edit look.lapidary --backend cpu")]
    Edit(EditArgs),
    /// Check that all files that a session names are there and can be read
    #[command(after_help = "\
It lists scene, dataset, environment, textures, lights, materials, bookmarks and looks, and reports what is missing or damaged. It
opens no window. It fails (exit code 1) if there is a problem.

Example:
  lapidary check look.lapidary")]
    Check(CheckArgs),
    /// List the looks of a session
    #[command(after_help = "\
Each line has the name of a look, and what it keeps. `lapidary render` renders them:

Examples:
  lapidary looks car.lapidary
  lapidary render car.lapidary --look \"Night\" --size 1920x1080 --out night.png
  lapidary render car.lapidary --all --size 3840x2160 --aa 64 --out pictures/car.png")]
    Looks(LooksArgs),
    #[command(flatten)]
    Study(Box<commands::Command>),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// An error with its remedy, in words for the user.
    pub fn run(&self, console: Console) -> Result<Outcome> {
        match self {
            Self::Edit(args) => edit::run(args),
            Self::Check(args) => args.run(),
            Self::Looks(args) => args.run(console),
            Self::Study(command) => command.run(console),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_command_the_window_opens() {
        assert!(matches!(Cli::parse_from(["lapidary"]).chosen(), Command::Edit(_)));
        assert!(matches!(Cli::parse_from(["lapidary", "--quiet"]).chosen(), Command::Edit(_)));
        assert!(
            matches!(Cli::parse_from(["lapidary", "demo"]).chosen(), Command::Study(command) if matches!(*command, commands::Command::Demo(_)))
        );
    }

    #[test]
    fn a_file_alone_is_opened_in_the_window() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.gltf");
        let command =
            |name: &Path| with_command(vec!["lapidary".into(), name.into(), "--backend".into(), "cpu".into()]);
        assert_eq!(command(&file)[1], file, "negative control: there is no such file");
        std::fs::write(&file, "").unwrap();
        assert_eq!(command(&file)[1..3], ["edit".into(), file.into_os_string()]);
        assert!(matches!(Cli::parse_from(command(&folder.path().join("scene.gltf"))).chosen(), Command::Edit(_)));
        assert_eq!(with_command(vec!["lapidary".into(), "demo".into()])[1], "demo");
    }

    #[test]
    fn options_are_consistent_and_every_one_is_explained() {
        for mut command in [<Cli as CommandFactory>::command(), <SessionCli as CommandFactory>::command()] {
            command.build();
            command.clone().debug_assert();
            for command in command.get_subcommands().filter(|c| c.get_name() != "help") {
                let undocumented = command.get_arguments().filter(|a| a.get_help().is_none());
                let names: Vec<_> = undocumented.map(|a| a.get_id().to_string()).collect();
                assert!(names.is_empty(), "{}: {names:?}", command.get_name());
            }
        }
    }
}
