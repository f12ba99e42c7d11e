//! Mutations of JSON that leave it JSON: numbers, kinds, keys and entries.

use super::{numbers, repeatedly, repetitions, text};
use crate::choices::Choices;
use serde_json::{Value, json};

/// Mutates values and keys; one time in four, and if the text is not JSON, words and bytes.
pub fn json(file: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    match serde_json::from_slice::<Value>(file) {
        Ok(mut root) if !choices.one_in(4) => {
            value(&mut root, choices);
            *file = root.to_string().into_bytes();
        }
        _ => text::text(file, others, choices),
    }
}

/// Mutates only quantities, three times in four: most of these scenes import, and so can be baked.
pub fn quantities(file: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    match serde_json::from_slice::<Value>(file) {
        Ok(mut root) if !choices.one_in(4) => {
            repeatedly(choices, |choices| {
                let mut found = Vec::new();
                find_quantities(&mut root, false, &mut found);
                if !found.is_empty() {
                    let at = choices.below(found.len());
                    vary(found.swap_remove(at), choices);
                }
            });
            *file = root.to_string().into_bytes();
        }
        _ => json(file, others, choices),
    }
}

/// Numbers that are neither counts nor indices: in vectors, fractions, and the packed numbers of buffers.
fn find_quantities<'a>(value: &'a mut Value, in_vector: bool, found: &mut Vec<&'a mut Value>) {
    match value {
        Value::Array(entries) => {
            let is_vector = entries.len() > 1 && entries.iter().all(Value::is_number);
            entries.iter_mut().for_each(|entry| find_quantities(entry, is_vector, found));
        }
        Value::Object(entries) => entries.values_mut().for_each(|entry| find_quantities(entry, false, found)),
        Value::Number(number) if in_vector || number.is_f64() => found.push(value),
        Value::String(text) if text.starts_with(PACKED) => found.push(value),
        _ => {}
    }
}

/// Prefix of texts that hold a buffer.
const PACKED: &str = "data:application/octet-stream;base64,";

/// Scales a number, or changes a character of a buffer.
fn vary(node: &mut Value, choices: &mut Choices) {
    if let Value::String(text) = node {
        let mut bytes = std::mem::take(text).into_bytes();
        let at = PACKED.len() + choices.below(bytes.len() - PACKED.len());
        if let Some(letter) = bytes.get_mut(at) {
            *letter = *choices.of(b"ABQgwz9/");
        }
        *text = String::from_utf8_lossy(&bytes).into_owned();
    } else {
        let factor = choices.of(&[-1.0, 0.0, 0.5, 0.999_999, 1.000_001, 2.0, 1e-3, 1e-7, 1e3]);
        *node = json!(node.as_f64().unwrap_or_default() * factor);
    }
}

/// Mutates nodes of a tree.
pub fn value(root: &mut Value, choices: &mut Choices) {
    repeatedly(choices, |choices| {
        let donor = node(root, choices.below(1 << 20)).cloned().unwrap_or_default();
        let count = count(root);
        let at = choices.below(count);
        // A donor may contain the whole tree, and is inserted at most twice.
        let donor = if repetitions(2, self::count(&donor), count) == 2 { donor } else { Value::Null };
        if let Some(node) = node(root, at) {
            mutate(node, donor, count, choices);
        }
    });
}

/// Number of nodes of a tree.
fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(entries) => entries.iter().map(count).sum::<usize>(),
        Value::Object(entries) => entries.values().map(count).sum(),
        _ => 0,
    }
}

/// Node `index` of a tree in document order, modulo the number of nodes.
fn node(root: &mut Value, index: usize) -> Option<&mut Value> {
    let mut left = index % count(root);
    let mut here = root;
    while left > 0 {
        left -= 1;
        let children: Vec<&mut Value> = match here {
            Value::Array(entries) => entries.iter_mut().collect(),
            Value::Object(entries) => entries.values_mut().collect(),
            _ => return None,
        };
        here = children.into_iter().find(|child| {
            let size = count(child);
            let found = left < size;
            left -= if found { 0 } else { size };
            found
        })?;
    }
    Some(here)
}

/// Mutates a node of a tree with `size` nodes.
fn mutate(node: &mut Value, donor: Value, size: usize, choices: &mut Choices) {
    let kind = choices.below(4);
    match node {
        Value::Object(entries) if kind > 0 && !entries.is_empty() => {
            let keys: Vec<String> = entries.keys().cloned().collect();
            let key = choices.of(&keys);
            match choices.below(3) {
                0 => drop(entries.remove(key)),
                1 => drop(entries.insert(key.clone(), donor)),
                _ => {
                    let moved = entries.remove(key).unwrap_or_default();
                    entries.insert(choices.of(&keys).clone(), moved);
                }
            }
        }
        Value::Array(entries) if kind > 0 && !entries.is_empty() => {
            let (at, from) = (choices.below(entries.len()), choices.below(entries.len()));
            match choices.below(5) {
                0 => drop(entries.remove(at)),
                1 => entries.swap(at, from),
                2 => entries.insert(at, donor),
                3 => entries.truncate(at),
                _ => {
                    let times = repetitions(*choices.of(&[1, 64, 2048]), count(&entries[from]), size);
                    let many = vec![entries[from].clone(); times];
                    entries.splice(at..at, many);
                }
            }
        }
        Value::String(text) if kind > 0 => {
            let mut bytes = std::mem::take(text).into_bytes();
            text::text(&mut bytes, &[], choices);
            *text = String::from_utf8_lossy(&bytes).into_owned();
        }
        Value::Number(_) if kind > 0 => *node = number(choices),
        _ => *node = other(donor, choices),
    }
}

/// A number at which readers break; JSON has no infinities.
fn number(choices: &mut Choices) -> Value {
    let text = choices.of(&numbers::TEXTS);
    serde_json::from_str(text).unwrap_or_else(|_| json!(-1e308))
}

/// A value of another kind.
fn other(donor: Value, choices: &mut Choices) -> Value {
    match choices.below(8) {
        0 => Value::Null,
        1 => json!(true),
        2 => json!(""),
        3 => json!([]),
        4 => json!({}),
        5 => number(choices),
        6 => json!([donor.clone(), donor]),
        _ => donor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_node_is_found_once() {
        let mut root = json!({"a": [1, {"b": 2}], "c": 3});
        assert_eq!(count(&root), 6);
        let found: Vec<String> = (0..6).map(|i| node(&mut root, i).unwrap().to_string()).collect();
        assert_eq!(found, [root.to_string().as_str(), "[1,{\"b\":2}]", "1", "{\"b\":2}", "2", "3"]);
    }

    #[test]
    fn counts_and_references_are_no_quantities() {
        let packed = format!("{PACKED}AAAA");
        let mut root = json!({"count": 3, "nodes": [1], "ior": 1.5, "scale": [1, 2, 3], "name": "a", "uri": packed});
        let mut found = Vec::new();
        find_quantities(&mut root, false, &mut found);
        assert_eq!(found, [&json!(1.5), &json!(1), &json!(2), &json!(3), &json!(packed)]);
        for node in found {
            let before = node.clone();
            vary(node, &mut Choices::new(&[1, 1]));
            assert_ne!(*node, before);
        }
        assert_eq!((&root["count"], &root["nodes"]), (&json!(3), &json!([1])));
    }
}
