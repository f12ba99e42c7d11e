//! Leaf radiance from an environment map, energy-conserving under any rotation.
//!
//! Point samples of a map at the light directions would miss small lamps between them and count others twice. Here all
//! of the map's energy goes to some sample, whatever the rotation:
//!
//! * The map is resampled once to a fixed latitude-longitude grid of cell energies, by overlap.
//! * A rotation shifts the rows of that grid with linear interpolation, which keeps each row's sum.
//! * A fixed sparse matrix distributes each cell's energy over the samples nearest to it; its columns sum to one.
//!
//! Balancing the matrix (Sinkhorn) gives every sample exactly `4π / N` of solid angle, so a constant map gives constant leaves.

pub(super) mod fibonacci;

use crate::{environment::Environment, image::Image, sphere::SPHERE};
use fibonacci::{FibonacciLattice, Longitude, Zone};
use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Sub-samples along each side of a grid cell when cells are assigned to samples.
const SUBSAMPLES: usize = 3;
/// Balancing passes: the solid angles of the samples then agree to 0.2 % (root mean square), 2 % at the poles.
const BALANCING: usize = 24;

/// Turns environment maps into the radiance of `N` Fibonacci samples.
#[derive(Debug)]
pub struct EnvironmentSampler {
    lights: usize,
    /// Columns and rows of the grid; both powers of two.
    grid: [usize; 2],
    /// The cells of sample `i` are `cells[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    /// Grid cell (`row * columns + column`) and the fraction of its energy.
    cells: Vec<(u32, f32)>,
}

/// A map resampled to the grid of an [`EnvironmentSampler`]: energy (radiance times solid angle) of each cell.
#[derive(Clone, Debug)]
pub struct GridEnergy(Vec<Vec3>);

impl GridEnergy {
    /// Energy of the cells, row by row.
    pub fn cells(&self) -> &[Vec3] {
        &self.0
    }
}

/// A rotation as a shift of the grid's rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridShift {
    /// Whole columns, fewer than there are.
    pub columns: u32,
    /// The rest: the weight of the next column.
    pub fraction: f32,
}

impl EnvironmentSampler {
    /// Prepares the matrix for `lights` samples; takes some tenths of a second for 32,768.
    pub fn new(lights: usize) -> Self {
        let columns = ((32.0 * lights as f64).sqrt() as usize).next_power_of_two().max(32);
        let grid = [columns, columns / 2];
        let mut entries = assign_cells(lights, grid);
        balance(&mut entries, lights, grid);
        entries.par_sort_unstable_by_key(|e| (e.sample, e.cell));
        let mut starts = vec![0; lights + 1];
        for e in &entries {
            starts[e.sample as usize + 1] += 1;
        }
        for i in 0..lights {
            starts[i + 1] += starts[i];
        }
        let cells = entries.iter().map(|e| (e.cell, e.fraction as f32)).collect();
        Self { lights, grid, starts, cells }
    }

    /// Number of light samples.
    pub fn lights(&self) -> usize {
        self.lights
    }

    /// Columns of the grid, a power of two.
    pub fn columns(&self) -> usize {
        self.grid[0]
    }

    /// The cells of a sample (`row * columns + column`), each with the fraction of its energy that the sample takes.
    pub fn cells_of(&self, sample: usize) -> &[(u32, f32)] {
        &self.cells[self.starts[sample] as usize..self.starts[sample + 1] as usize]
    }

    /// The shift of the rows for a map turned by `rotation` radians.
    pub fn shift(&self, rotation: f32) -> GridShift {
        let columns = self.columns();
        let shift = f64::from(rotation) / TAU * columns as f64;
        let whole = (shift.floor() as i64).rem_euclid(columns as i64);
        GridShift { columns: whole as u32, fraction: (shift - shift.floor()) as f32 }
    }

    /// Samples in a steradian.
    pub fn samples_per_steradian(&self) -> f32 {
        self.lights as f32 / SPHERE
    }

