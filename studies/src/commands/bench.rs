//! `lapidary bench`: how long each pass of a frame takes, or a suite of figures on the bundled scenes.

mod passes;
mod suite;

use crate::{
    args::{LocalLightArgs, ViewArgs},
    outputs::CommandFiles,
    terminal::{Console, Outcome},
};
use anyhow::Result;
use clap::Args;
use passes::PassesArgs;
use std::time::Duration;
use suite::SuiteArgs;

/// Options of `bench`.
#[derive(Args, Clone, Debug)]
#[command(mut_arg("file", |file| file.required_unless_present("suite")))]
pub struct BenchArgs {
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    suite: SuiteArgs,
    #[command(flatten)]
    passes: PassesArgs,
    #[command(flatten)]
    local: LocalLightArgs,
    /// Nothing for the suite, which has its own scenes.
    #[command(flatten)]
    view: Option<ViewArgs>,
}

impl BenchArgs {
    /// What it reads and writes.
    pub fn files(&self) -> CommandFiles {
        self.view.as_ref().map_or_else(|| self.suite.files(), |view| view.files(&self.local))
    }
}

/// Measures and prints.
///
/// # Errors
/// Files that cannot be read, or no adapter where one is asked for.
pub fn run(args: &BenchArgs, console: Console) -> Result<Outcome> {
    match &args.view {
        Some(view) => passes::run(&args.passes, &view.resolve(&args.local, console)?, args.json)?,
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
        assert!(bench("a.cuts --size 8x6 --env none --frames 1").is_ok_and(|bench| bench.view.is_some()));
        assert!(bench("--suite --save new.json --json").is_ok_and(|bench| bench.view.is_none()));
        let refused = [
            "",
            "--json",
            "--suite a.cuts",
            "--suite --size 8x6",
            "--suite --env none",
            "--suite --frames 3",
            "--suite --roughness 1",
            "--suite --lights none",
            "a.cuts --save new.json",
            "a.cuts --baseline old.json",
        ];
        for text in refused {
            assert!(parsed(text).is_err(), "{text}");
        }
    }
}
