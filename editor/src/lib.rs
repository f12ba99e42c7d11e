//! The `lapidary` program: a window for look-dev, and a command line over baking, rendering and comparing.
//!
//! A library, so that tests and fuzzers can use it without a window: [`main`] runs the command line, [`check`](check()) reads a
//! session file and all its files.

mod actions;
mod app;
mod bake;
mod bounds;
mod check;
mod cli;
mod compare;
mod control_names;
mod document;
mod dragged;
mod edit;
mod environment;
mod explain;
mod export;
mod jobs;
mod ladder;
mod lights;
mod look;
mod looks;
mod materials;
mod messages;
mod navigation;
mod paths;
mod picture;
mod pose;
mod preferences;
mod scene;
#[cfg(test)]
mod test_support;
mod typing;
mod view;
mod viewport;
mod widgets;
mod workspace;

pub use crate::{
    check::{Checked, check},
    document::session::SessionError,
};

use crate::{
    cli::{Cli, SessionCli},
    looks::command::RenderSessionArgs,
};
use clap::Parser;
use lapidary_studies::terminal::{Console, Outcome, error_text};
use std::process::ExitCode;

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let arguments = cli::with_command(std::env::args_os().collect());
    let outcome = if RenderSessionArgs::are_meant(&arguments) {
        SessionCli::parse_from(arguments).run()
    } else {
        let cli = Cli::parse_from(arguments);
        cli.chosen().run(Console { quiet: cli.quiet })
    };
    let outcome = outcome.unwrap_or_else(|error| {
        eprintln!("error: {}", error_text(&error));
        Outcome::of_error(&error)
    });
    outcome.into()
}