    /// Resamples a map to the grid, conserving energy.
    pub fn grid_energy(&self, environment: &Environment) -> GridEnergy {
        GridEnergy(resample(&environment.map, self.grid))
    }

    /// Radiance of every sample (in sample order) under a map turned by `rotation` radians.
    pub fn sample_radiance(&self, energy: &GridEnergy, rotation: f32) -> Vec<Vec3> {
        let (columns, GridShift { columns: whole, fraction }) = (self.columns(), self.shift(rotation));
        let (whole, inv_solid_angle) = (whole as usize, self.samples_per_steradian());
        let cell_energy = |cell: u32| {
            let (row, column) = (cell as usize & !(columns - 1), cell as usize & (columns - 1));
            let at = |c: usize| energy.0[row | (c & (columns - 1))];
            at(column + whole) * (1.0 - fraction) + at(column + whole + 1) * fraction
        };
        let radiance = |i: usize| {
            self.cells_of(i).iter().map(|&(cell, part)| cell_energy(cell) * part).sum::<Vec3>() * inv_solid_angle
        };
        (0..self.lights).into_par_iter().with_min_len(256).map(radiance).collect()
    }

    /// Radiance of every leaf, in tree order, under `environment` turned by `rotation` radians and scaled.
    pub fn leaf_radiance(&self, tree: &super::LightTree, energy: &GridEnergy, rotation: f32, scale: f32) -> Vec<Vec3> {
        let samples = self.sample_radiance(energy, rotation);
        tree.order().iter().map(|&s| samples[s as usize] * scale).collect()
    }
}

/// `fraction` of the energy of `cell` goes to `sample`.
#[derive(Clone, Copy)]
struct Entry {
    cell: u32,
    sample: u32,
    fraction: f64,
}

/// Entries in the order of the cells, row by row.
fn assign_cells(lights: usize, [columns, rows]: [usize; 2]) -> Vec<Entry> {
    let lattice = FibonacciLattice::new(lights);
    let middle = |i: usize, n: usize| (i as f64 + 0.5) / (n * SUBSAMPLES) as f64;
    let longitudes: Vec<Longitude> =
        (0..columns * SUBSAMPLES).map(|i| Longitude::new((0.5 - middle(i, columns)) * TAU)).collect();
    (0..rows)
        .into_par_iter()
        .flat_map_iter(|row| {
            let zone = |i| lattice.zone((PI * middle(row * SUBSAMPLES + i, rows)).cos());
            let zones: [Zone; SUBSAMPLES] = std::array::from_fn(zone);
            let entries = longitudes.chunks_exact(SUBSAMPLES).enumerate();
            entries.flat_map(|(column, l)| cell_entries((row * columns + column) as u32, &zones, l)).collect::<Vec<_>>()
        })
        .collect()
}

/// The samples nearest to the sub-samples of a cell.
fn cell_entries(cell: u32, zones: &[Zone; SUBSAMPLES], longitudes: &[Longitude]) -> impl Iterator<Item = Entry> {
    let part = 1.0 / (SUBSAMPLES * SUBSAMPLES) as f64;
    let mut entries = [Entry { cell, sample: u32::MAX, fraction: 0.0 }; SUBSAMPLES * SUBSAMPLES];
    let mut count = 0;
    for sample in zones.iter().flat_map(|zone| longitudes.iter().map(|l| zone.nearest(l))) {
        let at = entries[..count].iter().position(|e| e.sample == sample).unwrap_or(count);
        count = count.max(at + 1);
        entries[at].sample = sample;
        entries[at].fraction += part;
    }
    entries.into_iter().take(count)
}

/// Bands of entries that are balanced in parallel. Their number affects rounding, so it is fixed.
const BANDS: usize = 8;

