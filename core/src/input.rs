//! Reads files named by a user. Only regular files are read, also through links: a device such as `/dev/zero` has no
//! end, and a pipe may wait forever.

use crate::memory;
use std::{
    borrow::Cow,
    fs::{File, FileType, Metadata, metadata},
    io::{self, Error, ErrorKind, Read},
    path::Path,
};

/// The contents of a regular file.
///
/// # Errors
/// See [`open`]; also a file that exceeds the free memory or grows while it is read, and errors of the file system.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let (file, length) = open_to_hold(path)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(length).unwrap_or(usize::MAX))?;
    file.take(length.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > length {
        return Err(Error::new(
            ErrorKind::InvalidData,
            format!("it holds more than its length of {length} bytes; wait until it is written, or copy it to a disk"),
        ));
    }
    Ok(bytes)
}

/// The contents of a regular file as text; see [`text`].
///
/// # Errors
/// See [`read`] and [`text`]; also contents that are not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read(path)?;
    String::from_utf8(text(&bytes)?.into_owned()).map_err(|_| damaged("it is not UTF-8 text"))
}

/// The bytes of a text without its byte order mark, which editors of Windows put first. UTF-16 with a mark becomes UTF-8.
/// Bytes without a mark stay, whatever they are. Everything that is read as text passes through here.
///
/// # Errors
/// Text in UTF-32, and damaged UTF-16.
pub fn text(bytes: &[u8]) -> io::Result<Cow<'_, [u8]>> {
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => Ok(rest.into()),
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Err(damaged("it is UTF-32 text; save it as UTF-8")),
        [0xff, 0xfe, rest @ ..] => Ok(from_utf16(rest, u16::from_le_bytes)?.into()),
        [0xfe, 0xff, rest @ ..] => Ok(from_utf16(rest, u16::from_be_bytes)?.into()),
        _ => Ok(bytes.into()),
    }
}

fn from_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> io::Result<Vec<u8>> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let text: Result<String, _> = char::decode_utf16(pairs.iter().map(|&pair| unit(pair))).collect();
    match text {
        Ok(text) if rest.is_empty() => Ok(text.into_bytes()),
        _ => Err(damaged("it is damaged UTF-16 text; save it as UTF-8")),
    }
}

fn damaged(reason: &str) -> Error {
    Error::new(ErrorKind::InvalidData, reason)
}

/// Opens a regular file for reading. Anything else is refused before it is opened.
///
/// # Errors
/// A folder, a device, a pipe or a socket, and errors of the file system.
pub fn open(path: &Path) -> io::Result<File> {
    check_regular(&metadata(path)?)?;
    let file = File::open(path)?;
    // Another program may have replaced the file.
    check_regular(&file.metadata()?)?;
    Ok(file)
}

/// Opens a regular file whose contents will be held in memory, and returns its length in bytes.
///
/// # Errors
/// See [`open`]; also a file that exceeds the free memory.
pub fn open_to_hold(path: &Path) -> io::Result<(File, u64)> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    check_room(length, memory::available())?;
    Ok((file, length))
}

/// Whether a file is in a folder or below it, after resolving links.
pub fn is_inside(folder: &Path, file: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    matches!((folder.canonicalize(), file.canonicalize()), (Ok(folder), Ok(file)) if file.starts_with(&folder))
}

fn check_regular(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    let kind = if metadata.is_dir() { ErrorKind::IsADirectory } else { ErrorKind::InvalidInput };
    Err(Error::new(kind, format!("it is {}, and only regular files are read", what_it_is(metadata.file_type()))))
}

#[cfg(unix)]
pub(crate) fn what_it_is(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        _ if kind.is_dir() => "a folder",
        _ if kind.is_fifo() => "a pipe",
        _ if kind.is_socket() => "a socket",
        _ => "a device",
    }
}

#[cfg(not(unix))]
pub(crate) fn what_it_is(kind: FileType) -> &'static str {
    if kind.is_dir() { "a folder" } else { "a device" }
}

