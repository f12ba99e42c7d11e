//! Which files a scene or a material may name.

use clap::Args;
use lapidary_interchange::import::ImportOptions;

/// Whether files outside the folder are read.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct OutsideArgs {
    /// Allow files outside the folder: also read pictures, buffers and material libraries that the scene or material file names
    /// outside its own folder; their contents go into the dataset. Without this they are listed and not read
    #[arg(long)]
    allow_outside: bool,
}

impl From<OutsideArgs> for ImportOptions {
    fn from(args: OutsideArgs) -> Self {
        Self { allow_outside: args.allow_outside, ..Self::default() }
    }
}
