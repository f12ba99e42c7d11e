//! `bake.json`: the bake that a checkpoint belongs to.

use crate::errors::ManifestError;
use lapidary_core::{dataset::BakeSettings, light_tree::is_permutation};
use serde::{Deserialize, Serialize};

/// Content of a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Content {
    /// See [`lapidary_core::dataset::bake_hash`].
    pub scene_hash: String,
    /// See [`lapidary_core::scene::placed::deformed_hash`].
    pub deformed_hash: Option<String>,
}

#[cfg(test)]
impl Content {
    /// Content of a scene without an animation.
    pub fn still(scene_hash: &str) -> Self {
        Self { scene_hash: scene_hash.into(), deformed_hash: None }
    }
}

/// File name.
pub const FILE: &str = "bake.json";

/// Changes whenever the same settings would give different chunks, or the storage of chunks changes.
const VERSION: u32 = 15;

/// The bake that a checkpoint belongs to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    version: u32,
    scene_hash: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    deformed_hash: Option<String>,
    settings: BakeSettings,
    /// Number of bake points.
    pub points: usize,
    /// Number of chunks, at least 1 and at most one per point.
    pub chunks: usize,
    /// Order of the light tree.
    pub tree_order: Vec<u32>,
}

/// The manifest in its file.
#[derive(Serialize, Deserialize)]
struct Sealed {
    /// BLAKE3 of the manifest's JSON, hexadecimal.
    checksum: String,
    manifest: Manifest,
}

impl Manifest {
    /// The manifest of a bake. The number of chunks is clamped to its range.
    pub fn new(content: Content, settings: &BakeSettings, points: usize, chunks: usize, tree_order: &[u32]) -> Self {
        Self {
            version: VERSION,
            scene_hash: content.scene_hash,
            deformed_hash: content.deformed_hash,
            settings: settings.of_content(),
            points,
            chunks: chunks.clamp(1, points.max(1)),
            tree_order: tree_order.to_vec(),
        }
    }

    /// Whether it belongs to a bake of this content with these settings.
    pub fn is_of(&self, content: &Content, settings: &BakeSettings) -> bool {
        self.is_of_scene(&content.scene_hash, settings) && self.deformed_hash == content.deformed_hash
    }

    /// Whether it belongs to a bake of this scene with these settings, regardless of animation.
    pub fn is_of_scene(&self, scene_hash: &str, settings: &BakeSettings) -> bool {
        self.version == VERSION && self.scene_hash == scene_hash && self.settings == settings.of_content()
    }

    /// BLAKE3 of its JSON; equal for equal bakes.
    pub fn fingerprint(&self) -> [u8; 32] {
        blake3::hash(&serde_json::to_vec(self).unwrap_or_default()).into()
    }

    /// Contents of its file.
    pub fn sealed(&self) -> Vec<u8> {
        let sealed = Sealed { checksum: self.checksum(), manifest: self.clone() };
        serde_json::to_vec(&sealed).unwrap_or_default()
    }

    /// Reads and checks a manifest.
    ///
    /// # Errors
    /// A damaged or inconsistent file.
    pub fn unsealed(bytes: &[u8]) -> Result<Self, ManifestError> {
        let Sealed { checksum, manifest } = serde_json::from_slice(bytes)?;
        if manifest.checksum() != checksum {
            return Err(ManifestError::Checksum);
        }
        manifest.check()?;
        Ok(manifest)
    }

    fn checksum(&self) -> String {
        blake3::Hash::from(self.fingerprint()).to_hex().to_string()
    }

    fn check(&self) -> Result<(), ManifestError> {
        let Self { points, chunks, .. } = *self;
        if !(1..=points.max(1)).contains(&chunks) {
            return Err(ManifestError::Chunks { chunks, points });
        }
        let lights = self.settings.lights;
        if self.tree_order.len() != lights || !is_permutation(&self.tree_order) {
            return Err(ManifestError::TreeOrder { lights });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        let settings = BakeSettings { lights: 4, beta: 0.1, ..Default::default() };
        Manifest::new(Content::still("hash"), &settings, 10, 3, &[2, 0, 3, 1])
    }

    #[test]
    fn it_is_read_as_it_was_written_and_no_changed_digit_is_accepted() {
        let whole = manifest().sealed();
        assert_eq!(Manifest::unsealed(&whole).unwrap(), manifest());
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            // Whitespace between tokens does not matter.
            assert!(Manifest::unsealed(&damaged).map_or(true, |read| read == manifest()), "byte {at}");
            assert!(Manifest::unsealed(&whole[..at]).is_err(), "cut to {at}");
        }
    }

    #[test]
    fn contents_that_contradict_each_other_are_refused_whatever_their_checksum_says() {
        let refused = |change: &dyn Fn(&mut Manifest)| {
            let mut changed = manifest();
            change(&mut changed);
            Manifest::unsealed(&changed.sealed()).unwrap_err().to_string()
        };
        for chunks in [0, 11, 1 << 32, 1 << 63, usize::MAX] {
            assert!(refused(&|m| m.chunks = chunks).contains("chunks for 10 points"));
        }
        for order in [vec![2, 0, 3, 3], vec![2, 0, 3, 4], vec![1, 0], vec![]] {
            assert!(refused(&|m| m.tree_order.clone_from(&order)).contains("no permutation of 4"));
        }
        assert!(Manifest::unsealed(&manifest().sealed()).is_ok(), "negative control");
    }
}
