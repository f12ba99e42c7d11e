//! The `lapidary` program: a window for look-dev, and a command line over baking, rendering and comparing.

mod actions;
mod app;
mod cli;
mod document;
mod edit;
mod jobs;
mod panels;
mod paths;
mod preferences;
#[cfg(test)]
mod test_support;
mod viewport;

use clap::Parser;
use cli::Cli;
use lapidary_studies::terminal::{Console, Outcome, error_text};
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome = cli.chosen().run(Console { quiet: cli.quiet });
    let outcome = outcome.unwrap_or_else(|error| {
        eprintln!("error: {}", error_text(&error));
        Outcome::of_error(&error)
    });
    outcome.into()
}
