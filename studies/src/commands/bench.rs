//! `lapidary bench`: how long each pass of a frame takes, or each step of implicit visibility, or a suite of figures on the bundled
//! scenes.

mod drag;
mod implicit;
mod passes;
mod suite;

use crate::{
    args::{LocalLightArgs, ViewArgs},
    outputs::CommandFiles,
    terminal::{Console, Outcome},
};
use anyhow::Result;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use passes::PassesArgs;
use std::time::Duration;
use suite::SuiteArgs;

/// Options about the picture of a dataset, by name or by group.
const PICTURE: [&str; 8] = [
    "EnvironmentArgs",
    "LocalLightArgs",
    "CameraArgs",
    "roughness",
    "base_color",
    "metalness",
    "material",
    "allow_outside",
];

/// Options of `bench`.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    suite: SuiteArgs,
    /// Measure implicit visibility with these numbers of surfels, separated by commas, in place of frames
    #[arg(
        long,
        value_name = "N,..",
        value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(64..=65_536),
        conflicts_with_all = PICTURE,
        conflicts_with_all = ["drag", "illum_cuts"]
    )]
    surfels: Vec<u32>,
    #[command(flatten)]
    passes: PassesArgs,
    #[command(flatten)]
    local: LocalLightArgs,
    #[command(flatten)]
    view: ViewUnlessSuite,
}

/// A view of a dataset; nothing for the suite, which has its own scenes.
#[derive(Clone, Debug)]
struct ViewUnlessSuite(Option<ViewArgs>);

/// By hand, because an optional group with groups in it has no members for clap.
impl Args for ViewUnlessSuite {
    fn augment_args(command: Command) -> Command {
        ViewArgs::augment_args(command).mut_arg("file", |file| file.required(false).required_unless_present("suite"))
    }

    fn augment_args_for_update(command: Command) -> Command {
        ViewArgs::augment_args_for_update(command)
    }
}

impl FromArgMatches for ViewUnlessSuite {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        matches.contains_id("file").then(|| ViewArgs::from_arg_matches(matches)).transpose().map(Self)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl BenchArgs {
    /// What it reads and writes.
    pub fn files(&self) -> CommandFiles {
        self.view.0.as_ref().map_or_else(|| self.suite.files(), |view| view.files(&self.local))
    }
}

/// Measures and prints.
///
/// # Errors
/// Files that cannot be read, or no adapter where one is asked for.
pub fn run(args: &BenchArgs, console: Console) -> Result<Outcome> {
    match &args.view.0 {
        Some(view) => {
            let viewed = view.resolve(&args.local, console)?;
            match args.surfels.is_empty() {
                true => passes::run(&args.passes, &viewed, args.json)?,
                false => implicit::run(&args.surfels, &args.passes, &viewed.baked.dataset, args.json)?,
            }
        }
        None => suite::run(&args.suite, args.json, console)?,
    }
    Ok(Outcome::Done)
}

/// In milliseconds; of an even number the larger of the two in the middle.
fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    1e3 * times[times.len() / 2].as_secs_f64()
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
    fn it_takes_a_dataset_or_the_suite() {
        let parsed = |text: &str| Options::try_parse_from(std::iter::once("bench").chain(text.split_whitespace()));
        let bench = |text: &str| parsed(text).map(|options| options.bench);
        assert!(bench("a.cuts --size 8x6 --env none --frames 1").is_ok_and(|bench| bench.view.0.is_some()));
        assert!(bench("--suite --save new.json --json").is_ok_and(|bench| bench.view.0.is_none()));
        let surfels = bench("a.cuts --surfels 1024,4096 --frames 3 --backend cpu --json");
        assert!(surfels.is_ok_and(|bench| bench.surfels == [1024, 4096]));
        assert!(bench("a.cuts --drag o --env none --size 8x6 --roughness 1").is_ok());
        let refused = [
            "",
            "--json",
            "--suite a.cuts",
            "--suite --size 8x6",
            "--suite --env none",
            "--suite --frames 3",
            "--suite --roughness 1",
            "--suite --lights none",
            "--suite --surfels 1024",
            "a.cuts --surfels 3",
            "a.cuts --surfels 1024 --drag o",
            "a.cuts --surfels 1024 --illum-cuts 256",
            "a.cuts --surfels 1024 --env none",
            "a.cuts --surfels 1024 --lights none",
            "a.cuts --surfels 1024 --size 8x6",
            "a.cuts --surfels 1024 --roughness 1",
            "a.cuts --surfels 1024 --material gold.json",
            "a.cuts --drag o --illum-cuts 256",
            "--save new.json",
            "a.cuts --save new.json",
            "a.cuts --baseline old.json",
        ];
        for text in refused {
            assert!(parsed(text).is_err(), "{text}");
        }
    }
}
