//! MERL's `.binary` files, and their packed form in datasets.

use super::{ENTRIES, MEASURED_SIZE, Measured, MeasuredError, halved};
use half::f16;
use std::collections::VecDeque;

/// Bytes of the three sizes at the start of a file.
const HEAD_BYTES: usize = 12;
/// Size of a file, in bytes.
pub const FILE_BYTES: usize = HEAD_BYTES + 3 * 8 * ENTRIES;
/// Size of the packed form, in bytes.
const PACKED_BYTES: usize = 3 * 2 * ENTRIES;
/// Reflectance of a unit of red, green and blue.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Largest entry. A mirror as sharp as the table allows has 1e6.
const MOST: f64 = 1e9;

impl Measured {
    /// Reads the contents of a `.binary` file: three sizes of 32 bits, and the planes of red, green and blue, in 64-bit
    /// floats. Negative entries were not measured and are filled in from their neighbors.
    ///
    /// # Errors
    /// Another size, or values that are not reflectances.
    pub fn from_merl(bytes: &[u8]) -> Result<Self, MeasuredError> {
        let (head, planes) = bytes.split_at_checked(HEAD_BYTES).ok_or(MeasuredError::Short(bytes.len() as u64))?;
        let found: [i32; 3] = std::array::from_fn(|i| i32::from_le_bytes(four(&head[4 * i..])));
        if found != MEASURED_SIZE.map(|n| n as i32) {
            return Err(MeasuredError::Size { found });
        }
        check_length(bytes.len(), FILE_BYTES)?;
        let plane = |channel: usize, index: usize| {
            let at = 8 * (channel * ENTRIES + index);
            let mut number = [0; 8];
            number.copy_from_slice(&planes[at..at + 8]);
            f64::from_le_bytes(number) * SCALES[channel]
        };
        let mut entries = Vec::with_capacity(ENTRIES);
        for index in 0..ENTRIES {
            let entry: [f64; 3] = std::array::from_fn(|channel| plane(channel, index));
            if let Some(&value) = entry.iter().find(|x| !(**x <= MOST && x.is_finite())) {
                return Err(MeasuredError::Value { index, value });
            }
            let is_measured = entry.iter().all(|&x| x >= 0.0);
            entries.push(if is_measured { halved(entry.map(|x| x as f32)) } else { [-1.0; 3] });
        }
        let filled = fill(&mut entries)?;
        Ok(Self::new(entries, filled))
    }

    /// All entries as 16-bit floats.
    pub fn packed(&self) -> Vec<u8> {
        let numbers = self.levels[0].entries.iter().flatten();
        numbers.flat_map(|&x| f16::from_f32(x).to_le_bytes()).collect()
    }

    /// Reads the bytes of [`Self::packed`].
    ///
    /// # Errors
    /// Another length, or values that are not reflectances.
    pub fn from_packed(bytes: &[u8]) -> Result<Self, MeasuredError> {
        check_length(bytes.len(), PACKED_BYTES)?;
        let number = |pair: &[u8]| f16::from_le_bytes([pair[0], pair[1]]).to_f32();
        let numbers: Vec<f32> = bytes.chunks_exact(2).map(number).collect();
        if let Some(at) = numbers.iter().position(|x| !(*x >= 0.0 && x.is_finite())) {
            return Err(MeasuredError::Value { index: at / 3, value: numbers[at].into() });
        }
        let (entries, _) = numbers.as_chunks::<3>();
        Ok(Self::new(entries.iter().map(|&entry| halved(entry)).collect(), 0))
    }

    /// The table of an isotropic BRDF.
    #[cfg(any(test, feature = "test-scenes"))]
    pub fn tabulated(value: impl Fn(glam::Vec3, glam::Vec3) -> glam::Vec3 + Sync) -> Self {
        use rayon::prelude::*;
        let entry = |index| {
            let [wi, wo] = directions(index);
            if wi.z > 0.0 && wo.z > 0.0 { halved(value(wi, wo).to_array()) } else { [-1.0; 3] }
        };
        let mut entries: Vec<[f32; 3]> = (0..ENTRIES).into_par_iter().map(entry).collect();
        let filled = fill(&mut entries).expect("a BRDF has values");
        Self::new(entries, filled)
    }

    /// Contents of a `.binary` file.
    #[cfg(any(test, feature = "test-scenes"))]
    pub fn to_merl(&self) -> Vec<u8> {
        let sizes = MEASURED_SIZE.iter().flat_map(|&n| (n as i32).to_le_bytes());
        let entries = &self.levels[0].entries;
        let plane = |c: usize| entries.iter().flat_map(move |e| (f64::from(e[c]) / SCALES[c]).to_le_bytes());
        sizes.chain((0..3).flat_map(plane)).collect()
    }
}

fn four(bytes: &[u8]) -> [u8; 4] {
    [bytes[0], bytes[1], bytes[2], bytes[3]]
}

fn check_length(found: usize, expected: usize) -> Result<(), MeasuredError> {
    if found == expected {
        Ok(())
    } else {
        Err(MeasuredError::Length { found: found as u64, expected: expected as u64 })
    }
}

/// Fills negative entries with the nearest values, one step along an axis at a time. Returns their number.
fn fill(entries: &mut [[f32; 3]]) -> Result<usize, MeasuredError> {
    let is_measured = |entry: &[f32; 3]| entry[0] >= 0.0;
    let mut reached: VecDeque<usize> = (0..entries.len()).filter(|&i| is_measured(&entries[i])).collect();
    if reached.is_empty() {
        return Err(MeasuredError::Empty);
    }
    let missing = entries.len() - reached.len();
    while let Some(index) = reached.pop_front() {
        for near in neighbours(index).into_iter().flatten() {
            if !is_measured(&entries[near]) {
                entries[near] = entries[index];
                reached.push_back(near);
            }
        }
    }
    Ok(missing)
}

/// Neighbors of an entry; azimuths repeat.
fn neighbours(index: usize) -> [Option<usize>; 6] {
    let [n_h, n_d, n_p] = MEASURED_SIZE;
    let (h, d, p) = (index / (n_d * n_p), index / n_p % n_d, index % n_p);
    let at = |h: usize, d: usize, p: usize| (h * n_d + d) * n_p + p;
    [
        (h > 0).then(|| at(h - 1, d, p)),
        (h + 1 < n_h).then(|| at(h + 1, d, p)),
        (d > 0).then(|| at(h, d - 1, p)),
        (d + 1 < n_d).then(|| at(h, d + 1, p)),
        Some(at(h, d, (p + 1) % n_p)),
        Some(at(h, d, (p + n_p - 1) % n_p)),
    ]
}

/// Directions to light and eye at the center of an entry.
#[cfg(any(test, feature = "test-scenes"))]
pub(super) fn directions(index: usize) -> [glam::Vec3; 2] {
    use glam::{Quat, Vec3};
    use std::f32::consts::{FRAC_PI_2, PI};
    let [n_h, n_d, n_p] = MEASURED_SIZE;
    let middle = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
    let theta_h = FRAC_PI_2 * middle(index / (n_d * n_p), n_h).powi(2);
    let theta_d = FRAC_PI_2 * middle(index / n_p % n_d, n_d);
    let phi_d = PI * middle(index % n_p, n_p);
    let difference = Vec3::new(theta_d.sin() * phi_d.cos(), theta_d.sin() * phi_d.sin(), theta_d.cos());
    let to_local = Quat::from_rotation_y(theta_h);
    let h = to_local * Vec3::Z;
    let wi = to_local * difference;
    [wi, 2.0 * wi.dot(h) * h - wi]
}
