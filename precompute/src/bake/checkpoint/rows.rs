//! Finished rows of the meshless operator in a checkpoint: one file per step.

use super::{Checkpoint, CheckpointError, sealed, unsealed};
use crate::meshless::transport::{gather::Row, steps::KeepsRows};
use glam::Vec3;
use std::fs;

impl KeepsRows for Checkpoint {
    fn load_rows(&self, step: usize, rows: usize) -> Option<Vec<Row>> {
        let bytes = fs::read(self.folder.join(file_name(step))).ok()?;
        decode(&bytes).filter(|found| found.len() == rows)
    }

    fn store_rows(&self, step: usize, rows: &[Row]) -> Result<(), CheckpointError> {
        self.write(&file_name(step), &encode(rows))
    }
}

fn file_name(step: usize) -> String {
    format!("transport-{step:05}.bin")
}

/// BLAKE3 of the rest (32 bytes), then for each row the number of its links (u32) and for each link sender and vector
/// (u32, three f32).
fn encode(rows: &[Row]) -> Vec<u8> {
    let mut words: Vec<u32> = Vec::new();
    for row in rows {
        words.push(row.len() as u32);
        words.extend(row.iter().flat_map(|(sender, v)| [*sender, v.x.to_bits(), v.y.to_bits(), v.z.to_bits()]));
    }
    sealed(bytemuck::cast_slice(&words))
}

fn decode(bytes: &[u8]) -> Option<Vec<Row>> {
    let mut words = unsealed(bytes)?.chunks_exact(4).map(bytemuck::pod_read_unaligned::<u32>);
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
    use lapidary_core::dataset::BakeSettings;

    #[test]
    fn rows_survive_and_damaged_ones_do_not_count() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.cuts");
        let checkpoint = Checkpoint::create(&output, "hash", &BakeSettings::default(), 1, 1, &[0]).unwrap();
        let rows = vec![vec![(3, Vec3::new(0.1, -2.0, 1e-9)), (7, Vec3::ONE)], Row::new(), vec![(0, Vec3::Z)]];
        checkpoint.store_rows(4, &rows).unwrap();
        assert_eq!(checkpoint.load_rows(4, 3), Some(rows));
        assert_eq!((checkpoint.load_rows(4, 2), checkpoint.load_rows(5, 3)), (None, None));
        let file = Checkpoint::folder_of(&output).join(file_name(4));
        let mut bytes = fs::read(&file).unwrap();
        bytes[40] ^= 1;
        fs::write(&file, &bytes).unwrap();
        assert_eq!(checkpoint.load_rows(4, 3), None, "a flipped bit");
        fs::write(&file, &bytes[..bytes.len() - 4]).unwrap();
        assert_eq!(checkpoint.load_rows(4, 3), None, "cut short");
    }
}
