//! Takes dataset files apart and reassembles them with other contents and right checksums, to test their readers.

use crate::dataset::METADATA_KEY;
use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use serde_json::{Number, Value};
use std::collections::HashMap;

/// Numbers at and beyond the limits that programs expect.
const EXTREMES: [f64; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-45,
    1e-30,
    -1e-6,
    0.999_999,
    2.0,
    1e6,
    1e9,
    -1.000_001e9,
    1e19,
    3.4e38,
    f64::INFINITY,
    f64::NAN,
];

/// The contents of a dataset file.
#[derive(Clone, Debug)]
pub struct FileParts {
    /// Lapidary's JSON.
    pub header: Value,
    /// All tensors.
    pub tensors: Vec<FileTensor>,
}

/// A tensor of a file.
#[derive(Clone, Debug)]
pub struct FileTensor {
    /// Its name.
    pub name: String,
    /// Its type.
    pub dtype: Dtype,
    /// Its shape.
    pub shape: Vec<usize>,
    /// Its contents, little endian.
    pub bytes: Vec<u8>,
}

impl FileParts {
    /// Parses a file.
    ///
    /// # Panics
    /// If it is not a dataset.
    pub fn of(file: &[u8]) -> Self {
        let (_, metadata) = SafeTensors::read_metadata(file).expect("a safetensors file");
        let json = metadata.metadata().as_ref().and_then(|m| m.get(METADATA_KEY)).expect("Lapidary's metadata");
        let tensor = |(name, view): (String, TensorView)| FileTensor {
            name,
            dtype: view.dtype(),
            shape: view.shape().to_vec(),
            bytes: view.data().to_vec(),
        };
        let tensors = SafeTensors::deserialize(file).expect("whole tensors").tensors().into_iter().map(tensor);
        let mut tensors: Vec<FileTensor> = tensors.collect();
        tensors.sort_by(|a, b| a.name.cmp(&b.name));
        Self { header: serde_json::from_str(json).expect("JSON"), tensors }
    }

    /// Recomputes the checksums of all tensors.
    pub fn sum(&mut self) {
        let sum = |t: &FileTensor| (t.name.clone(), blake3::hash(&t.bytes).to_hex().as_str().into());
        self.header["checksums"] = Value::Object(self.tensors.iter().map(sum).collect());
    }

    /// The file with the current checksums.
    ///
    /// # Panics
    /// If a tensor's bytes do not match its shape.
    pub fn to_bytes(&self) -> Vec<u8> {
        let metadata = HashMap::from([(METADATA_KEY.to_owned(), self.header.to_string())]);
        let views: Vec<_> = self.tensors.iter().map(|t| (t.name.clone(), t.view())).collect();
        safetensors::serialize(views, Some(metadata)).expect("tensors with names of their own")
    }

    /// Changes one number, or some of one tensor, to an extreme. `random` chooses them; `sum` then fixes the checksums.
    pub fn disturb(&mut self, random: &mut fastrand::Rng) {
        if random.u8(..4) == 0 {
            let mut places = Vec::new();
            collect_numbers(&self.header, String::new(), &mut places);
            if let Some(number) = random.choice(places).and_then(|place| self.header.pointer_mut(&place)) {
                *number = extreme_json(random);
            }
            return;
        }
        let whole: Vec<usize> = (0..self.tensors.len()).filter(|&i| !self.tensors[i].bytes.is_empty()).collect();
        if let Some(tensor) = random.choice(whole) {
            self.tensors[tensor].disturb(random);
        }
    }
}

impl FileTensor {
    fn view(&self) -> TensorView<'_> {
        TensorView::new(self.dtype, self.shape.clone(), &self.bytes).expect("as many bytes as its shape says")
    }

    fn disturb(&mut self, random: &mut fastrand::Rng) {
        let size = self.dtype.bitsize() / 8;
        let count = self.bytes.len() / size;
        let (first, step) = (random.usize(..count), random.usize(1..=count));
        let value = extreme(self.dtype, random);
        // One number, or a regular subset.
        let last = if random.bool() { first + 1 } else { count };
        for i in (first..last).step_by(step) {
            self.bytes[i * size..(i + 1) * size].copy_from_slice(&value[..size]);
        }
    }
}

/// An extreme of a type, little endian.
fn extreme(dtype: Dtype, random: &mut fastrand::Rng) -> [u8; 8] {
    let mut bytes = [0; 8];
    match dtype {
        Dtype::F32 => {
            let value = EXTREMES[random.usize(..EXTREMES.len())] as f32;
            bytes[..4].copy_from_slice(&value.to_le_bytes());
        }
        _ => {
            let all = [0, 1, 2, 0x7fff, 0x8000, 0xffff, 0x7fff_ffff, 0x8000_0000, u64::MAX, random.u64(..)];
            bytes.copy_from_slice(&all[random.usize(..all.len())].to_le_bytes());
        }
    }
    bytes
}

fn extreme_json(random: &mut fastrand::Rng) -> Value {
    match random.u8(..4) {
        0 => [Value::Null, u64::MAX.into(), (-1).into(), 0.into()][random.usize(..4)].clone(),
        // Infinite in 32 bits.
        1 => 1e300.into(),
        _ => Number::from_f64(EXTREMES[random.usize(..EXTREMES.len())]).map_or(Value::Null, Value::Number),
    }
}

/// JSON pointers to all numbers, except the format version.
fn collect_numbers(value: &Value, place: String, places: &mut Vec<String>) {
    match value {
        Value::Number(_) if place != "/format_version" => places.push(place),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, item)| collect_numbers(item, format!("{place}/{i}"), places));
        }
        Value::Object(fields) => {
            for (key, field) in fields {
                collect_numbers(field, format!("{place}/{}", key.replace('~', "~0").replace('/', "~1")), places);
            }
        }
        _ => {}
    }
}