fn check_room(length: u64, available: Option<u64>) -> io::Result<()> {
    match available {
        Some(available) if length > available => {
            let [length, available] = memory::in_megabytes(length, available);
            let message = format!("it has {length} MB, but {available} MB of memory are free");
            Err(Error::new(ErrorKind::OutOfMemory, message))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn refusal(path: &Path) -> String {
        read(path).unwrap_err().to_string()
    }

    #[test]
    fn a_regular_file_is_read_and_through_a_link_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, [1, 2, 255]).unwrap();
        assert_eq!(read(&path).unwrap(), [1, 2, 255]);
        assert_eq!(read_text(&path).unwrap_err().kind(), ErrorKind::InvalidData);
        std::fs::write(&path, "ä").unwrap();
        assert_eq!(read_text(&path).unwrap(), "ä");
        assert_eq!(read(&folder.path().join("b")).unwrap_err().kind(), ErrorKind::NotFound);
        assert!(refusal(folder.path()).contains("a folder"));
    }

    #[test]
    fn byte_order_marks_are_removed_and_utf16_is_decoded() {
        let marked = |mark: &[u8], units: &dyn Fn(u16) -> [u8; 2]| {
            let units = "v ä 𝄞".encode_utf16().flat_map(units);
            mark.iter().copied().chain(units).collect::<Vec<u8>>()
        };
        let (little, big) = (marked(b"\xff\xfe", &u16::to_le_bytes), marked(b"\xfe\xff", &u16::to_be_bytes));
        for bytes in ["\u{feff}v ä 𝄞".as_bytes(), &little, &big, "v ä 𝄞".as_bytes()] {
            assert_eq!(*text(bytes).unwrap(), *"v ä 𝄞".as_bytes(), "{bytes:?}");
        }
        assert_eq!(*text(b"\xef\xbbv").unwrap(), *b"\xef\xbbv", "half a mark is none");
        assert_eq!(*text("v\u{feff}".as_bytes()).unwrap(), *"v\u{feff}".as_bytes(), "only at the start");
        assert_eq!(*text(b"\xff\xfe").unwrap(), *b"");
        for (bytes, named) in [
            (&little[..little.len() - 1], "damaged UTF-16"),
            (&little[..little.len() - 2], "damaged UTF-16"), // half a pair of surrogates
            (&b"\xff\xfe\0\0v\0\0\0"[..], "UTF-32"),
            (&b"\0\0\xfe\xff\0\0\0v"[..], "UTF-32"),
        ] {
            let message = text(bytes).unwrap_err().to_string();
            assert!(message.contains(named), "{message}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn devices_pipes_and_sockets_are_refused_at_once_and_through_links_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::os::unix::fs::symlink("/dev/zero", path("link")).unwrap();
        let made = std::process::Command::new("mkfifo").arg(path("pipe")).status().unwrap();
        assert!(made.success());
        let _socket = std::os::unix::net::UnixListener::bind(path("socket")).unwrap();
        let cases: [(PathBuf, &str); 5] = [
            ("/dev/zero".into(), "a device"),
            ("/dev/null".into(), "a device"),
            (path("link"), "a device"),
            (path("pipe"), "a pipe"),
            (path("socket"), "a socket"),
        ];
        for (path, what) in cases {
            let message = refusal(&path);
            assert!(message.contains(what), "{}: {message}", path.display());
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_file_that_holds_more_than_its_length_is_refused() {
        // The system generates its contents on reading, and reports a length of 0.
        assert!(refusal(Path::new("/proc/self/status")).contains("more than its length of 0 bytes"));
    }

    #[test]
    fn a_file_larger_than_the_memory_is_refused_with_both_numbers() {
        let message = check_room(5_000_000, Some(3_999_999)).unwrap_err().to_string();
        assert!(message.contains("5 MB") && message.contains("3 MB"), "{message}");
        assert!(check_room(5_000_000, Some(5_000_000)).is_ok() && check_room(u64::MAX, None).is_ok());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sparse");
        File::create(&path).unwrap().set_len(1 << 42).unwrap();
        assert_eq!(read(&path).unwrap_err().kind(), ErrorKind::OutOfMemory);
    }
}
