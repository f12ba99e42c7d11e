//! Leaf radiance from an environment map, energy-conserving under any rotation.
//!
//! Samples of a map at the light directions would lose small lamps between them and gain others twice. Here every bit of
//! the map's energy goes to some sample, whatever the rotation: the map is resampled once to a fixed latitude-longitude
//! grid of cell energies by overlap; a rotation shifts the rows of that grid, interpolating linearly, which keeps each
//! row's sum; and a fixed sparse matrix whose columns sum to one hands each cell's energy to the samples nearest to it.
//! Balancing the matrix (Sinkhorn) makes every sample receive exactly its `4π / N` of solid angle, so that a constant
//! map gives constant leaves.

use crate::{environment::Environment, image::Image, sphere::SPHERE};
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Sub-samples along each side of a grid cell when cells are assigned to samples.
const SUBSAMPLES: usize = 3;
/// Balancing passes: the solid angles of the samples then agree to 0.2 % (root mean square), 2 % at the poles.
const BALANCING: usize = 24;

/// Turns environment maps into the radiance of `N` Fibonacci samples.
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

impl EnvironmentSampler {
    /// Prepares for `lights` samples; some tenths of a second for 32,768.
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

    /// Resamples a map to the grid, conserving energy.
    pub fn grid_energy(&self, environment: &Environment) -> GridEnergy {
        GridEnergy(resample(&environment.map, self.grid))
    }

    /// Radiance of every sample (in sample order) under a map turned by `rotation` radians.
    pub fn sample_radiance(&self, energy: &GridEnergy, rotation: f32) -> Vec<Vec3> {
        let columns = self.grid[0];
        let shift = f64::from(rotation) / TAU * columns as f64;
        let (whole, fraction) = (shift.floor(), (shift - shift.floor()) as f32);
        let whole = (whole as i64).rem_euclid(columns as i64) as usize;
        let inv_solid_angle = self.lights as f32 / SPHERE;
        let cell_energy = |cell: u32| {
            let (row, column) = (cell as usize & !(columns - 1), cell as usize & (columns - 1));
            let at = |c: usize| energy.0[row | (c & (columns - 1))];
            at(column + whole) * (1.0 - fraction) + at(column + whole + 1) * fraction
        };
        let radiance = |i: usize| {
            let cells = &self.cells[self.starts[i] as usize..self.starts[i + 1] as usize];
            cells.iter().map(|&(cell, part)| cell_energy(cell) * part).sum::<Vec3>() * inv_solid_angle
        };
        (0..self.lights).map(radiance).collect()
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

fn assign_cells(lights: usize, grid: [usize; 2]) -> Vec<Entry> {
    (0..grid[1])
        .into_par_iter()
        .flat_map_iter(|row| (0..grid[0]).flat_map(move |column| cell_entries(lights, grid, row, column)))
        .collect()
}

fn cell_entries(lights: usize, [columns, rows]: [usize; 2], row: usize, column: usize) -> Vec<Entry> {
    let cell = (row * columns + column) as u32;
    let part = 1.0 / (SUBSAMPLES * SUBSAMPLES) as f64;
    let mut entries: Vec<Entry> = Vec::with_capacity(SUBSAMPLES);
    for i in 0..SUBSAMPLES * SUBSAMPLES {
        let sub =
            |i: usize, cell: usize, cells: usize| (cell as f64 + (i as f64 + 0.5) / SUBSAMPLES as f64) / cells as f64;
        let (u, v) = (sub(i % SUBSAMPLES, column, columns), sub(i / SUBSAMPLES, row, rows));
        let sample = nearest_fibonacci((0.5 - u) * TAU, (PI * v).cos(), lights);
        match entries.iter_mut().find(|e| e.sample == sample) {
            Some(entry) => entry.fraction += part,
            None => entries.push(Entry { cell, sample, fraction: part }),
        }
    }
    entries
}

/// Sinkhorn's balancing: every sample receives the same solid angle, and every cell gives all of its energy.
fn balance(entries: &mut [Entry], lights: usize, grid: [usize; 2]) {
    let solid_angle = |cell: u32| cell_solid_angle(cell as usize / grid[0], grid);
    for _ in 0..BALANCING {
        let mut received = vec![0.0; lights];
        entries.iter().for_each(|e| received[e.sample as usize] += e.fraction * solid_angle(e.cell));
        let fair = 4.0 * PI / lights as f64;
        entries.iter_mut().for_each(|e| e.fraction *= fair / received[e.sample as usize]);
        let mut given = vec![0.0; grid[0] * grid[1]];
        entries.iter().for_each(|e| given[e.cell as usize] += e.fraction);
        entries.iter_mut().for_each(|e| e.fraction /= given[e.cell as usize]);
    }
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

/// For each of `target` intervals: the source intervals that it meets, with the length of the overlap.
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

/// Index of the Fibonacci sample nearest to the direction of longitude `phi` and height `y`, in closed form
/// (Keinert et al. 2015, *Spherical Fibonacci Mapping*).
fn nearest_fibonacci(phi: f64, y: f64, n: usize) -> u32 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let count = n as f64;
    let zone = ((count * PI * 5.0_f64.sqrt() * (1.0 - y * y)).ln() / (2.0 * (1.0 + GOLDEN).ln())).floor().max(2.0);
    let fk = (1.0 + GOLDEN).powf(zone) / 5.0_f64.sqrt();
    let f = DVec2::new(fk.round(), (fk * (1.0 + GOLDEN)).round());
    // Lattice basis near this height: steps of the two Fibonacci numbers, in (longitude, height).
    let turn = |k: f64| TAU * ((k + 1.0) * GOLDEN).fract() - TAU * GOLDEN;
    let (a, b) = (DVec2::new(turn(f.x), -2.0 * f.x / count), DVec2::new(turn(f.y), -2.0 * f.y / count));
    let phi = phi.rem_euclid(TAU);
    let phi = if phi > PI { phi - TAU } else { phi };
    let p = DVec2::new(phi, y - (1.0 - 1.0 / count));
    let determinant = a.perp_dot(b);
    let c = DVec2::new(p.perp_dot(b) / determinant, a.perp_dot(p) / determinant).floor();
    let direction = |phi: f64, y: f64| {
        DVec3::new((1.0 - y * y).max(0.0).sqrt() * phi.sin(), y, (1.0 - y * y).max(0.0).sqrt() * phi.cos())
    };
    let wanted = direction(phi, y);
    let corner = |s: usize| {
        let k = c + DVec2::new((s % 2) as f64, (s / 2) as f64);
        let height = k.x * a.y + k.y * b.y + 1.0 - 1.0 / count;
        let mirrored = height.clamp(-1.0, 1.0) * 2.0 - height;
        let i = (count * 0.5 * (1.0 - mirrored)).floor().clamp(0.0, count - 1.0);
        let q = direction(TAU * (i * GOLDEN).fract(), 1.0 - (2.0 * i + 1.0) / count);
        (q.distance_squared(wanted), i as u32)
    };
    (0..4).map(corner).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, i)| i)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;

