//! The binary data of a glTF file: loaded from any place, and checked before the `gltf` crate reads it, which trusts
//! its offsets and counts.

use super::{
    super::files::{Files, Trouble},
    compressed::Compressed,
};
use base64::{
    Engine, alphabet,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};
use glam::{Vec2, Vec3, Vec4};
use gltf::{
    Accessor, Semantic,
    accessor::{DataType, Dimensions, Item, Iter},
    buffer::{Source, View},
};
use std::borrow::Cow;

/// The extension that allows integers for positions, normals, tangents and texture coordinates.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// Bytes by which a buffer may be shorter than declared: some programs count padding that is not there. Views are checked
/// against the bytes that are there.
const MOST_PADDING: usize = 3;

/// Largest count of an accessor without data, which no bytes limit. Its sparse indices have 32 bits and reach no further.
const MOST_WITHOUT_DATA: usize = u32::MAX as usize;

/// Bytes and 16-bit numbers, signed and not.
const INTEGERS: [DataType; 4] = [DataType::I8, DataType::U8, DataType::I16, DataType::U16];

/// The contents of all buffers, each about as long as declared.
pub(super) struct Buffers {
    data: Vec<Vec<u8>>,
    /// Whether the file declares [`QUANTIZATION`].
    is_quantized: bool,
}

impl Buffers {
    pub fn load(gltf: &gltf::Gltf, compressed: &Compressed, files: &mut Files) -> Result<Self, Trouble> {
        let mut loaded = Vec::new();
        for buffer in gltf.buffers() {
            let data = match compressed.decode(&loaded, files)? {
                Some(data) => data,
                None => contents(&buffer, gltf, files)?,
            };
            loaded.push(data);
        }
        let is_quantized = gltf.extensions_used().any(|name| name == QUANTIZATION);
        Ok(Self { data: loaded, is_quantized })
    }

