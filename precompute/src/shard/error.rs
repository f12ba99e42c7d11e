//! Why shards make no dataset.

use super::Shard;
use std::{io, path::PathBuf};
use thiserror::Error;

/// Why shards make no dataset.
#[derive(Debug, Error)]
pub enum ShardError {
    /// No number of a shard.
    #[error("a shard is a number out of so many, as in 3/8, at most 10000; the first is 1")]
    Number,
    /// The file system refused.
    #[error("cannot read the folder: {source}; check the path and the permissions ({})", path.display())]
    Io {
        /// Which folder.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// There is nothing to merge.
    #[error("no share of a shard lies beside the dataset; bake them first, each with its --shard ({})", path.display())]
    NoShares {
        /// The dataset.
        path: PathBuf,
    },
    /// Shares of bakes that were divided differently.
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
    /// Shares that are not there.
    #[error("shares are missing; bake with {} ({})", options(missing), path.display())]
    Missing {
        /// The dataset.
        path: PathBuf,
        /// Which.
        missing: Vec<Shard>,
    },
    /// A share is not complete.
    #[error("the share is not complete; bake with --shard {shard} again, which goes on where it stopped ({})", path.display())]
    Incomplete {
        /// Which.
        shard: Shard,
        /// A part that is missing or damaged.
        path: PathBuf,
    },
    /// A share that cannot be gone on with.
    #[error(
        "the share of an earlier bake is of no use: {reason}; give the same scene and options again, or remove the folder \
         and bake with --shard {shard} ({})",
        path.display()
    )]
    OfNoUse {
        /// Which.
        shard: Shard,
        /// Its folder.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A share of another scene, other settings or another number of chunks.
    #[error(
        "the share was made with another scene, other options or another --chunks than {}; remove the one that is wrong, \
         and bake its shard again, with the options of the others; this is --shard {shard} ({})",
        first.display(), path.display()
    )]
    OfAnother {
        /// Which.
        shard: Shard,
        /// Its folder.
        path: PathBuf,
        /// The folder that it disagrees with.
        first: PathBuf,
    },
    /// A share under the name of another.
    #[error("the folder holds the share of shard {found}; give it back its name, and bake with --shard {shard} ({})", path.display())]
    Renamed {
        /// The shard by its name.
        shard: Shard,
        /// The shard by its contents.
        found: Shard,
        /// Its folder.
        path: PathBuf,
    },
}

/// The options that bake shards; of many the first.
fn options(missing: &[Shard]) -> String {
    const MOST: usize = 8;
    let listed: Vec<String> = missing.iter().take(MOST).map(|shard| format!("--shard {shard}")).collect();
    let rest = missing.len().saturating_sub(MOST);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    listed.join(", ") + &more
}
