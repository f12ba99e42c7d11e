//! The cuts of a range of points, and their bytes.

use lapidary_core::cut::packed::cut_len;

/// The cuts of a range of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chunk {
    /// Nodes of all cuts, one after the other.
    pub nodes: Vec<u16>,
    /// Number of nodes of each cut.
    pub lengths: Vec<u32>,
    /// Squared error of each cut. Errors are summed in point order, regardless of the division into chunks.
    pub squared_errors: Vec<f64>,
    /// Rays traced.
    pub rays: u64,
}

impl Chunk {
    /// Adds the cut of one more point, with its squared error and traced rays.
    pub fn push(&mut self, cut: &[u16], squared_error: f64, rays: u64) {
        self.lengths.push(cut.len() as u32);
        self.nodes.extend_from_slice(cut);
        self.squared_errors.push(squared_error);
        self.rays += rays;
    }

    /// Rays (u64), number of cuts (u64), squared errors (f64), lengths (u32), nodes (u16).
    pub(super) fn encoded(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(16 + 12 * self.lengths.len() + 2 * self.nodes.len());
        bytes.extend(self.rays.to_le_bytes());
        bytes.extend((self.lengths.len() as u64).to_le_bytes());
        bytes.extend_from_slice(bytemuck::cast_slice(&self.squared_errors));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.lengths));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.nodes));
        bytes
    }

    /// The chunk of `count` cuts over a tree of `height`, if the bytes are valid.
    pub(super) fn decoded(bytes: &[u8], count: usize, height: u32) -> Option<Self> {
        let (rays, rest) = bytes.split_first_chunk()?;
        let (cuts, rest) = rest.split_first_chunk()?;
        if u64::from_le_bytes(*cuts) != count as u64 {
            return None;
        }
        let (squared_errors, rest) = rest.split_at_checked(count.checked_mul(8)?)?;
        let (lengths, nodes) = rest.split_at_checked(count.checked_mul(4)?)?;
        let chunk = Self {
            nodes: values(nodes)?,
            lengths: values(lengths)?,
            squared_errors: values(squared_errors)?,
            rays: u64::from_le_bytes(*rays),
        };
        chunk.is_valid(height).then_some(chunk)
    }

    /// Whether each cut partitions the leaves, no nodes are left over, and errors are finite.
    fn is_valid(&self, height: u32) -> bool {
        let mut rest = &self.nodes[..];
        let are_cuts = self.lengths.iter().all(|&length| {
            let Some((cut, after)) = rest.split_at_checked(length as usize) else { return false };
            rest = after;
            cut_len(height, cut) == Ok(cut.len())
        });
        are_cuts && rest.is_empty() && self.squared_errors.iter().all(|e| e.is_finite() && *e >= 0.0)
    }
}

/// Bytes as values, if their number fits.
fn values<T: bytemuck::AnyBitPattern>(bytes: &[u8]) -> Option<Vec<T>> {
    let chunks = bytes.chunks_exact(size_of::<T>());
    chunks.remainder().is_empty().then(|| chunks.map(bytemuck::pod_read_unaligned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cuts of a tree of height 2: its root, and its four leaves.
    fn chunk() -> Chunk {
        let mut chunk = Chunk::default();
        chunk.push(&[5], 0.25, 9);
        chunk.push(&[0x2000, 0x2fff, 0x2001, 0x2002], 0.5, 90);
        chunk
    }

    #[test]
    fn cuts_survive_and_no_cuts_do_not() {
        let read = |chunk: &Chunk, count, height| Chunk::decoded(&chunk.encoded(), count, height);
        assert_eq!(read(&chunk(), 2, 2), Some(chunk()));
        assert_eq!((read(&chunk(), 1, 2), read(&chunk(), 3, 2), read(&chunk(), 2, 1)), (None, None, None));
        let changes: [fn(&mut Chunk); 7] = [
            |c| c.nodes[1] = 0x1000,
            |c| c.nodes[0] = 0x3000,
            |c| c.nodes.truncate(4),
            |c| c.nodes.push(0),
            |c| c.lengths = vec![4, 1],
            |c| c.lengths[1] = u32::MAX,
            |c| c.squared_errors[0] = f64::NAN,
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut changed = chunk();
            change(&mut changed);
            assert_eq!(read(&changed, 2, 2), None, "change {i}");
        }
        let bytes = chunk().encoded();
        (0..bytes.len()).for_each(|end| assert_eq!(Chunk::decoded(&bytes[..end], 2, 2), None, "cut to {end}"));
        let mut endless = bytes;
        endless[8..16].copy_from_slice(&u64::MAX.to_le_bytes());
        assert_eq!(Chunk::decoded(&endless, usize::MAX, 2), None);
    }
}
