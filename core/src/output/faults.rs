//! Failures of the file system, for tests: `LAPIDARY_TEST_FAULT="3 no-space"` makes the third file fail that a process
//! writes. Only the feature `test-faults` has them.

use std::{
    io::{self, Write},
    sync::{
        OnceLock,
        atomic::{AtomicUsize, Ordering},
    },
};

/// How the writing of a file fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// All but half of its last part is written.
    Short,
    /// All but half of its last part is written, then the disk is full.
    NoSpace,
    /// All bytes are written, and the file keeps its temporary name.
    Rename,
}

/// What happens to the file that is about to be written.
#[derive(Clone, Copy, Debug)]
pub struct Fault(Option<Kind>);

/// That of the next file of this process.
pub fn next() -> Fault {
    static WRITTEN: AtomicUsize = AtomicUsize::new(0);
    static WANTED: OnceLock<Option<(usize, Kind)>> = OnceLock::new();
    let number = 1 + WRITTEN.fetch_add(1, Ordering::Relaxed);
    let wanted = WANTED.get_or_init(|| parse(&std::env::var("LAPIDARY_TEST_FAULT").ok()?));
    Fault(wanted.filter(|(at, _)| *at == number).map(|(_, kind)| kind))
}

fn parse(text: &str) -> Option<(usize, Kind)> {
    let (number, kind) = text.split_once(' ')?;
    let kind = match kind {
        "short" => Kind::Short,
        "no-space" => Kind::NoSpace,
        "rename" => Kind::Rename,
        _ => return None,
    };
    Some((number.parse().ok()?, kind))
}

impl Fault {
    /// Fails in writing, if it is to.
    ///
    /// # Errors
    /// The failure.
    pub fn write(self, file: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
        let error = match self.0 {
            Some(Kind::Short) => io::ErrorKind::WriteZero.into(),
            Some(Kind::NoSpace) => io::ErrorKind::StorageFull.into(),
            _ => return Ok(()),
        };
        file.write_all(&bytes[..bytes.len() / 2])?;
        Err(error)
    }

    /// Fails in renaming, if it is to.
    ///
    /// # Errors
    /// The failure.
    pub fn rename(self) -> io::Result<()> {
        if self.0 == Some(Kind::Rename) { Err(io::ErrorKind::PermissionDenied.into()) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_read_and_fail_where_they_say() {
        let fault = |text| Fault(parse(text).map(|(_, kind)| kind));
        for (text, written) in [("1 short", 2), ("2 no-space", 2), ("3 rename", 0), ("4 nothing", 0), ("", 0)] {
            let mut file = Vec::new();
            assert_eq!(fault(text).write(&mut file, b"four").is_err(), written > 0, "{text}");
            assert_eq!((file.len(), fault(text).rename().is_err()), (written, text == "3 rename"));
        }
    }
}
