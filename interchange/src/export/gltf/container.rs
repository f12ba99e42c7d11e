//! glTF files around their JSON: members preserved byte for byte, and the chunks of a binary file.

use serde::{
    Deserialize, Deserializer,
    de::{MapAccess, Visitor},
};
use serde_json::{Value, value::RawValue};
use std::fmt;

/// The members of a JSON object in order, as text.
#[derive(Default)]
pub struct Members(Vec<(String, Box<RawValue>)>);

impl Members {
    /// A member's value.
    pub fn value(&self, name: &str) -> Option<Value> {
        let (_, raw) = self.0.iter().find(|(key, _)| key == name)?;
        serde_json::from_str(raw.get()).ok()
    }

    /// The elements of a list member.
    pub fn list(&self, name: &str) -> Vec<Value> {
        match self.value(name) {
            Some(Value::Array(list)) => list,
            _ => Vec::new(),
        }
    }

    /// The elements of a list member, as text.
    pub fn raw_list(&self, name: &str) -> Vec<Box<RawValue>> {
        let raw = self.0.iter().find(|(key, _)| key == name);
        raw.and_then(|(_, raw)| serde_json::from_str(raw.get()).ok()).unwrap_or_default()
    }

    /// Replaces a member, or appends it.
    pub fn set(&mut self, name: &str, value: &impl serde::Serialize) -> serde_json::Result<()> {
        let raw = serde_json::value::to_raw_value(value)?;
        match self.0.iter_mut().find(|(key, _)| key == name) {
            Some((_, old)) => *old = raw,
            None => self.0.push((name.into(), raw)),
        }
        Ok(())
    }

    /// The object as text.
    pub fn text(&self) -> serde_json::Result<String> {
        let member =
            |(key, raw): &(String, Box<RawValue>)| Ok(format!("{}:{}", serde_json::to_string(key)?, raw.get()));
        let members: Vec<String> = self.0.iter().map(member).collect::<serde_json::Result<_>>()?;
        Ok(format!("{{{}}}", members.join(",\n")))
    }
}

impl<'de> Deserialize<'de> for Members {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Members;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Members, A::Error> {
                let mut members = Vec::new();
                while let Some(entry) = entries.next_entry()? {
                    members.push(entry);
                }
                Ok(Members(members))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

/// First bytes of a binary file.
pub const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// A binary file from a JSON text and the chunks after it.
///
/// # Errors
/// A description of the error if the file exceeds the format's 4 GiB.
pub fn binary(json: &str, chunks: &[u8]) -> Result<Vec<u8>, String> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 20 + json.len() + chunks.len();
    if length > u32::MAX as usize {
        return Err(format!(
            "it would have {} MB, more than the 4 GiB of a .glb file; write a .gltf file",
            length >> 20
        ));
    }
    Ok([MAGIC, &word(2), &word(length), &word(json.len()), JSON, &json, chunks].concat())
}

/// The chunk of binary data.
pub fn binary_chunk(mut data: Vec<u8>) -> Vec<u8> {
    data.resize(data.len().next_multiple_of(4), 0);
    [&word(data.len())[..], BIN, &data].concat()
}

fn word(number: usize) -> [u8; 4] {
    (number as u32).to_le_bytes()
}
