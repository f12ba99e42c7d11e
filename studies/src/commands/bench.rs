//! `lapidary bench`: times of each pass of a frame, of each step of implicit visibility, or of all measurements of the bundled
//! scenes beside another program.

mod against;
mod drag;
mod edits;
mod implicit;
mod json;
mod passes;
mod resolve;
mod suite;

use crate::{
    args::{LocalLightArgs, ViewArgs},
    bundled::DataFolder,
    outputs::CommandFiles,
    terminal::{Console, Outcome},
    timing::median,
};
use against::AgainstArgs;
use anyhow::Result;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use json::JsonArgs;
use passes::PassesArgs;
use std::path::PathBuf;
use suite::SuiteArgs;

/// Options for the picture of a dataset, by name or by group.
const PICTURE: [&str; 9] = [
    "EnvironmentArgs",
    "LocalLightArgs",
    "CameraArgs",
    "LensArgs",
    "roughness",
    "base_color",
    "metalness",
    "material",
    "allow_outside",
];

/// Options of the figures by pass, by name or by group.
const PASSES: [&str; 6] = ["illum_cuts", "frames", "drag", "edits", "resolve", "DeviceArgs"];

/// Options of `bench`.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    #[command(flatten)]
    json: JsonArgs,
    /// Measure implicit visibility with these numbers of surfels, separated by commas, in place of frames
    #[arg(
        long,
        value_name = "N,..",
        value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(64..=65_536),
        conflicts_with_all = PICTURE,
        conflicts_with_all = ["drag", "edits", "resolve", "illum_cuts"]
    )]
    surfels: Vec<u32>,
    #[command(flatten)]
    passes: PassesArgs,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewUnlessAgainst,
    // Last, because its heading would otherwise apply to the following options.
    #[command(flatten)]
    against: AgainstArgs,
    #[command(flatten)]
    suite: SuiteArgs,
    /// Folder with the bundled scenes and environments, for --against and --gpu-suite [default: in the source tree]
    #[arg(long, value_name = "DIR", env = "LAPIDARY_DATA", hide_env_values = true)]
    data: Option<PathBuf>,
}

/// A view of a dataset; `None` beside another program, which uses given scenes.
#[derive(Clone, Debug)]
struct ViewUnlessAgainst(Option<ViewArgs>);

/// Written by hand, because clap sees no members in an optional group of groups.
impl Args for ViewUnlessAgainst {
    fn augment_args(command: Command) -> Command {
        ViewArgs::augment_args(command)
            .mut_arg("file", |file| file.required(false).required_unless_present_any(["against", "gpu_suite"]))
    }

    fn augment_args_for_update(command: Command) -> Command {
        ViewArgs::augment_args_for_update(command)
    }
}

impl FromArgMatches for ViewUnlessAgainst {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        matches.contains_id("file").then(|| ViewArgs::from_arg_matches(matches)).transpose().map(Self)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl BenchArgs {
    /// Files that it reads and writes.
    pub fn files(&self) -> CommandFiles {
        let files = self.view.0.as_ref().map_or_else(|| self.against.files(), |view| view.files(&self.local));
        files.reads(&self.data).writes(self.json.output())
    }
}

/// Measures and prints.
///
/// # Errors
/// Unreadable files, or no adapter if one is required.
pub fn run(args: &BenchArgs, console: Console) -> Result<Outcome> {
    let Some(view) = &args.view.0 else {
        let data = DataFolder::find(args.data.as_deref())?;
        if args.suite.gpu_suite {
            suite::run(&data, &args.json, console)?;
            return Ok(Outcome::Done);
        }
        return against::run(&args.against, &data, &args.json, console);
    };
    let viewed = view.resolve(&args.local, console)?;
    match args.surfels.is_empty() {
        true => passes::run(&args.passes, &viewed, &args.json)?,
        false => implicit::run(&args.surfels, &args.passes, &viewed.baked.dataset, &args.json)?,
    }
    Ok(Outcome::Done)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Options {
        #[command(flatten)]
        bench: BenchArgs,
    }

    #[test]
    fn it_takes_a_dataset_or_another_program() {
        let parsed = |text: &str| Options::try_parse_from(std::iter::once("bench").chain(text.split_whitespace()));
        let bench = |text: &str| parsed(text).map(|options| options.bench);
        assert!(bench("a.cuts --size 8x6 --env none --frames 1").is_ok_and(|bench| bench.view.0.is_some()));
        assert!(bench("--against old --fail-above 1.1 --json").is_ok_and(|bench| bench.view.0.is_none()));
        assert!(bench("--gpu-suite --json").is_ok_and(|bench| bench.view.0.is_none() && bench.suite.gpu_suite));
        let surfels = bench("a.cuts --surfels 1024,4096 --frames 3 --backend cpu --json");
        assert!(surfels.is_ok_and(|bench| bench.surfels == [1024, 4096]));
        assert!(bench("a.cuts --drag o --env none --size 8x6 --roughness 1").is_ok());
        assert!(bench("a.cuts --edits m --env none --size 8x6 --frames 3").is_ok());
        assert!(bench("a.cuts --resolve o --frames 2 --json").is_ok());
        let refused = [
            "",
            "--json",
            "--json a.cuts",
            "--against",
            "--against old a.cuts",
            "--against old --size 8x6",
            "--against old --f-number 2",
            "--against old --env none",
            "--against old --frames 3",
            "--against old --edits m",
            "--against old --roughness 1",
            "--against old --lights none",
            "--against old --surfels 1024",
            "--against old --fail-above 0",
            "a.cuts --surfels 3",
            "a.cuts --surfels 1024 --drag o",
            "a.cuts --surfels 1024 --edits m",
            "a.cuts --surfels 1024 --illum-cuts 256",
            "a.cuts --surfels 1024 --env none",
            "a.cuts --surfels 1024 --lights none",
            "a.cuts --surfels 1024 --size 8x6",
            "a.cuts --surfels 1024 --roughness 1",
            "a.cuts --surfels 1024 --material gold.json",
            "a.cuts --drag o --illum-cuts 256",
            "a.cuts --drag o --edits m",
            "a.cuts --drag o --resolve o",
            "a.cuts --surfels 1024 --resolve o",
            "--against old --resolve o",
            "a.cuts --edits m --illum-cuts 256",
            "--fail-above 2",
            "a.cuts --fail-above 2",
            "--against old --backend cpu",
            "--gpu-suite --gpu-path compute",
            "a.cuts --resolve o --gpu-path compute",
            "--gpu-suite a.cuts",
            "--gpu-suite --against old",
            "--gpu-suite --frames 3",
            "--gpu-suite --size 8x6",
        ];
        for text in refused {
            assert!(parsed(text).is_err(), "{text}");
        }
    }

    #[test]
    fn json_is_printed_or_written() {
        let output = |text: &str| {
            let words = std::iter::once("bench").chain(text.split_whitespace());
            Options::try_parse_from(words)
                .unwrap()
                .bench
                .files()
                .outputs()
                .map(std::path::PathBuf::from)
                .collect::<Vec<_>>()
        };
        assert!(output("a.cuts --json").is_empty() && output("--against old --json").is_empty());
        assert!(output("a.cuts --json --frames 3").is_empty());
        assert_eq!(output("a.cuts --json b.json"), [std::path::Path::new("b.json")]);
        assert_eq!(output("--against old --json b.json"), [std::path::Path::new("b.json")]);
    }
}