    /// The bytes of a view.
    pub fn view(&self, view: &View) -> Result<&[u8], String> {
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| self.data[view.buffer().index()].get(view.offset()..end))
            .ok_or_else(|| format!("buffer view {} ends past its buffer", view.index()))
    }

    pub fn slice(&self, buffer: &gltf::Buffer) -> Option<&[u8]> {
        self.data.get(buffer.index()).map(Vec::as_slice)
    }

    pub fn positions(&self, primitive: &gltf::Primitive) -> Result<Vec<Vec3>, String> {
        let accessor = primitive.get(&Semantic::Positions).ok_or("a mesh has no positions")?;
        Ok(self.attribute(&accessor, Dimensions::Vec3)?.chunks_exact(3).map(Vec3::from_slice).collect())
    }

    /// Normals; zeros if the primitive has none.
    pub fn normals(&self, primitive: &gltf::Primitive, count: usize) -> Result<Vec<Vec3>, String> {
        let Some(accessor) = primitive.get(&Semantic::Normals) else { return Ok(vec![Vec3::ZERO; count]) };
        one_per_vertex(&accessor, "normals", count)?;
        Ok(self.attribute(&accessor, Dimensions::Vec3)?.chunks_exact(3).map(Vec3::from_slice).collect())
    }

    /// Tangents; zeros if the primitive has none.
    pub fn tangents(&self, primitive: &gltf::Primitive, count: usize) -> Result<Vec<Vec4>, String> {
        let Some(accessor) = primitive.get(&Semantic::Tangents) else { return Ok(vec![Vec4::ZERO; count]) };
        one_per_vertex(&accessor, "tangents", count)?;
        Ok(self.attribute(&accessor, Dimensions::Vec4)?.chunks_exact(4).map(Vec4::from_slice).collect())
    }

    /// A set of texture coordinates, if the primitive has it.
    pub fn uvs(&self, primitive: &gltf::Primitive, set: u32, count: usize) -> Result<Option<Vec<Vec2>>, String> {
        let Some(accessor) = primitive.get(&Semantic::TexCoords(set)) else { return Ok(None) };
        one_per_vertex(&accessor, "texture coordinates", count)?;
        let numbers = match self.is_quantized {
            true => self.attribute(&accessor, Dimensions::Vec2)?,
            false => self.fractions(&accessor, Dimensions::Vec2)?,
        };
        Ok(Some(numbers.chunks_exact(2).map(Vec2::from_slice).collect()))
    }

    /// Linear colors of the vertices and whether any is transparent, if the primitive has colors.
    pub fn colors(&self, primitive: &gltf::Primitive, count: usize) -> Result<Option<(Vec<Vec3>, bool)>, String> {
        let Some(accessor) = primitive.get(&Semantic::Colors(0)) else { return Ok(None) };
        one_per_vertex(&accessor, "colors", count)?;
        let width = accessor.dimensions().multiplicity();
        let dimensions = if width == 4 { Dimensions::Vec4 } else { Dimensions::Vec3 };
        let numbers = self.fractions(&accessor, dimensions)?;
        let is_transparent = numbers.chunks_exact(width).any(|color| color.get(3).is_some_and(|alpha| *alpha < 1.0));
        Ok(Some((numbers.chunks_exact(width).map(Vec3::from_slice).collect(), is_transparent)))
    }

    /// Floats, or unsigned integers as fractions of their largest value, whether or not they are marked as normalized.
    fn fractions(&self, accessor: &Accessor, dimensions: Dimensions) -> Result<Vec<f32>, String> {
        self.check(accessor, &[DataType::F32, DataType::U8, DataType::U16], dimensions)?;
        let numbers = match accessor.data_type() {
            DataType::U8 => self.components(accessor, |x: u8| f32::from(x) / 255.0),
            DataType::U16 => self.components(accessor, |x: u16| f32::from(x) / 65_535.0),
            _ => self.components(accessor, |x: f32| x),
        };
        numbers.ok_or_else(|| no_data(accessor))
    }

    pub fn indices(&self, primitive: &gltf::Primitive) -> Result<Option<Vec<u32>>, String> {
        let Some(accessor) = primitive.indices() else { return Ok(None) };
        self.check(&accessor, &[DataType::U8, DataType::U16, DataType::U32], Dimensions::Scalar)?;
        let reader = primitive.reader(|b| self.slice(&b));
        Ok(Some(reader.read_indices().ok_or("indices are missing")?.into_u32().collect()))
    }

    /// The numbers of an attribute of vertices in sequence: floats, and integers if the file declares [`QUANTIZATION`].
    pub fn attribute(&self, accessor: &Accessor, dimensions: Dimensions) -> Result<Vec<f32>, String> {
        let types: &[DataType] = match (self.is_quantized, accessor.data_type()) {
            (true, DataType::F32) | (false, _) => &[DataType::F32],
            (true, _) => &INTEGERS,
        };
        self.check(accessor, types, dimensions)?;
        self.read(accessor)
    }

    /// The numbers of an accessor in sequence: floats, or integers normalized to -1 to 1 or 0 to 1.
    pub fn numbers(&self, accessor: &Accessor, dimensions: Dimensions) -> Result<Vec<f32>, String> {
        let types: &[DataType] = if accessor.normalized() { &INTEGERS } else { &[DataType::F32] };
        self.check(accessor, types, dimensions)?;
        self.read(accessor)
    }

    /// The numbers of a checked accessor in sequence; normalized integers are from -1 to 1 or 0 to 1.
    fn read(&self, accessor: &Accessor) -> Result<Vec<f32>, String> {
        let numbers = match (accessor.data_type(), accessor.normalized()) {
            (DataType::I8, true) => self.components(accessor, |x: i8| (f32::from(x) / 127.0).max(-1.0)),
            (DataType::U8, true) => self.components(accessor, |x: u8| f32::from(x) / 255.0),
            (DataType::I16, true) => self.components(accessor, |x: i16| (f32::from(x) / 32_767.0).max(-1.0)),
            (DataType::U16, true) => self.components(accessor, |x: u16| f32::from(x) / 65_535.0),
            (DataType::I8, false) => self.components(accessor, |x: i8| f32::from(x)),
            (DataType::U8, false) => self.components(accessor, |x: u8| f32::from(x)),
            (DataType::I16, false) => self.components(accessor, |x: i16| f32::from(x)),
            (DataType::U16, false) => self.components(accessor, |x: u16| f32::from(x)),
            _ => self.components(accessor, |x: f32| x),
        };
        numbers.ok_or_else(|| no_data(accessor))
    }

    fn components<T: Item + Copy>(&self, accessor: &Accessor, number: fn(T) -> f32) -> Option<Vec<f32>> {
        let (of, slice) = (accessor.clone(), |buffer: gltf::Buffer| self.slice(&buffer));
        Some(match accessor.dimensions() {
            Dimensions::Scalar => Iter::<T>::new(of, slice)?.map(number).collect(),
            Dimensions::Vec2 => Iter::<[T; 2]>::new(of, slice)?.flatten().map(number).collect(),
            Dimensions::Vec3 => Iter::<[T; 3]>::new(of, slice)?.flatten().map(number).collect(),
            _ => Iter::<[T; 4]>::new(of, slice)?.flatten().map(number).collect(),
        })
    }

    /// Checks the type of an accessor, and that its range lies within its buffers.
    pub fn check(&self, accessor: &Accessor, types: &[DataType], dimensions: Dimensions) -> Result<(), String> {
        let index = accessor.index();
        if !types.contains(&accessor.data_type()) || accessor.dimensions() != dimensions {
            let (data_type, found) = (accessor.data_type(), accessor.dimensions());
            return Err(format!("accessor {index} is of type {data_type:?} {found:?}, which is not allowed there"));
        }
        if let Some(view) = accessor.view() {
            self.check_range(&view, accessor.offset(), accessor.count(), accessor.size(), index)?;
        } else if accessor.sparse().is_none() {
            return Err(no_data(accessor));
        } else if accessor.count() > MOST_WITHOUT_DATA {
            let count = accessor.count();
            return Err(format!("accessor {index} has {count} elements without data, more than {MOST_WITHOUT_DATA}"));
        }
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let index_size = indices.index_type().size();
            self.check_range(&indices.view(), indices.offset(), sparse.count(), index_size, index)?;
            self.check_range(&values.view(), values.offset(), sparse.count(), accessor.size(), index)?;
        }
        Ok(())
    }

    fn check_range(
        &self,
        view: &View,
        offset: usize,
        count: usize,
        size: usize,
        accessor: usize,
    ) -> Result<(), String> {
        let available = self.view(view)?.len();
        let stride = view.stride().unwrap_or(size);
        let last = count.checked_sub(1).and_then(|last| last.checked_mul(stride));
        let end = last.and_then(|last| last.checked_add(offset)?.checked_add(size));
        match end {
            Some(end) if end <= available && stride >= size => Ok(()),
            _ => Err(format!("accessor {accessor} with {count} elements does not fit its {available} bytes")),
        }
    }
}

