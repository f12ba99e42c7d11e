//! Which files a scene or a material may name.

use clap::Args;
use lapidary_interchange::import::ImportOptions;

/// Whether files outside the folder are read.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct OutsideArgs {
    /// Allow files outside the folder: also read pictures, buffers and material libraries that the scene or the material
    /// file names outside its own folder; a dataset holds what they hold. Without this they are named and not read
    #[arg(long)]
    allow_outside: bool,
}

impl From<OutsideArgs> for ImportOptions {
    fn from(args: OutsideArgs) -> Self {
        Self { allow_outside: args.allow_outside, ..Self::default() }
    }
}