    fn environment(size: [u32; 2], f: impl FnMut(u32, u32) -> Vec3) -> Environment {
        Environment { name: "test".into(), map: Image::from_fn(size, f) }
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
    fn nearest_sample_in_closed_form_is_the_nearest_by_brute_force() {
        for n in [64, 1024, 32_768] {
            let samples = fibonacci_directions(n);
            let mut rng = fastrand::Rng::with_seed(3);
            let mut worse = 0;
            for _ in 0..400 {
                let (phi, y) = (rng.f64() * TAU, rng.f64() * 2.0 - 1.0);
                let r = (1.0 - y * y).sqrt();
                let d = Vec3::new((r * phi.sin()) as f32, y as f32, (r * phi.cos()) as f32);
                let best = samples.iter().map(|s| s.distance(d)).fold(f32::INFINITY, f32::min);
                let found = samples[nearest_fibonacci(phi, y, n) as usize].distance(d);
                worse += usize::from(found > best + 1e-5);
            }
            assert!(worse <= 4, "{worse} of 400 are not nearest for {n} samples");
        }
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
        // A lone texel brighter than all the rest together: what plain sampling would lose and find again.
        let env = environment([512, 256], |x, y| Vec3::splat(if (x, y) == (100, 90) { 3e5 } else { 0.5 }));
        let expected = energy_of(&env.map);
        let sampler = EnvironmentSampler::new(4096);
        let energy = sampler.grid_energy(&env);
        let of = |leaves: &[Vec3]| leaves.iter().map(|l| f64::from(l.x)).sum::<f64>() * 4.0 * PI / leaves.len() as f64;
        for degree in 0..360 {
            let found = of(&sampler.sample_radiance(&energy, (degree as f32).to_radians()));
            assert!((found / expected - 1.0).abs() < 1e-4, "at {degree} degrees: {found} for {expected}");
        }
        // Negative control: point samples of the same map drift by far more than the 0.1 % allowed.
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
        // Bright at +Z (centre of the image); turned by 90 degrees it must stand at +X.
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