fn no_data(accessor: &Accessor) -> String {
    format!("accessor {} has no data", accessor.index())
}

/// The contents of a buffer of a file.
fn contents(buffer: &gltf::Buffer, gltf: &gltf::Gltf, files: &mut Files) -> Result<Vec<u8>, Trouble> {
    let data = match buffer.source() {
        Source::Bin => {
            let missing = || format!("buffer {} has no data: the binary chunk is missing", buffer.index());
            let blob = gltf.blob.as_ref().ok_or_else(missing)?;
            files.budget.take(blob.len() as u64)?;
            blob.clone()
        }
        Source::Uri(uri) => read_uri(uri, files)?,
    };
    if data.len() + MOST_PADDING < buffer.length() {
        let (index, found, expected) = (buffer.index(), data.len(), buffer.length());
        return Err(format!("buffer {index} has {found} of {expected} bytes, it was truncated").into());
    }
    Ok(data)
}

/// Checks the count of an attribute before it is read.
pub(super) fn one_per_vertex(accessor: &Accessor, what: &str, count: usize) -> Result<(), String> {
    let found = accessor.count();
    if found == count { Ok(()) } else { Err(format!("a mesh has {found} {what} for {count} vertices")) }
}

/// The contents of a `data:` URI or of a file.
pub(super) fn read_uri(uri: &str, files: &mut Files) -> Result<Vec<u8>, Trouble> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, encoded) = data.split_once(";base64,").ok_or("an embedded buffer is not in base64")?;
        files.budget.take(encoded.len() as u64)?;
        return base64_decoded(encoded).map_err(|e| format!("embedded data: {e}").into());
    }
    let name = percent_decoded(uri);
    let read = files.find(&name).and_then(|file| files.read(&file));
    read.map_err(|trouble| match trouble {
        Trouble::Reason(reason) => format!("the file \"{name}\" cannot be read: {reason}").into(),
        other => other,
    })
}

/// Decodes base64, also without its `=`, with line breaks, and with stray bits at its end.
fn base64_decoded(text: &str) -> Result<Vec<u8>, base64::DecodeError> {
    let config = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    let engine = GeneralPurpose::new(&alphabet::STANDARD, config);
    let is_broken = text.bytes().any(|byte| byte.is_ascii_whitespace());
    let signs = if is_broken { text.split_ascii_whitespace().collect() } else { Cow::Borrowed(text) };
    engine.decode(signs.as_bytes())
}

/// Replaces codes such as `%20`; invalid codes stay.
pub(crate) fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = || u8::from_str_radix(std::str::from_utf8(after.get(..2)?).ok()?, 16).ok();
        match (first == b'%').then(code).flatten() {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_needs_neither_padding_nor_one_line() {
        for text in ["AQIDBA==", "AQIDBA", "AQID\r\n BA=\n=", "AQIDBB"] {
            assert_eq!(base64_decoded(text).unwrap(), [1, 2, 3, 4], "{text}");
        }
        for text in ["AQIDBA==!", "A", "AQ=DBA=="] {
            assert!(base64_decoded(text).is_err(), "{text}");
        }
    }

    #[test]
    fn percent_codes_are_decoded_and_stray_signs_stay() {
        assert_eq!(percent_decoded("a%20b%C3%A4.png"), "a bä.png");
        assert_eq!(percent_decoded("100%.png%2"), "100%.png%2");
    }
}
