//! The memory budget of an import. Everything is estimated from headers and counts before allocation: a small file can
//! need a thousand times its own size.

use crate::{image::Footprint, import::report::ImportError};
use lapidary_core::memory;
use std::path::Path;

/// Budget if the system does not report free memory: 8 GiB.
const UNKNOWN: u64 = 8 << 30;

/// Peak bytes of a vertex: as read, while vertices are welded, and in the mesh. With [`TRIANGLE`] this is 0.9 GB for a
/// mesh of a million vertices; a measured one without normals and with a crease at every edge took 0.65 GB.
const VERTEX: u64 = 320;

/// Peak bytes of a triangle: as read, its edges while normals are rebuilt, and in the mesh.
const TRIANGLE: u64 = 320;

/// Peak bytes of a material, a texture or another item of little more than a name, in all places that hold it.
const NAME: u64 = 1200;

/// Peak bytes of an object of a JSON file, such as a node or an accessor, as parsed: once for itself and once for its extensions.
const JSON_OBJECT: u64 = 600;

/// Peak bytes of an entry of a list in a JSON file, such as a number.
const JSON_ENTRY: u64 = 80;

/// An import exceeds its budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct OverBudget {
    needed: u64,
    limit: u64,
}

impl OverBudget {
    /// The excess of `needed` over `limit`, in bytes.
    pub fn new(needed: u64, limit: u64) -> Self {
        Self { needed, limit }
    }

    /// Needed and available memory.
    pub fn megabytes(self) -> [u64; 2] {
        memory::in_megabytes(self.needed, self.limit)
    }

    pub fn at(self, path: &Path) -> ImportError {
        let [needed, available] = self.megabytes();
        ImportError::Memory { path: path.into(), needed, available }
    }
}

/// Bytes that an import may take, and has taken so far.
#[derive(Clone, Debug)]
pub(super) struct Budget {
    limit: u64,
    used: u64,
}

impl Budget {
    /// A budget of `limit` bytes, or of the memory free now.
    pub fn new(limit: Option<u64>) -> Self {
        Self { limit: limit.or_else(memory::available).unwrap_or(UNKNOWN), used: 0 }
    }

    /// Takes bytes before they are allocated.
    pub fn take(&mut self, bytes: u64) -> Result<(), OverBudget> {
        let needed = self.used.saturating_add(bytes);
        if needed > self.limit {
            return Err(OverBudget::new(needed, self.limit));
        }
        self.used = needed;
        Ok(())
    }

    /// Bytes that are left.
    pub fn rest(&self) -> u64 {
        self.limit - self.used
    }

    /// Takes the memory of a mesh of `vertices` and `triangles` until it is clean.
    pub fn take_mesh(&mut self, vertices: u64, triangles: u64) -> Result<(), OverBudget> {
        self.take(vertices.saturating_mul(VERTEX).saturating_add(triangles.saturating_mul(TRIANGLE)))
    }

    /// Takes the memory of items of little more than a name.
    pub fn take_names(&mut self, count: u64) -> Result<(), OverBudget> {
        self.take(count.saturating_mul(NAME))
    }

    /// Takes the memory for parsing a JSON text.
    pub fn take_json(&mut self, json: &[u8]) -> Result<(), OverBudget> {
        self.take(bytes_of_json(json))
    }

    /// Takes the memory by which a JSON text and its parsed document grew.
    pub fn take_growth(&mut self, from: &[u8], to: &[u8]) -> Result<(), OverBudget> {
        self.take(bytes_of_json(to).saturating_sub(bytes_of_json(from)))
    }

    /// Takes the memory of a picture with its levels of detail, from its encoded length. The decoder's own memory is
    /// free again afterwards.
    pub fn take_picture(&mut self, encoded: usize, footprint: Footprint) -> Result<(), OverBudget> {
        let held = footprint.held.saturating_add(footprint.levels).saturating_add(encoded as u64);
        self.take(held.saturating_add(footprint.decoding))?;
        self.used -= footprint.decoding;
        Ok(())
    }
}

/// Peak bytes of a JSON text while it is parsed.
fn bytes_of_json(json: &[u8]) -> u64 {
    let count = |byte: u8| json.iter().filter(|b| **b == byte).count() as u64;
    // The text is held twice: as read for extensions, and in the parsed document.
    2 * json.len() as u64 + JSON_OBJECT * count(b'{') + JSON_ENTRY * count(b',')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_adds_up_and_a_refusal_takes_nothing() {
        let mut budget = Budget::new(Some(1000));
        budget.take(600).unwrap();
        assert_eq!(budget.take(500), Err(OverBudget { needed: 1100, limit: 1000 }));
        budget.take_picture(10, Footprint { held: 90, levels: 30, decoding: 270 }).unwrap();
        assert_eq!(budget.take(271), Err(OverBudget { needed: 1001, limit: 1000 }), "90, and 30 for its levels");
        assert!(budget.take(270).is_ok() && budget.take(u64::MAX).is_err() && budget.take_mesh(u64::MAX, 1).is_err());
        assert!(Budget::new(None).take(1 << 20).is_ok());
    }

    #[test]
    fn a_refusal_tells_both_numbers_and_the_file() {
        let over = OverBudget { needed: 2_000_001, limit: 1_999_999 };
        let message = over.at(Path::new("a.glb")).to_string();
        assert!(message.contains("3 MB") && message.contains("1 MB") && message.ends_with("(a.glb)"), "{message}");
    }
}
