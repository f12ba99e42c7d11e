//! Mutations of XML documents that leave them XML: attribute values change, and elements move.

use super::{numbers, repeatedly, text};
use crate::choices::Choices;
use std::ops::Range;

/// Values that change a reader's behavior.
const VALUES: [&str; 12] = [
    "1, 2",
    "0, 0, 0, 0",
    "true",
    "color4",
    "float",
    "nodegraph",
    "bump",
    "srgb_texture",
    "acescg",
    "tex.png",
    "../../etc/passwd",
    "outz",
];

/// Mutates values and elements; sometimes words and bytes, as in any text.
pub fn xml(bytes: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    if choices.one_in(5) {
        return text::text(bytes, others, choices);
    }
    repeatedly(choices, |choices| {
        if choices.one_in(4) {
            repeat_element(bytes, choices);
        } else {
            change_value(bytes, choices);
        }
    });
}

/// Replaces the text between two quotes by another quoted text, or by a value of the lists.
fn change_value(bytes: &mut Vec<u8>, choices: &mut Choices) {
    let values = between(bytes, b'"', b'"');
    if values.is_empty() {
        return;
    }
    let at = choices.of(&values).clone();
    let new = match choices.below(4) {
        0 => choices.of(&numbers::TEXTS).as_bytes().to_vec(),
        1 => choices.of(&VALUES).as_bytes().to_vec(),
        _ => bytes[choices.of(&values).clone()].to_vec(),
    };
    bytes.splice(at, new.into_iter().filter(|byte| !b"\"<&".contains(byte)));
}

/// Copies an element without contents to another place, or removes it.
fn repeat_element(bytes: &mut Vec<u8>, choices: &mut Choices) {
    let elements: Vec<Range<usize>> = between(bytes, b'<', b'>')
        .into_iter()
        .filter(|inner| bytes[..inner.end].ends_with(b"/"))
        .map(|inner| inner.start - 1..inner.end + 1)
        .collect();
    if elements.is_empty() {
        return;
    }
    let (from, to) = (choices.of(&elements).clone(), choices.of(&elements).clone());
    let piece = if choices.one_in(3) { Vec::new() } else { bytes[from].to_vec() };
    bytes.splice(to, piece);
}

/// Ranges from each `open` to the following `close`.
fn between(bytes: &[u8], open: u8, close: u8) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(start) = bytes[at..].iter().position(|byte| *byte == open).map(|i| at + i + 1) {
        let Some(end) = bytes[start..].iter().position(|byte| *byte == close).map(|i| start + i) else { break };
        found.push(start..end);
        at = end + 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_elements_are_found() {
        let text = b"<a b=\"c\"><d e=\"\"/></a>";
        assert_eq!(between(text, b'"', b'"'), [6..7, 15..15]);
        assert_eq!(between(text, b'<', b'>'), [1..8, 10..17, 19..21]);
        assert!(between(b"\"", b'"', b'"').is_empty());
    }
}
