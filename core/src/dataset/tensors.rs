//! Named arrays of a file for writing. `reader.rs` reads them.

use crate::{cut::packed::PackedCuts, surfel::Surfel};
use glam::{Vec2, Vec3};
use safetensors::{
    Dtype, SafeTensorError,
    tensor::{Metadata, TensorInfo},
};
use std::{borrow::Cow, collections::HashMap};

/// Key of the JSON in the safetensors metadata.
pub(crate) const METADATA_KEY: &str = "lapidary";

/// Name of the positions of hidden objects' vertices, object by object.
pub(super) const HIDDEN_POSITIONS: &str = "hidden_positions";

/// A tensor to be written.
pub(super) struct Tensor<'a> {
    pub name: String,
    pub dtype: Dtype,
    pub shape: Vec<usize>,
    pub bytes: Cow<'a, [u8]>,
}

pub(super) fn tensor<'a, T: bytemuck::NoUninit, const D: usize>(
    name: &str,
    dtype: Dtype,
    shape: [usize; D],
    values: &'a [T],
) -> Tensor<'a> {
    Tensor { name: name.into(), dtype, shape: shape.to_vec(), bytes: Cow::Borrowed(bytemuck::cast_slice(values)) }
}

/// A tensor that owns its bytes.
pub(super) fn owned(tensor: Tensor<'_>) -> Tensor<'static> {
    Tensor { bytes: Cow::Owned(tensor.bytes.into_owned()), name: tensor.name, dtype: tensor.dtype, shape: tensor.shape }
}

/// The texels and the offsets of cuts.
pub(super) fn cut_tensors<'a>([texels, offsets]: [&str; 2], cuts: &'a PackedCuts) -> [Tensor<'a>; 2] {
    let nodes = cuts.nodes();
    let shape = [2 * nodes.len() / 16, 4];
    let nodes = match nodes {
        Cow::Borrowed(nodes) => tensor(texels, Dtype::U32, shape, nodes),
        Cow::Owned(nodes) => owned(tensor(texels, Dtype::U32, shape, &nodes)),
    };
    [nodes, tensor(offsets, Dtype::U32, [cuts.offsets().len()], cuts.offsets())]
}

/// Positions, normals, triangles and barycentrics of surface points, by names that begin with `kind`.
pub(super) fn surfel_tensors(kind: &str, points: impl Iterator<Item = Surfel> + Clone) -> [Tensor<'static>; 4] {
    let positions: Vec<Vec3> = points.clone().map(|p| p.position).collect();
    let normals: Vec<Vec3> = points.clone().map(|p| p.normal).collect();
    let triangles: Vec<u32> = points.clone().map(|p| p.place.triangle).collect();
    let barycentrics: Vec<Vec2> = points.map(|p| p.place.barycentric).collect();
    let n = positions.len();
    [
        owned(tensor(&format!("{kind}_positions"), Dtype::F32, [n, 3], &positions)),
        owned(tensor(&format!("{kind}_normals"), Dtype::F32, [n, 3], &normals)),
        owned(tensor(&format!("{kind}_triangles"), Dtype::U32, [n], &triangles)),
        owned(tensor(&format!("{kind}_barycentrics"), Dtype::F32, [n, 2], &barycentrics)),
    ]
}

/// Checksum of a tensor's bytes, in hexadecimal.
pub(super) fn checksum(bytes: &[u8]) -> String {
    blake3::Hasher::new().update_rayon(bytes).finalize().to_hex().to_string()
}

/// Metadata of a file with these tensors, and the tensors in file order: large values first, so that all are aligned.
///
/// # Errors
/// A shape that does not fit its bytes.
pub(super) fn arranged<'t, 'a>(
    tensors: &'t [Tensor<'a>],
    json: String,
) -> Result<(Metadata, Vec<&'t Tensor<'a>>), SafeTensorError> {
    let mut ordered: Vec<&Tensor> = tensors.iter().collect();
    ordered.sort_by(|a, b| b.dtype.cmp(&a.dtype).then(a.name.cmp(&b.name)));
    let mut end = 0;
    let place = |tensor: &&Tensor| {
        let begin = end;
        end += tensor.bytes.len();
        let info = TensorInfo { dtype: tensor.dtype, shape: tensor.shape.clone(), data_offsets: (begin, end) };
        (tensor.name.clone(), info)
    };
    let places = ordered.iter().map(place).collect();
    Ok((Metadata::new(Some(HashMap::from([(METADATA_KEY.to_owned(), json)])), places)?, ordered))
}
