//! The points that the chunks of a checkpoint belong to.
//!
//! Surface sources and points of the meshless basis are placed from a viewpoint. Cameras and lights are hints for it,
//! and may move between an interrupted bake and its resumption. So a fingerprint of the points is stored beside their
//! chunks (`places-sources.txt`, `places-transport.txt`), and chunks of other points are removed.

use super::{Checkpoint, CheckpointError, io_error};
use lapidary_core::surfel::Surfel;
use std::fs;

/// The chunks that belong to the same points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Both series of the surface sources.
    Sources,
    /// Rows of the meshless operator.
    Transport,
}

impl Part {
    fn name(self) -> &'static str {
        match self {
            Self::Sources => "sources",
            Self::Transport => "transport",
        }
    }

    /// Prefix of the names of its chunks.
    fn prefix(self) -> &'static str {
        match self {
            Self::Sources => "source-",
            Self::Transport => "transport-",
        }
    }
}

impl Checkpoint {
    /// Names the points of the chunks of a part. Removes chunks of other points, and returns whether there were any.
    ///
    /// # Errors
    /// A folder that cannot be read or written.
    pub fn bind(&self, part: Part, places: &[Surfel], numbers: &[f32]) -> Result<bool, CheckpointError> {
        let (name, fingerprint) = (format!("places-{}.txt", part.name()), fingerprint(places, numbers));
        if fs::read(self.folder.join(&name)).is_ok_and(|found| found == fingerprint.as_bytes()) {
            return Ok(false);
        }
        let removed = self.remove_all(part.prefix())?;
        self.write(&name, fingerprint.as_bytes())?;
        Ok(removed)
    }

    fn remove_all(&self, prefix: &str) -> Result<bool, CheckpointError> {
        let read = |e| io_error("read", &self.folder, e);
        let mut removed = false;
        for entry in fs::read_dir(&self.folder).map_err(read)? {
            let path = entry.map_err(read)?.path();
            if path.file_name().is_some_and(|n| n.to_string_lossy().starts_with(prefix)) {
                fs::remove_file(&path).map_err(|e| io_error("remove", &path, e))?;
                removed = true;
            }
        }
        Ok(removed)
    }
}

/// BLAKE3 of points and of the numbers that belong to them, hexadecimal.
fn fingerprint(places: &[Surfel], numbers: &[f32]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(places.len() as u64).to_le_bytes());
    for Surfel { position, normal, place } in places {
        hasher.update(bytemuck::bytes_of(position));
        hasher.update(bytemuck::bytes_of(normal));
        hasher.update(&place.triangle.to_le_bytes());
        hasher.update(bytemuck::bytes_of(&place.barycentric));
    }
    hasher.update(bytemuck::cast_slice(numbers));
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::checkpoint::{Chunk, Series};
    use glam::Vec3;
    use lapidary_core::dataset::BakeSettings;

    #[test]
    fn chunks_about_other_places_are_removed_and_the_rest_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        let checkpoint = Checkpoint::create(&output, "hash", &BakeSettings::default(), 1, 1, &[0]).unwrap();
        let all = [Series::Environment, Series::Sources, Series::SourceEnvironment];
        let chunk = Chunk { nodes: vec![7], lengths: vec![1], squared_error: 0.0, rays: 1 };
        let kept = || all.map(|series| checkpoint.load(series, 0, 1).is_some());
        let at = |x| Surfel { position: Vec3::X * x, ..Default::default() };
        assert!(!checkpoint.bind(Part::Sources, &[at(1.0), at(2.0)], &[0.5]).unwrap(), "nothing to remove yet");
        all.iter().for_each(|&series| checkpoint.store(series, 0, &chunk).unwrap());
        assert!(!checkpoint.bind(Part::Sources, &[at(1.0), at(2.0)], &[0.5]).unwrap());
        assert!(!checkpoint.bind(Part::Transport, &[at(9.0)], &[]).unwrap());
        assert_eq!(kept(), [true; 3]);
        for (places, numbers) in [([at(1.0), at(2.5)], [0.5]), ([at(1.0), at(2.5)], [0.25])] {
            assert!(checkpoint.bind(Part::Sources, &places, &numbers).unwrap());
            assert_eq!(kept(), [true, false, false]);
            checkpoint.store(Series::Sources, 0, &chunk).unwrap();
        }
    }
}
