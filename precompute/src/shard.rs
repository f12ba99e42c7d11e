//! Shards: parts of a bake for several machines.

mod error;

pub use error::ShardError;

use std::{
    fmt,
    path::{Path, PathBuf},
    str::FromStr,
};

/// Most shards of a bake.
const MOST: usize = 10_000;

/// One of several parts of a bake of about equal size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number from 1.
    index: usize,
    /// Number of shards.
    of: usize,
}

impl Shard {
    /// Shard `index`, from 1, of `of`.
    ///
    /// # Errors
    /// Numbers that form no shard.
    pub fn new(index: usize, of: usize) -> Result<Self, ShardError> {
        if (1..=of).contains(&index) && of <= MOST { Ok(Self { index, of }) } else { Err(ShardError::Number) }
    }

    /// The first of `of` shards, at least one.
    pub(crate) fn first(of: usize) -> Self {
        Self { index: 1, of: of.max(1) }
    }

    /// All shards of a bake.
    pub fn all(of: usize) -> impl Iterator<Item = Self> {
        (1..=of).map(move |index| Self { index, of })
    }

    /// Number from 1.
    pub fn index(self) -> usize {
        self.index
    }

    /// Number of shards.
    pub fn count(self) -> usize {
        self.of
    }

    /// Whether it computes the chunk of an index. Neighboring chunks, which take equally long, go to different shards.
    pub(crate) fn makes(self, chunk: usize) -> bool {
        chunk % self.of == self.index - 1
    }

    /// A number of chunks, at least `least`, that divides equally among the shards.
    pub(crate) fn chunks(self, least: usize) -> usize {
        least.next_multiple_of(self.of)
    }

    /// The folder of its share.
    pub fn folder_of(self, output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(format!(".shard-{}-of-{}", self.index, self.of));
        name.into()
    }

    /// The shard of a folder beside `output`, if it holds a share.
    pub(crate) fn of_folder(folder: &Path, output: &Path) -> Option<Self> {
        let name = folder.file_name()?.to_str()?.strip_prefix(output.file_name()?.to_str()?)?;
        let (index, of) = name.strip_prefix(".shard-")?.split_once("-of-")?;
        let shard = Self::new(index.parse().ok()?, of.parse().ok()?).ok()?;
        (shard.folder_of(output).file_name() == folder.file_name()).then_some(shard)
    }
}

/// Formats as `3/8`.
impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let (index, of) = text.split_once('/').ok_or(ShardError::Number)?;
        let number = |text: &str| text.parse().map_err(|_| ShardError::Number);
        Self::new(number(index)?, number(of)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_read_as_they_are_written_and_share_all_chunks() {
        let three: Shard = "3/8".parse().unwrap();
        assert_eq!((three, three.to_string().as_str()), (Shard::new(3, 8).unwrap(), "3/8"));
        for bad in ["0/8", "9/8", "3", "a/8", "3/0", "3/", "1/20000", "-1/4"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
        for chunk in 0..20 {
            assert_eq!(Shard::all(8).filter(|shard| shard.makes(chunk)).count(), 1);
        }
        assert_eq!((three.chunks(1), three.chunks(25), three.chunks(32)), (8, 32, 32));
    }
}