/// Sinkhorn's balancing: every sample receives the same solid angle, and every cell distributes all of its energy.
fn balance(entries: &mut [Entry], lights: usize, grid: [usize; 2]) {
    let fair = 4.0 * PI / lights as f64;
    let mut scale = vec![1.0; lights];
    // The first pass only measures the solid angles.
    for _ in 0..=BALANCING {
        let bands: Vec<Vec<f64>> =
            cell_bands(entries).into_par_iter().map(|band| balance_band(band, &scale, grid)).collect();
        let received = |i: usize| bands.iter().map(|band| band[i]).sum::<f64>();
        scale = (0..lights).map(|i| fair / received(i)).collect();
    }
}

/// Splits entries into [`BANDS`] slices of whole cells.
fn cell_bands(mut entries: &mut [Entry]) -> Vec<&mut [Entry]> {
    let size = entries.len().div_ceil(BANDS).max(1);
    let mut bands = Vec::with_capacity(BANDS);
    while !entries.is_empty() {
        let least = size.min(entries.len());
        let cell = entries[least - 1].cell;
        let end = least + entries[least..].iter().take_while(|e| e.cell == cell).count();
        let (band, rest) = entries.split_at_mut(end);
        bands.push(band);
        entries = rest;
    }
    bands
}

/// Scales the entries of each sample and normalizes each cell to its whole energy. Returns the solid angle that every
/// sample receives from the band.
fn balance_band(band: &mut [Entry], scale: &[f64], grid: [usize; 2]) -> Vec<f64> {
    let mut received = vec![0.0; scale.len()];
    for cell in band.chunk_by_mut(|a, b| a.cell == b.cell) {
        let solid_angle = cell_solid_angle(cell[0].cell as usize / grid[0], grid);
        cell.iter_mut().for_each(|e| e.fraction *= scale[e.sample as usize]);
        let given: f64 = cell.iter().map(|e| e.fraction).sum();
        for e in cell {
            e.fraction /= given;
            received[e.sample as usize] += e.fraction * solid_angle;
        }
    }
    received
}

fn cell_solid_angle(row: usize, [columns, rows]: [usize; 2]) -> f64 {
    let edge = |r: usize| (PI * r as f64 / rows as f64).cos();
    (edge(row) - edge(row + 1)) * TAU / columns as f64
}

/// Energy of each grid cell: the map's texels weighted by their overlap in longitude and height.
fn resample(map: &Image, [columns, rows]: [usize; 2]) -> Vec<Vec3> {
    let height_edge = |i: usize, n: usize| -(PI * i as f64 / n as f64).cos();
    let row_overlaps = overlaps(map.height(), rows, height_edge);
    let column_overlaps = overlaps(map.width(), columns, |i, n| TAU * i as f64 / n as f64);
    let narrow: Vec<Vec3> = (0..map.height())
        .into_par_iter()
        .flat_map_iter(|y| column_overlaps.iter().map(move |o| o.iter().map(|&(x, w)| map.at(x, y) * w).sum()))
        .collect();
    row_overlaps
        .par_iter()
        .flat_map_iter(|o| {
            let narrow = &narrow;
            (0..columns).map(move |c| o.iter().map(|&(y, w)| narrow[y * columns + c] * w).sum())
        })
        .collect()
}

