//! Formats with lengths and checksums around their contents: these are updated after a change.

use super::{json, text};
use crate::choices::Choices;

/// Mutates a png file and, three times in four, recomputes the checksums of its chunks.
pub fn png(file: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    super::bytes(file, others, choices);
    if choices.one_in(4) {
        return;
    }
    let mut at = 8;
    while let Some(length) = file.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_be_bytes) {
        let end = at + 8 + length as usize;
        let Some(body) = file.get(at + 4..end) else { break };
        let sum = crc32fast::hash(body).to_be_bytes();
        let Some(place) = file.get_mut(end..end + 4) else { break };
        place.copy_from_slice(&sum);
        at = end + 4;
    }
}

/// Mutates the JSON of a glb file and updates its lengths; one time in three, mutates any bytes of the file.
pub fn glb(file: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    let parts = if choices.one_in(3) { None } else { glb_parts(file) };
    let Some((mut contents, rest)) = parts else { return super::bytes(file, others, choices) };
    json::json(&mut contents, &[], choices);
    contents.resize(contents.len().next_multiple_of(4), b' ');
    let total = 20 + contents.len() + rest.len();
    let lengths = [total as u32, contents.len() as u32].map(u32::to_le_bytes);
    let head = [&file[..8], lengths[0].as_slice(), &lengths[1], b"JSON"].concat();
    *file = [head, contents, rest].concat();
}

/// The JSON, and the chunks after it.
fn glb_parts(file: &[u8]) -> Option<(Vec<u8>, Vec<u8>)> {
    let length = u32::from_le_bytes(file.get(12..16)?.try_into().ok()?) as usize;
    Some((file.get(20..20 + length)?.to_vec(), file[20 + length..].to_vec()))
}

/// Mutates the header of a ply file as text, or all of it as bytes.
pub fn ply(file: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    let mark = b"end_header\n";
    let end = file.windows(mark.len()).position(|window| window == mark).map(|at| at + mark.len());
    match end {
        Some(end) if choices.one_in(2) => {
            let body = file.split_off(end);
            text::text(file, others, choices);
            file.extend(body);
        }
        _ if choices.one_in(2) => text::text(file, others, choices),
        _ => super::bytes(file, others, choices),
    }
}
