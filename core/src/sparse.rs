//! Sparse matrices of weights.

use crate::transport::Coefficient;
use rayon::prelude::*;
use std::ops::Range;

/// A sparse matrix by rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseRows {
    /// Start of each row in `entries`, and the end of the last.
    offsets: Vec<u32>,
    /// Column and value.
    entries: Vec<(u32, f32)>,
}

impl SparseRows {
    /// Computes `rows` rows in parallel: `fill` appends the entries of a row.
    pub fn build(rows: usize, fill: impl Fn(usize, &mut Vec<(u32, f32)>) + Sync) -> Self {
        const ROWS: usize = 1024;
        let part = |range: Range<usize>| {
            let (mut entries, mut ends) = (Vec::new(), Vec::with_capacity(range.len()));
            for row in range {
                fill(row, &mut entries);
                ends.push(entries.len() as u32);
            }
            (entries, ends)
        };
        let starts: Vec<usize> = (0..rows).step_by(ROWS).collect();
        let parts: Vec<_> = starts.into_par_iter().map(|start| part(start..rows.min(start + ROWS))).collect();
        let mut all = Self { offsets: vec![0], entries: Vec::with_capacity(parts.iter().map(|p| p.0.len()).sum()) };
        for (entries, ends) in parts {
            let base = all.entries.len() as u32;
            all.entries.extend(entries);
            all.offsets.extend(ends.iter().map(|end| base + end));
        }
        all
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Columns and values of a row.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[(u32, f32)] {
        &self.entries[self.offsets[row] as usize..self.offsets[row + 1] as usize]
    }

    /// A row times a vector.
    #[inline(always)]
    pub fn product<T: Coefficient>(&self, row: usize, vector: &[T]) -> T {
        self.row(row).iter().fold(T::ZERO, |sum, &(column, value)| sum + vector[column as usize] * value)
    }

    /// The transposed matrix; it has `columns` rows, each in ascending order.
    pub fn transposed(&self, columns: usize) -> Self {
        let mut offsets = vec![0_u32; columns + 1];
        self.entries.iter().for_each(|&(column, _)| offsets[column as usize + 1] += 1);
        (0..columns).for_each(|c| offsets[c + 1] += offsets[c]);
        let mut next = offsets.clone();
        let mut entries = vec![(0, 0.0); self.entries.len()];
        for row in 0..self.len() {
            for &(column, value) in self.row(row) {
                let place = &mut next[column as usize];
                entries[*place as usize] = (row as u32, value);
                *place += 1;
            }
        }
        Self { offsets, entries }
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> u64 {
        (4 * self.offsets.len() + 8 * self.entries.len()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_and_transpose() {
        let matrix = SparseRows::build(3000, |row, out| {
            out.extend((0..row as u32 % 3).map(|c| (c, (row + c as usize) as f32)));
        });
        assert_eq!(matrix.row(5), [(0, 5.0), (1, 6.0)]);
        assert_eq!(matrix.product(5, &[10.0, 1.0]), 56.0);
        let transposed = matrix.transposed(2);
        assert_eq!(transposed.len(), 2);
        assert_eq!(transposed.row(1)[..2], [(2, 3.0), (5, 6.0)]);
        assert_eq!(transposed.transposed(3000), matrix);
    }
}
