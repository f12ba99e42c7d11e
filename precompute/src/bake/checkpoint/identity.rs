//! Identity of a checkpoint's file. The file is never read as another one, wherever it lies.
//!
//! A file holds the BLAKE3 of everything after it, then the hash of its bake, series and number, then the hash of its points, 32
//! bytes each, and then its body.

use lapidary_core::surfel::Surfel;

/// Bytes of a hash.
const HASH: usize = 32;

/// Hash of the points in a file. Surface sources and meshless points are placed from a viewpoint. Cameras and lights are hints for
/// it, and may move between an interrupted bake and its resumption. Bake points may differ if another device has placed vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Places([u8; HASH]);

impl Places {
    /// Hash of points and their associated numbers.
    pub fn of(points: &[Surfel], numbers: &[f32]) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&(points.len() as u64).to_le_bytes());
        for Surfel { position, normal, place } in points {
            hasher.update(bytemuck::bytes_of(position));
            hasher.update(bytemuck::bytes_of(normal));
            hasher.update(&place.triangle.to_le_bytes());
            hasher.update(bytemuck::bytes_of(&place.barycentric));
        }
        hasher.update(bytemuck::cast_slice(numbers));
        Self(hasher.finalize().into())
    }
}

/// Bake and series of a file.
pub struct Identity {
    /// Fingerprint of the bake.
    pub bake: [u8; HASH],
    /// Name of the series.
    pub series: &'static str,
}

/// Result of checking a file.
#[derive(Debug, PartialEq, Eq)]
pub enum Seal<'a> {
    /// The requested file, with this body.
    Fits(&'a [u8]),
    /// The requested file, but for other points.
    OtherPlaces,
    /// It is damaged, or another file.
    Broken,
}

impl Identity {
    /// Seals a body as the file with this number for these points.
    pub fn sealed(&self, body: &[u8], places: Places, index: usize) -> Vec<u8> {
        let rest = [&self.of(index)[..], &places.0, body].concat();
        [blake3::hash(&rest).as_bytes(), &rest[..]].concat()
    }

    /// The body of the file with this number for these points.
    pub fn unsealed<'a>(&self, bytes: &'a [u8], places: Places, index: usize) -> Seal<'a> {
        self.split(bytes, places, index).unwrap_or(Seal::Broken)
    }

    fn split<'a>(&self, bytes: &'a [u8], places: Places, index: usize) -> Option<Seal<'a>> {
        let (checksum, rest) = bytes.split_at_checked(HASH)?;
        let (identity, after) = rest.split_at_checked(HASH)?;
        let (found, body) = after.split_at_checked(HASH)?;
        let is_whole = blake3::hash(rest).as_bytes() == checksum && self.of(index) == identity;
        let seal = if found == places.0 { Seal::Fits(body) } else { Seal::OtherPlaces };
        is_whole.then_some(seal)
    }

    fn of(&self, index: usize) -> [u8; HASH] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.bake).update(&(index as u64).to_le_bytes()).update(self.series.as_bytes());
        hasher.finalize().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_file_is_read_as_what_it_was_written_as_alone() {
        let identity = Identity { bake: [7; 32], series: "chunk-" };
        let at = |x| Surfel { position: Vec3::X * x, ..Default::default() };
        let places = Places::of(&[at(1.0), at(2.0)], &[0.5]);
        let sealed = identity.sealed(b"cuts", places, 3);
        assert_eq!(identity.unsealed(&sealed, places, 3), Seal::Fits(b"cuts"));
        assert_eq!(identity.unsealed(&sealed, places, 4), Seal::Broken, "another number");
        for other in [Identity { bake: [8; 32], ..identity }, Identity { series: "transport-", ..identity }] {
            assert_eq!(other.unsealed(&sealed, places, 3), Seal::Broken, "another bake or series");
        }
        for places in [Places::of(&[at(1.0), at(2.5)], &[0.5]), Places::of(&[at(1.0), at(2.0)], &[0.25])] {
            assert_eq!(identity.unsealed(&sealed, places, 3), Seal::OtherPlaces);
        }
        for byte in 0..sealed.len() {
            let mut damaged = sealed.clone();
            damaged[byte] ^= 1;
            assert_eq!(identity.unsealed(&damaged, places, 3), Seal::Broken, "byte {byte}");
            assert_eq!(identity.unsealed(&sealed[..byte], places, 3), Seal::Broken, "cut to {byte}");
        }
    }
}
