//! `lapidary-fuzz`; see the library.

use clap::Parser;
use lapidary_fuzz::driver::{self, Options};

fn main() -> anyhow::Result<()> {
    driver::run(&Options::parse())
}
