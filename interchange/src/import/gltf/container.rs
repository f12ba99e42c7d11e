//! The container of a glTF file: a JSON text, or a GLB with chunks (glTF 2.0, section 4).
//!
//! Programs write wrong lengths and paddings: up to [`MOST_SLACK`] bytes too many or too few are accepted, and unknown chunks
//! are skipped. The `gltf` crate refuses such files.

/// Bytes by which lengths may be wrong: chunks end at multiples of four.
const MOST_SLACK: usize = 3;

/// Bytes of the header of a GLB.
const HEADER: usize = 12;

/// Bytes of the header of a chunk.
const CHUNK_HEADER: usize = 8;

/// The contents of a file.
pub(crate) struct Container<'a> {
    pub json: &'a [u8],
    pub blob: Option<&'a [u8]>,
}

/// Why there are no contents.
pub(crate) enum Unreadable {
    /// A GLB of another version.
    Version(u32),
    /// The problem.
    Damaged(String),
}

impl<'a> Container<'a> {
    pub fn of(bytes: &'a [u8]) -> Result<Self, Unreadable> {
        if !bytes.starts_with(b"glTF") {
            return Ok(Self { json: bytes, blob: None });
        }
        let [version, length] = [4, 8].map(|at| word(bytes, at));
        let (Some(version), Some(length)) = (version, length.filter(|length| *length as usize >= HEADER)) else {
            return Err(Unreadable::Damaged("the header of the binary file is damaged".into()));
        };
        if version != 2 {
            return Err(Unreadable::Version(version));
        }
        if length as usize > bytes.len() + MOST_SLACK {
            return Err(Unreadable::Damaged(format!("it has {} of {length} bytes, it was truncated", bytes.len())));
        }
        let chunks = chunks(bytes).map_err(Unreadable::Damaged)?;
        let of = |kind: &[u8]| chunks.iter().find(|chunk| chunk.kind == kind).map(|chunk| chunk.data);
        let json = of(b"JSON").ok_or_else(|| Unreadable::Damaged("the binary file has no JSON chunk".into()))?;
        let end = json.iter().rposition(|byte| !matches!(byte, 0 | b' ')).map_or(0, |last| last + 1);
        Ok(Self { json: &json[..end], blob: of(b"BIN\0") })
    }
}

struct Chunk<'a> {
    kind: &'a [u8],
    data: &'a [u8],
}

/// The chunks of a GLB, in sequence.
fn chunks(bytes: &[u8]) -> Result<Vec<Chunk<'_>>, String> {
    let mut chunks = Vec::new();
    let mut at = HEADER;
    while let (Some(length), Some(kind)) = (word(bytes, at), bytes.get(at + 4..at + CHUNK_HEADER)) {
        let (start, length) = (at + CHUNK_HEADER, length as usize);
        let available = bytes.len() - start;
        if length > available + MOST_SLACK {
            let is_known = matches!(kind, b"JSON" | b"BIN\0");
            if !is_known && !chunks.is_empty() {
                break; // bytes after the last chunk
            }
            let kind = String::from_utf8_lossy(kind);
            return Err(format!(
                "its chunk \"{}\" has {available} of {length} bytes, it was truncated",
                kind.trim_end_matches('\0')
            ));
        }
        let end = start + length.min(available);
        chunks.push(Chunk { kind, data: &bytes[start..end] });
        at = next_chunk(bytes, end);
    }
    Ok(chunks)
}

/// Where the chunk after `end` starts: a known chunk a few bytes further, else the next multiple of four that the format asks for.
fn next_chunk(bytes: &[u8], end: usize) -> usize {
    let is_chunk =
        |at: &usize| bytes.get(at + 4..at + CHUNK_HEADER).is_some_and(|kind| matches!(kind, b"JSON" | b"BIN\0"));
    (end..=end + MOST_SLACK).find(is_chunk).unwrap_or(end.next_multiple_of(4))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
}
