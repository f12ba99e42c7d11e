//! `lapidary-fuzz`; see the library beside it.

use clap::Parser;
use lapidary_fuzz::driver::{self, Options};

fn main() -> anyhow::Result<()> {
    driver::run(&Options::parse())
}
