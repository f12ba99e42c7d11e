//! The `lapidary` program: a window for look-dev, and a command line over baking, rendering and comparing.

mod actions;
mod app;
mod backend_option;
mod cli;
mod commands;
mod console;
mod demo;
mod document;
mod evidence;
mod export;
mod fading;
mod jobs;
mod ladder;
mod look;
mod mitsuba;
mod options;
mod outcome;
mod outputs;
mod panels;
mod paths;
mod picture_args;
mod preferences;
mod progress;
mod report_html;
mod sequence;
mod sheet;
mod view_args;
mod viewport;
mod whole_picture;

use clap::Parser;
use cli::Cli;
use lapidary_precompute::cli::error_text;
use outcome::Outcome;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome = cli.chosen().run(console::Console { quiet: cli.quiet });
    let outcome = outcome.unwrap_or_else(|error| {
        eprintln!("error: {}", error_text(&error));
        Outcome::of_error(&error)
    });
    outcome.into()
}
