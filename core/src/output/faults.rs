//! Injected failures of the file system, for tests: `LAPIDARY_TEST_FAULT="3 no-space"` fails the third file that a
//! process writes. Only in builds with the feature `test-faults`.

use std::{
    io::{self, Write},
    sync::{
        OnceLock,
        atomic::{AtomicUsize, Ordering},
    },
};

/// Kind of failure in writing a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The second half of its last part is missing.
    Short,
    /// The second half of its last part is missing, because the disk is full.
    NoSpace,
    /// All bytes are written, and the file keeps its temporary name.
    Rename,
}

/// The failure of the next file, if any.
#[derive(Clone, Copy, Debug)]
pub struct Fault(Option<Kind>);

/// The fault for the next file of this process.
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
    /// Writes, unless this fault is in writing.
    ///
    /// # Errors
    /// The injected failure.
    pub fn write(self, file: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
        let error = match self.0 {
            Some(Kind::Short) => io::ErrorKind::WriteZero.into(),
            Some(Kind::NoSpace) => io::ErrorKind::StorageFull.into(),
            _ => return Ok(()),
        };
        file.write_all(&bytes[..bytes.len() / 2])?;
        Err(error)
    }

    /// Fails if this fault is in renaming.
    ///
    /// # Errors
    /// The injected failure.
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
