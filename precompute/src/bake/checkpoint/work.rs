//! Chunks that a bake computes: all, the share of a shard, or none in a merge.
//!
//! Each shard computes geometry, light tree and surface sources, which takes little time, and its share of the chunks. The share is
//! a folder like a checkpoint's, beside the output.

use super::Checkpoint;
use crate::{errors::ShardError, shard::Shard};
use std::path::{Path, PathBuf};

/// The shards with shares beside an output; they must be all shards of one bake.
///
/// # Errors
/// No share, a missing one, or shares of different divisions.
pub fn shards_beside(output: &Path) -> Result<Vec<Shard>, ShardError> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).map_err(|source| ShardError::Io { path: folder.into(), source })?;
    let shares = entries.filter_map(|entry| Shard::of_folder(&entry.ok()?.path(), output));
    let mut found: Vec<Shard> = shares.collect();
    found.sort_unstable_by_key(|shard| (shard.count(), shard.index()));
    let path = output.to_path_buf();
    let (Some(first), Some(last)) = (found.first(), found.last()) else { return Err(ShardError::NoShares { path }) };
    if first.count() != last.count() {
        return Err(ShardError::Mixed { path, numbers: [first.count(), last.count()] });
    }
    let missing: Vec<Shard> = Shard::all(first.count()).filter(|shard| !found.contains(shard)).collect();
    if missing.is_empty() { Ok(found) } else { Err(ShardError::Missing { path, missing }) }
}

/// Chunks that a bake computes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Work {
    /// All chunks.
    All,
    /// The share of a shard.
    Share(Shard),
    /// None: the shares beside the output have them.
    Merge(Vec<Shard>),
}

impl Work {
    /// The folder where chunks are written.
    pub fn folder_of(&self, output: &Path) -> PathBuf {
        match self {
            Self::All | Self::Merge(_) => Checkpoint::folder_of(output),
            Self::Share(shard) => shard.folder_of(output),
        }
    }

    /// The number of chunks: at least `least`, and equally many for each shard.
    pub fn chunks(&self, least: usize) -> usize {
        match self {
            Self::All | Self::Merge(_) => least,
            Self::Share(shard) => shard.chunks(least),
        }
    }

    /// Whether the chunk of an index is included.
    pub fn has(&self, chunk: usize) -> bool {
        match self {
            Self::All | Self::Merge(_) => true,
            Self::Share(shard) => shard.makes(chunk),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_found_beside_the_output_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        let make = |name: &str| std::fs::create_dir(folder.path().join(name)).unwrap();
        assert!(matches!(shards_beside(&output), Err(ShardError::NoShares { .. })));
        let others = ["a.cuts.shard-02-of-3", "b.cuts.shard-2-of-3"];
        ["a.cuts.shard-1-of-3", "a.cuts.shard-3-of-3"].iter().chain(&others).for_each(|name| make(name));
        let Err(ShardError::Missing { missing, .. }) = shards_beside(&output) else { panic!("the second is missing") };
        assert_eq!(missing, [Shard::new(2, 3).unwrap()]);
        make("a.cuts.shard-2-of-3");
        assert_eq!(shards_beside(&output).unwrap(), Shard::all(3).collect::<Vec<_>>());
        make("a.cuts.shard-1-of-4");
        assert!(matches!(shards_beside(&output), Err(ShardError::Mixed { numbers: [3, 4], .. })));
    }
}
