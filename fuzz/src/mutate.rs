//! Mutations: from a valid file and [`Choices`] to a broken one that readers follow far before they notice.
//!
//! All work on bytes. [`text`] and [`json`] know numbers, lines and keys; [`containers`] updates lengths and checksums
//! around a change, so that readers reach it.

pub mod containers;
pub mod json;
pub mod numbers;
pub mod tensors;
pub mod text;
pub mod xml;

use crate::choices::Choices;

/// Mutates `bytes`. `others` are valid files of the same kind, as sources of pieces.
pub type Mutation = fn(bytes: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices);

/// Largest number of bytes, or nodes of a tree, that a mutation makes: it should break readers by contents, not by length.
const MOST: usize = 1 << 18;

/// Number of repetitions of a piece in a file of these sizes, at most `times`.
fn repetitions(times: usize, piece: usize, file: usize) -> usize {
    times.min(MOST.saturating_sub(file) / piece.max(1))
}

/// Applies `one` repeatedly: once, a few times, or while there are choices.
pub fn repeatedly(choices: &mut Choices, mut one: impl FnMut(&mut Choices)) {
    let most = *choices.of(&[1, 1, 1, 2, 2, 4, 8, 32]);
    for _ in 0..most {
        one(choices);
        if choices.are_over() {
            break;
        }
    }
}

/// Flips, sets, cuts, repeats and splices bytes, and overwrites them with numbers.
pub fn bytes(bytes: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    repeatedly(choices, |choices| one(bytes, others, choices));
}

fn one(bytes: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    let range = choices.range(bytes.len());
    let Some(first) = bytes.get_mut(range.start) else { return bytes.push(choices.byte()) };
    match choices.below(10) {
        0 => *first ^= 1 << choices.below(8),
        1 => *first = choices.byte(),
        2 => *first = *choices.of(&[0, 1, 0x7f, 0x80, 0xff, b'\n', b'"', b' ']),
        3 | 4 => numbers::overwrite(&mut bytes[range.start..], choices),
        5 => drop(bytes.drain(range)),
        6 => {
            let piece = bytes[range.clone()].to_vec();
            let times = repetitions(*choices.of(&[1, 2, 16, 256]), piece.len(), bytes.len());
            bytes.splice(range.end..range.end, piece.repeat(times));
        }
        7 => bytes.truncate(range.start),
        8 => {
            let to = choices.below(bytes.len());
            let end = range.end.min(range.start + bytes.len() - to);
            bytes.copy_within(range.start..end, to);
        }
        _ => splice(bytes, others, range, choices),
    }
}

/// Replaces a range by a piece of another file.
fn splice(bytes: &mut Vec<u8>, others: &[Vec<u8>], range: std::ops::Range<usize>, choices: &mut Choices) {
    if others.is_empty() {
        return;
    }
    let other = choices.of(others);
    let piece = choices.range(other.len());
    bytes.splice(range, other[piece].iter().copied());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_choice_is_out_of_bounds_and_nearly_all_change_something() {
        let sound: Vec<u8> = b"v 0 1 2\n{\"a\": [1, 2]}<b c=\"d\"/>".repeat(3);
        let mut random = fastrand::Rng::with_seed(1);
        let mutations: [Mutation; 6] =
            [super::bytes, text::text, json::json, json::quantities, containers::png, xml::xml];
        let mut changed = 0;
        for i in 0..4000 {
            let choices: Vec<u8> = (0..random.usize(0..60)).map(|_| random.u8(..)).collect();
            let mut file = if i % 10 == 0 { Vec::new() } else { sound.clone() };
            mutations[i % 6](&mut file, std::slice::from_ref(&sound), &mut Choices::new(&choices));
            changed += usize::from(file != sound);
        }
        assert!(changed > 3000, "{changed}");
    }
}
