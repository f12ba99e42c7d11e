//! Mutations of datasets whose tensors and metadata keep valid checksums: only the check of contents protects the renderer.

use super::{json, numbers, repeatedly};
use crate::choices::Choices;
use serde_json::{Map, Value, json};
use std::ops::Range;

/// Mutates tensors or metadata of a dataset and reseals it; one time in sixteen, mutates bytes of the file.
pub fn dataset(file: &mut Vec<u8>, others: &[Vec<u8>], choices: &mut Choices) {
    let opened = if choices.one_in(16) { None } else { Opened::new(file) };
    let Some(mut opened) = opened else { return super::bytes(file, others, choices) };
    match choices.below(4) {
        0 => opened.mutate_metadata(choices),
        _ => opened.mutate_tensors(choices),
    }
    *file = opened.sealed();
}

/// All tensors of a dataset with their descriptions, without the metadata.
pub fn tensors_of(file: &[u8]) -> Option<Vec<u8>> {
    let mut opened = Opened::new(file)?;
    opened.header.remove("__metadata__");
    Some([Value::Object(opened.header).to_string().into_bytes(), opened.data].concat())
}

/// A parsed dataset.
struct Opened {
    /// Header of the file: type, shape and byte range of each tensor.
    header: Map<String, Value>,
    /// Lapidary's own header, a text within that header.
    metadata: Value,
    data: Vec<u8>,
}

impl Opened {
    fn new(file: &[u8]) -> Option<Self> {
        let length = usize::try_from(u64::from_le_bytes(file.get(..8)?.try_into().ok()?)).ok()?;
        let (header, data) = file.get(8..)?.split_at_checked(length)?;
        let header: Map<String, Value> = serde_json::from_slice(header).ok()?;
        let metadata = serde_json::from_str(header.get("__metadata__")?.get("lapidary")?.as_str()?).ok()?;
        Some(Self { header, metadata, data: data.to_vec() })
    }

    fn mutate_metadata(&mut self, choices: &mut Choices) {
        match choices.below(4) {
            0 => {
                let mut mutated = Value::Object(self.header.clone());
                json::value(&mut mutated, choices);
                if let Value::Object(header) = mutated {
                    self.header = header;
                }
            }
            _ => json::value(&mut self.metadata, choices),
        }
    }

    fn tensors(&self) -> Vec<(String, Range<usize>)> {
        let range = |tensor: &Value| {
            let offset = |i: usize| tensor["data_offsets"][i].as_u64().and_then(|at| usize::try_from(at).ok());
            let range = offset(0)?..offset(1)?;
            self.data.get(range.clone()).map(|_| range)
        };
        self.header.iter().filter_map(|(name, tensor)| Some((name.clone(), range(tensor)?))).collect()
    }

    fn mutate_tensors(&mut self, choices: &mut Choices) {
        let tensors = self.tensors();
        if tensors.is_empty() {
            return;
        }
        repeatedly(choices, |choices| {
            let (name, range) = choices.of(&tensors).clone();
            let kind = self.header[&name]["dtype"].as_str().unwrap_or_default().to_owned();
            mutate_tensor(&mut self.data[range], &kind, choices);
        });
    }

    /// The file with updated checksums of the tensors.
    fn sealed(mut self) -> Vec<u8> {
        let sum = |range: Range<usize>| json!(blake3::hash(&self.data[range]).to_hex().to_string());
        let sums: Map<String, Value> = self.tensors().into_iter().map(|(name, range)| (name, sum(range))).collect();
        if let Value::Object(metadata) = &mut self.metadata {
            metadata.insert("checksums".into(), sums.into());
        }
        self.header.insert("__metadata__".into(), json!({"lapidary": self.metadata.to_string()}));
        let mut header = Value::Object(self.header).to_string();
        header.extend(std::iter::repeat_n(' ', header.len().next_multiple_of(8) - header.len()));
        [&(header.len() as u64).to_le_bytes(), header.as_bytes(), &self.data].concat()
    }
}

fn mutate_tensor(bytes: &mut [u8], kind: &str, choices: &mut Choices) {
    let width = match kind {
        "F32" | "U32" => 4,
        "U16" => 2,
        _ => 1,
    };
    let count = bytes.len() / width;
    if count == 0 {
        return;
    }
    let value = |choices: &mut Choices| match kind {
        "F32" => choices.of(&numbers::FLOATS).to_le_bytes().to_vec(),
        _ => {
            let near = [0, 1, count as u32 - 1, count as u32, u32::MAX, 1 << 31, 0xffff, 1 << 15];
            choices.of(&near).to_le_bytes()[..width].to_vec()
        }
    };
    let at = |i: usize| i * width..(i + 1) * width;
    let (here, there) = (choices.below(count), choices.below(count));
    match choices.below(6) {
        0 | 1 => bytes[at(here)].copy_from_slice(&value(choices)),
        2 => bytes.copy_within(at(here), there * width),
        3 => bytes
            .chunks_exact_mut(width)
            .for_each(|element| element.copy_from_slice(&value(&mut Choices::new(&[here as u8])))),
        4 if kind == "F32" => {
            let scale = *choices.of(&[-1.0_f32, 1e-20, 1e-6, 1e3, 1e9, 1e18, 1e30]);
            for element in bytes.chunks_exact_mut(4) {
                let number = f32::from_le_bytes([element[0], element[1], element[2], element[3]]);
                element.copy_from_slice(&(number * scale).to_le_bytes());
            }
        }
        _ => bytes[here * width] ^= 1 << choices.below(8),
    }
}
