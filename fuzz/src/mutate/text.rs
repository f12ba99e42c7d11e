//! Mutations of text files, by words and lines.

use super::{numbers, repeatedly, repetitions};
use crate::choices::Choices;
use std::ops::Range;

/// Words that change a reader's behavior.
const WORDS: [&str; 24] = [
    "/dev/zero",
    "/dev/stdin",
    "../../../../etc/passwd",
    "data:,",
    "data:image/png;base64,",
    ".",
    "..",
    "",
    "\0",
    "#",
    "\\\n",
    "f",
    "v",
    "vn",
    "vt",
    "usemtl",
    "mtllib",
    "o",
    "end_header",
    "element vertex 4294967295",
    "property list uchar int",
    "null",
    "true",
    "\u{feff}",
];

/// Mutates words, lines and sometimes single bytes.
pub fn text(text: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    repeatedly(choices, |choices| {
        if choices.one_in(4) {
            super::one(text, others, choices);
        } else if choices.one_in(3) {
            mutate_lines(text, others, choices);
        } else {
            mutate_word(text, choices);
        }
    });
}

fn mutate_word(text: &mut Vec<u8>, choices: &mut Choices) {
    let words = words(text);
    if words.is_empty() {
        return;
    }
    let range = choices.of(&words).clone();
    let other = text[choices.of(&words).clone()].to_vec();
    let new = match choices.below(6) {
        0..=2 => choices.of(&numbers::TEXTS).as_bytes().to_vec(),
        3 => choices.of(&WORDS).as_bytes().to_vec(),
        4 => other,
        _ => Vec::new(),
    };
    text.splice(range, new);
}

/// Ranges between blanks, quotes, slashes and punctuation.
fn words(text: &[u8]) -> Vec<Range<usize>> {
    let within = |byte: &u8| byte.is_ascii_alphanumeric() || b".-+_".contains(byte);
    let mut words: Vec<Range<usize>> = Vec::new();
    for (i, _) in text.iter().enumerate().filter(|(_, byte)| within(byte)) {
        match words.last_mut() {
            Some(last) if last.end == i => last.end += 1,
            _ => words.push(i..i + 1),
        }
    }
    words
}

fn mutate_lines(text: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    let mut lines: Vec<Vec<u8>> = text.split_inclusive(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
    if lines.is_empty() {
        return;
    }
    let (at, from) = (choices.below(lines.len()), choices.below(lines.len()));
    match choices.below(5) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(at, lines[from].clone()),
        2 => lines.swap(at, from),
        3 => {
            let times = repetitions(*choices.of(&[2, 64, 4096]), lines[from].len(), text.len());
            let many = vec![lines[from].clone(); times];
            lines.splice(at..at, many);
        }
        _ if others.is_empty() => {}
        _ => {
            let other = choices.of(others);
            let theirs: Vec<&[u8]> = other.split_inclusive(|&b| b == b'\n').collect();
            if !theirs.is_empty() {
                lines.insert(at, choices.of(&theirs).to_vec());
            }
        }
    }
    *text = lines.concat();
}
