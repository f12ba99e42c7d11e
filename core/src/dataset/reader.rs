//! Tensors of a file. Each is read straight into its final memory and checked, so memory never holds two copies.
//!
//! Files are not memory-mapped: a truncated file or a removed drive must be an error and not end the program.

use super::{
    DatasetError,
    error::Damage,
    tensors::{METADATA_KEY, checksum},
};
use crate::{
    cut::packed::{NODES_PER_TEXEL, PackedCuts},
    input,
    surfel::{MeshPlace, Surfel},
};
use glam::{Vec2, Vec3};
use safetensors::{
    Dtype, SafeTensorError,
    tensor::{Metadata, TensorInfo},
};
use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    path::Path,
};

/// Largest header, as in the safetensors library.
const MOST_HEAD: u64 = 100_000_000;

/// A file of tensors with its header parsed.
pub(super) struct TensorFile {
    file: File,
    metadata: Metadata,
    /// File offset of the tensors.
    start: u64,
}

impl TensorFile {
    /// Opens a file of tensors.
    ///
    /// # Errors
    /// A file that is unreadable, or not a file of tensors.
    pub fn open(path: &Path) -> Result<Self, DatasetError> {
        let failed = |source| DatasetError::Io { action: "read", path: path.into(), source };
        let (mut file, length) = input::open_to_hold(path).map_err(failed)?;
        let foreign = |reason: SafeTensorError| DatasetError::Foreign { path: path.into(), reason: reason.to_string() };
        let head = head_of(&mut file).map_err(failed)?.ok_or_else(|| foreign(SafeTensorError::InvalidHeaderLength))?;
        let metadata = std::str::from_utf8(&head).map_err(SafeTensorError::InvalidHeader);
        let metadata = metadata
            .and_then(|text| serde_json::from_str(text).map_err(SafeTensorError::InvalidHeaderDeserialization))
            .map_err(foreign)?;
        let opened = Self { file, metadata, start: (size_of::<u64>() + head.len()) as u64 };
        if opened.start.checked_add(opened.metadata.data_len() as u64) != Some(length) {
            return Err(foreign(SafeTensorError::MetadataIncompleteBuffer));
        }
        Ok(opened)
    }

    /// Lapidary's JSON, if present.
    pub fn json(&self) -> Option<&str> {
        self.metadata.metadata().as_ref()?.get(METADATA_KEY).map(String::as_str)
    }
}

/// The header of a file: its length in 8 bytes, little endian, then that many bytes. `None` if the file is shorter.
fn head_of(file: &mut File) -> io::Result<Option<Vec<u8>>> {
    let mut length = Vec::new();
    file.take(size_of::<u64>() as u64).read_to_end(&mut length)?;
    let Ok(length) = <[u8; 8]>::try_from(length).map(u64::from_le_bytes) else { return Ok(None) };
    let mut head = Vec::new();
    if length <= MOST_HEAD {
        file.take(length).read_to_end(&mut head)?;
    }
    Ok((head.len() as u64 == length).then_some(head))
}

/// Reads and checks the tensors of a file by name.
pub(super) struct Reader<'a> {
    pub file: &'a TensorFile,
    pub checksums: &'a BTreeMap<String, String>,
}

