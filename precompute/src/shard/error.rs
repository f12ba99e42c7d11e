//! Errors of shards.

use super::Shard;
use std::{io, path::PathBuf};
use thiserror::Error;

/// Why shards form no dataset.
#[derive(Debug, Error)]
pub enum ShardError {
    /// Invalid numbers.
    #[error("a shard is a number and a total, as in 3/8, at most 10000; the first is 1")]
    Number,
    /// A share of a bake that hides objects, which takes a whole one.
    #[error("a share of a bake cannot hide objects; merge the shares, then hide them with --update and --pose")]
    Hidden,
    /// The folder cannot be read.
    #[error("cannot read the folder: {source}; check the path and the permissions ({})", path.display())]
    Io {
        /// The folder.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// There are no shares to merge.
    #[error("no share of a shard lies beside the dataset; bake them first, each with its --shard ({})", path.display())]
    NoShares {
        /// The dataset.
        path: PathBuf,
    },
    /// Shares of different divisions.
    #[error(
        "shares of {} and of {} shards lie beside the dataset; remove those that do not belong to it ({})",
        numbers[0], numbers[1], path.display()
    )]
    Mixed {
        /// The dataset.
        path: PathBuf,
        /// Two numbers of shards.
        numbers: [usize; 2],
    },
    /// Missing shares.
    #[error("shares are missing; bake with {} ({})", options(missing), path.display())]
    Missing {
        /// The dataset.
        path: PathBuf,
        /// Missing shards.
        missing: Vec<Shard>,
    },
    /// An incomplete share.
    #[error("the share is not complete; bake with --shard {shard} again to resume it ({})", path.display())]
    Incomplete {
        /// The shard.
        shard: Shard,
        /// A missing or damaged file.
        path: PathBuf,
    },
    /// A share that cannot be resumed.
    #[error(
        "the share of an earlier bake cannot be used: {reason}; give the same scene and options again, or remove the folder \
         and bake with --shard {shard} ({})",
        path.display()
    )]
    OfNoUse {
        /// The shard.
        shard: Shard,
        /// Its folder.
        path: PathBuf,
        /// The problem.
        reason: String,
    },
    /// A share of another scene, other settings or another number of chunks.
    #[error(
        "the share was made with another scene, other options or another --chunks than {}; remove the wrong one, \
         and bake its shard again, with the options of the others; this is --shard {shard} ({})",
        first.display(), path.display()
    )]
    OfAnother {
        /// The shard.
        shard: Shard,
        /// Its folder.
        path: PathBuf,
        /// The folder that disagrees with it.
        first: PathBuf,
    },
    /// A share under another shard's name.
    #[error("the folder holds the share of shard {found}; give it back its name, and bake with --shard {shard} ({})", path.display())]
    Renamed {
        /// The shard in its name.
        shard: Shard,
        /// The shard in its contents.
        found: Shard,
        /// Its folder.
        path: PathBuf,
    },
}

/// Options that bake the missing shards; only the first of many.
fn options(missing: &[Shard]) -> String {
    const MOST: usize = 8;
    let listed: Vec<String> = missing.iter().take(MOST).map(|shard| format!("--shard {shard}")).collect();
    let rest = missing.len().saturating_sub(MOST);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    listed.join(", ") + &more
}
