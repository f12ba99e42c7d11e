//! Finished rows of the meshless operator in a checkpoint: one file per step.

use super::{CheckpointError, Kept, ShardError};
use crate::meshless::transport::{gather::Row, steps::KeepsRows};
use glam::Vec3;

impl KeepsRows for Kept<'_> {
    fn load_rows(&self, step: usize, rows: usize, senders: usize) -> Option<Vec<Row>> {
        let found = decode(&self.load_body(step)?)?;
        (found.len() == rows && found.iter().all(|row| is_valid(row, senders))).then_some(found)
    }

    fn store_rows(&self, step: usize, rows: &[Row]) -> Result<(), CheckpointError> {
        self.store_body(step, &encode(rows))
    }

    fn has(&self, step: usize) -> bool {
        Kept::has(self, step)
    }

    fn may_make(&self, step: usize) -> Result<(), ShardError> {
        Kept::may_make(self, step)
    }
}

/// Whether the senders are in range and ascending, and the vectors are finite.
fn is_valid(row: &Row, senders: usize) -> bool {
    row.is_sorted_by(|a, b| a.0 < b.0)
        && row.iter().all(|(sender, vector)| (*sender as usize) < senders && vector.is_finite())
}

/// For each row: the number of links (u32), then sender and vector of each link (u32, three f32).
fn encode(rows: &[Row]) -> Vec<u8> {
    let mut words: Vec<u32> = Vec::new();
    for row in rows {
        words.push(row.len() as u32);
        words.extend(row.iter().flat_map(|(sender, v)| [*sender, v.x.to_bits(), v.y.to_bits(), v.z.to_bits()]));
    }
    bytemuck::cast_slice(&words).to_vec()
}

fn decode(bytes: &[u8]) -> Option<Vec<Row>> {
    let words = bytes.chunks_exact(4);
    let mut words = words.remainder().is_empty().then(|| words.map(bytemuck::pod_read_unaligned::<u32>))?;
    let mut rows = Vec::new();
    while let Some(links) = words.next() {
        let mut link = || {
            Some((words.next()?, Vec3::from_array([words.next()?, words.next()?, words.next()?].map(f32::from_bits))))
        };
        rows.push((0..links).map(|_| link()).collect::<Option<Row>>()?);
    }
    Some(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::checkpoint::tests::reopened;
    use crate::bake::checkpoint::{Checkpoint, Places, Series};
    use std::fs;

    #[test]
    fn rows_survive_and_damaged_ones_do_not_count() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        let checkpoint = reopened(&output);
        let kept = checkpoint.series(Series::Transport, Places::of(&[], &[]));
        let rows = vec![vec![(3, Vec3::new(0.1, -2.0, 1e-9)), (7, Vec3::ONE)], Row::new(), vec![(0, Vec3::Z)]];
        kept.store_rows(4, &rows).unwrap();
        assert_eq!(kept.load_rows(4, 3, 8), Some(rows.clone()));
        assert_eq!((kept.load_rows(4, 2, 8), kept.load_rows(5, 3, 8), kept.load_rows(4, 3, 7)), (None, None, None));
        for bad in [vec![(3, Vec3::NAN)], vec![(3, Vec3::ONE), (3, Vec3::ONE)], vec![(4, Vec3::ONE), (3, Vec3::ONE)]] {
            kept.store_rows(5, &[bad]).unwrap();
            assert_eq!(kept.load_rows(5, 1, 8), None, "not finite, doubled, or out of order");
        }
        let file = Checkpoint::folder_of(&output).join(Series::Transport.file_name(4));
        let bytes = fs::read(&file).unwrap();
        for end in 0..bytes.len() {
            fs::write(&file, &bytes[..end]).unwrap();
            assert_eq!(kept.load_rows(4, 3, 8), None, "cut to {end}");
        }
        fs::write(&file, &bytes).unwrap();
        assert_eq!(kept.load_rows(4, 3, 8), Some(rows), "negative control");
    }
}