/// For each of `target` intervals: the overlapping source intervals, with the lengths of the overlaps.
fn overlaps(source: usize, target: usize, edge: impl Fn(usize, usize) -> f64) -> Vec<Vec<(usize, f32)>> {
    let mut first = 0;
    (0..target)
        .map(|t| {
            let (low, high) = (edge(t, target), edge(t + 1, target));
            while first + 1 < source && edge(first + 1, source) <= low {
                first += 1;
            }
            (first..source)
                .take_while(|&s| edge(s, source) < high)
                .map(|s| (s, (high.min(edge(s + 1, source)) - low.max(edge(s, source))).max(0.0) as f32))
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;

    fn environment(size: [u32; 2], f: impl FnMut(u32, u32) -> Vec3) -> Environment {
        Environment::new("test".into(), Image::from_fn(size, f))
    }

    fn energy_of(map: &Image) -> f64 {
        (0..map.height())
            .map(|y| {
                let row: f64 = (0..map.width()).map(|x| f64::from(map.at(x, y).x)).sum();
                row * cell_solid_angle(y, [map.width(), map.height()])
            })
            .sum()
    }

    #[test]
    fn constant_map_gives_constant_leaves() {
        let sampler = EnvironmentSampler::new(4096);
        let energy = sampler.grid_energy(&environment([64, 32], |_, _| Vec3::ONE));
        let leaves = sampler.sample_radiance(&energy, 1.0);
        let errors: Vec<f32> = leaves.iter().map(|l| (l.x - 1.0).abs()).collect();
        let (worst, sum_sq) = errors.iter().fold((0.0, 0.0), |(w, s): (f32, f32), e| (w.max(*e), s + e * e));
        assert!(worst < 0.02 && (sum_sq / 4096.0).sqrt() < 2e-3, "worst {worst}, sum of squares {sum_sq}");
    }

    #[test]
    fn energy_is_kept_over_a_full_turn_in_one_degree_steps() {
        // A single texel brighter than all others together, which plain sampling would lose.
        let env = environment([512, 256], |x, y| Vec3::splat(if (x, y) == (100, 90) { 3e5 } else { 0.5 }));
        let expected = energy_of(&env.map);
        let sampler = EnvironmentSampler::new(4096);
        let energy = sampler.grid_energy(&env);
        let of = |leaves: &[Vec3]| leaves.iter().map(|l| f64::from(l.x)).sum::<f64>() * 4.0 * PI / leaves.len() as f64;
        for degree in 0..360 {
            let found = of(&sampler.sample_radiance(&energy, (degree as f32).to_radians()));
            assert!((found / expected - 1.0).abs() < 1e-4, "at {degree} degrees: {found} for {expected}");
        }
        // Negative control: point samples of the same map drift by far more than 0.1 %.
        let point = |degree: f32| -> Vec<Vec3> {
            let turn = glam::Mat3::from_rotation_y(-degree.to_radians());
            fibonacci_directions(4096).iter().map(|&d| env.radiance(turn * d)).collect()
        };
        let drift =
            |v: &[f64]| v.iter().copied().fold(0.0, f64::max) / v.iter().copied().fold(f64::MAX, f64::min) - 1.0;
        let sampled: Vec<f64> = (0..90).map(|d| of(&point(4.0 * d as f32))).collect();
        assert!(drift(&sampled) > 0.01);
    }

    #[test]
    fn a_rotation_turns_counter_clockwise_seen_from_above() {
        // Bright at +Z (center of the image); a turn of 90 degrees moves it to +X.
        let env = environment([128, 64], |x, y| {
            Vec3::splat(if (62..66).contains(&x) && (30..34).contains(&y) { 1.0 } else { 0.0 })
        });
        let sampler = EnvironmentSampler::new(1024);
        let energy = sampler.grid_energy(&env);
        let centroid = |rotation: f32| {
            let leaves = sampler.sample_radiance(&energy, rotation);
            leaves.iter().zip(fibonacci_directions(1024)).map(|(l, d)| d * l.x).sum::<Vec3>().normalize()
        };
        assert!(centroid(0.0).dot(Vec3::Z) > 0.999);
        assert!(centroid(std::f32::consts::FRAC_PI_2).dot(Vec3::X) > 0.999);
    }

    #[test]
    fn maps_of_any_size_keep_their_energy() {
        let sampler = EnvironmentSampler::new(256);
        for size in [[1, 1], [3, 5], [77, 31], [640, 320]] {
            let env = environment(size, |x, y| Vec3::splat((x * 7 + y * 3) as f32 % 11.0 + 0.1));
            let leaves = sampler.sample_radiance(&sampler.grid_energy(&env), 0.3);
            let found = leaves.iter().map(|l| f64::from(l.x)).sum::<f64>() * 4.0 * PI / 256.0;
            assert!((found / energy_of(&env.map) - 1.0).abs() < 1e-4, "{size:?}");
        }
    }
}