impl Reader<'_> {
    /// Checks that every tensor has a checksum and every checksum a tensor.
    pub fn check_names(&self) -> Result<(), Damage> {
        let mut names = self.file.metadata.offset_keys();
        names.sort_unstable();
        if let Some(name) = names.into_iter().find(|name| !self.checksums.contains_key(name)) {
            return Err(Damage::NoChecksum(name));
        }
        self.checksums.keys().try_for_each(|name| self.info(name).map(drop))
    }

    /// Whether the tensor exists.
    pub fn has(&self, name: &str) -> bool {
        self.info(name).is_ok()
    }

    /// `count` unchecked cuts, from the tensors of their texels and offsets.
    pub fn cuts(&self, [cuts, offsets]: [&str; 2], count: usize) -> Result<PackedCuts, Damage> {
        let texels: Vec<[u16; NODES_PER_TEXEL]> = self.array(cuts, Dtype::U32, &[4], None)?;
        let offsets = self.array(offsets, Dtype::U32, &[], Some(count))?;
        Ok(PackedCuts::unchecked(texels.into_flattened(), offsets))
    }

    /// The surface points of [`surfel_tensors`](super::tensors::surfel_tensors).
    pub fn surfels(&self, kind: &str) -> Result<Vec<Surfel>, Damage> {
        let positions: Vec<Vec3> = self.array(&format!("{kind}_positions"), Dtype::F32, &[3], None)?;
        let n = Some(positions.len());
        let normals: Vec<Vec3> = self.array(&format!("{kind}_normals"), Dtype::F32, &[3], n)?;
        let of_triangle: Vec<u32> = self.array(&format!("{kind}_triangles"), Dtype::U32, &[], n)?;
        let barycentrics: Vec<Vec2> = self.array(&format!("{kind}_barycentrics"), Dtype::F32, &[2], n)?;
        let place = |i: usize| MeshPlace { triangle: of_triangle[i], barycentric: barycentrics[i] };
        let point = |i: usize| Surfel { position: positions[i], normal: normals[i], place: place(i) };
        Ok((0..positions.len()).map(point).collect())
    }

    pub fn flags(&self, name: &str, count: usize) -> Result<Vec<bool>, Damage> {
        let bytes: Vec<u8> = self.array(name, Dtype::U8, &[], Some(count))?;
        Ok(bytes.into_iter().map(|b| b != 0).collect())
    }

    /// A tensor of floats that may be left out: then it is empty.
    pub fn optional_array<T: bytemuck::Pod>(
        &self,
        name: &str,
        inner: &[usize],
        count: Option<usize>,
    ) -> Result<Vec<T>, Damage> {
        if self.has(name) { self.array(name, Dtype::F32, inner, count) } else { Ok(Vec::new()) }
    }

    /// A tensor of `[count, inner..]` values as a vector of `T`, which has the size of one row.
    pub fn array<T: bytemuck::Pod>(
        &self,
        name: &str,
        dtype: Dtype,
        inner: &[usize],
        count: Option<usize>,
    ) -> Result<Vec<T>, Damage> {
        let info = self.info(name)?;
        let rows = info.shape.split_first().filter(|(n, rest)| *rest == inner && count.is_none_or(|c| c == **n));
        let Some((&rows, _)) = rows.filter(|_| info.dtype == dtype) else {
            let rows = count.map_or("any number".to_owned(), |c| c.to_string());
            return Err(Damage::Shape {
                name: name.into(),
                found: format!("{:?} {:?}", info.dtype, info.shape),
                expected: format!("{dtype:?} of {rows} x {inner:?}"),
            });
        };
        debug_assert_eq!(size_of::<T>(), inner.iter().product::<usize>() * dtype.bitsize() / 8, "{name}");
        let mut values: Vec<T> = bytemuck::zeroed_vec(rows);
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        let unreadable = |source| Damage::Unreadable { name: name.into(), source };
        self.read_at(info.data_offsets.0, bytes).map_err(unreadable)?;
        match self.checksums.get(name) {
            Some(expected) if *expected == checksum(bytes) => Ok(values),
            _ => Err(Damage::Checksum(name.into())),
        }
    }

    fn info(&self, name: &str) -> Result<&TensorInfo, Damage> {
        self.file.metadata.info(name).ok_or_else(|| Damage::Missing(name.into()))
    }

    fn read_at(&self, offset: usize, bytes: &mut [u8]) -> io::Result<()> {
        let mut file = &self.file.file;
        file.seek(SeekFrom::Start(self.file.start + offset as u64))?;
        file.read_exact(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes;
    use std::fs::OpenOptions;

    #[test]
    fn a_file_that_becomes_shorter_while_it_is_read_is_an_error_of_the_file_system() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.cuts");
        test_scenes::dataset(&["m"], &[]).write(&path).unwrap();
        let file = TensorFile::open(&path).unwrap();
        let header: serde_json::Value = serde_json::from_str(file.json().unwrap()).unwrap();
        let checksums: BTreeMap<String, String> = serde_json::from_value(header["checksums"].clone()).unwrap();
        let reader = Reader { file: &file, checksums: &checksums };
        let positions = || reader.array::<[f32; 3]>("positions", Dtype::F32, &[3], None);
        assert_eq!(positions().unwrap().len(), 3, "negative control");
        OpenOptions::new().write(true).open(&path).unwrap().set_len(file.start + 4).unwrap();
        let told = DatasetError::of_contents(&path, positions().unwrap_err());
        assert!(matches!(told, DatasetError::Io { action: "read", .. }), "{told}");
    }
}
