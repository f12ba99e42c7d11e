//! Baking without renderer or window: for render farms and scripts.

use clap::{Parser, Subcommand};
use lapidary_studies::{
    commands::{bake::BakeArgs, info::InfoArgs, merge::MergeArgs, verify::VerifyArgs},
    terminal::{Console, error_text},
};
use std::process::ExitCode;

/// Bake visibility and bounced light of scenes, and inspect and verify the result
#[derive(Parser)]
#[command(name = "precompute", version, arg_required_else_help = true)]
struct Cli {
    /// Print nothing but errors
    #[arg(long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bake a scene's visibility, and its bounced light with --mode
    Bake(Box<BakeArgs>),
    /// Merge the shares of machines that baked with --shard into a dataset
    Merge(MergeArgs),
    /// Describe a dataset
    Info(InfoArgs),
    /// Retrace random vertices, surface sources and links of a dataset, and compare
    Verify(VerifyArgs),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let console = Console { quiet: cli.quiet };
    let result = match &cli.command {
        Command::Bake(args) => args.files().check().and_then(|()| args.run(console)).map(|_| ()),
        Command::Merge(args) => args.files().check().and_then(|()| args.run(console)).map(|_| ()),
        Command::Info(args) => args.run(),
        Command::Verify(args) => args.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", error_text(&error));
            ExitCode::FAILURE
        }
    }
}
