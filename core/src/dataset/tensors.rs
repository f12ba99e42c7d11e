//! Named arrays of a file: how values become tensors, and tensors values again.

use super::error::Damage;
use crate::cut::packed::PackedCuts;
use safetensors::{Dtype, SafeTensors};
use std::{borrow::Cow, path::Path};

/// A tensor about to be written.
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

/// A tensor with bytes of its own.
pub(super) fn owned(tensor: Tensor<'_>) -> Tensor<'static> {
    Tensor { bytes: Cow::Owned(tensor.bytes.into_owned()), name: tensor.name, dtype: tensor.dtype, shape: tensor.shape }
}

/// The texels and the offsets of cuts.
pub(super) fn cut_tensors<'a>([texels, offsets]: [&str; 2], cuts: &'a PackedCuts) -> [Tensor<'a>; 2] {
    let nodes: &[u8] = bytemuck::cast_slice(cuts.nodes());
    [
        tensor(texels, Dtype::U32, [nodes.len() / 16, 4], nodes),
        tensor(offsets, Dtype::U32, [cuts.offsets().len()], cuts.offsets()),
    ]
}

/// The tensors of a file, read by name and checked.
pub(super) struct Reader<'a> {
    pub tensors: SafeTensors<'a>,
    pub path: &'a Path,
}

impl Reader<'_> {
    /// Whether a tensor of that name is there.
    pub(super) fn has(&self, name: &str) -> bool {
        self.tensors.tensor(name).is_ok()
    }

    /// `count` cuts, not yet checked, from the tensors of their texels and of their offsets.
    pub(super) fn cuts(&self, [cuts, offsets]: [&str; 2], count: usize) -> Result<PackedCuts, Damage> {
        let texels: Vec<[u32; 4]> = self.array(cuts, Dtype::U32, &[4], None)?;
        let offsets = self.array(offsets, Dtype::U32, &[], Some(count))?;
        Ok(PackedCuts::unchecked(bytemuck::cast_slice(&texels).to_vec(), offsets))
    }

    pub(super) fn flags(&self, name: &str, count: usize) -> Result<Vec<bool>, Damage> {
        let bytes: Vec<u8> = self.array(name, Dtype::U8, &[], Some(count))?;
        Ok(bytes.into_iter().map(|b| b != 0).collect())
    }

    /// A tensor of `[count, inner..]` values as a vector of `T`, which has the size of one row.
    pub(super) fn array<T: bytemuck::AnyBitPattern>(
        &self,
        name: &str,
        dtype: Dtype,
        inner: &[usize],
        count: Option<usize>,
    ) -> Result<Vec<T>, Damage> {
        let tensor = self.tensors.tensor(name).map_err(|_| Damage::Missing(name.into()))?;
        let shape = tensor.shape();
        let fits = tensor.dtype() == dtype
            && shape.split_first().is_some_and(|(&n, rest)| rest == inner && count.is_none_or(|c| c == n));
        if !fits {
            let rows = count.map_or("any number".to_owned(), |c| c.to_string());
            return Err(Damage::Shape {
                name: name.into(),
                found: format!("{:?} {shape:?}", tensor.dtype()),
                expected: format!("{dtype:?} of {rows} x {inner:?}"),
            });
        }
        debug_assert_eq!(
            size_of::<T>(),
            inner.iter().product::<usize>() * dtype.bitsize() / 8,
            "{name} of {}",
            self.path.display()
        );
        // Copied one by one: the file's bytes need not be aligned.
        Ok(tensor.data().chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }
}
