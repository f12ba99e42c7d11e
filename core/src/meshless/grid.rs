//! Range queries: a hash grid finds the functions of a level that reach a point (meshless paper, 2.1).
//!
//! The paper has an R-tree for each level, and draws each function over the pixels that it may reach (4.1). Here the
//! loop is reversed: a point looks up its cell of each level, which lists all functions whose support overlaps it. The
//! lists are plain arrays, so shaders read them as well. Twin of `shaders/meshless_pass.wgsl`.

use crate::{
    simd::{InstructionSet, Kernel, Lanes, Vec3x8},
    surfel::{
        Surfel,
        distance::{LAYERS, LEAST_WEIGHT, SQUASH},
    },
};
use bytemuck::{Pod, Zeroable};
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use std::{array::from_fn, ops::Range};

/// Cells along the radius of a level's functions. Finer cells list fewer functions that miss a point, but take more
/// memory: with 2, a point tests 1.7 functions for each that reaches it, with 1 it tests 2.6.
const CELLS_PER_RADIUS: f32 = 1.0;
/// Factor of the squared height above a point's plane that is added to its squared distance.
const STRETCH: f32 = (1.0 + SQUASH) * (1.0 + SQUASH) - 1.0;

/// A cell of a level, as shaders read it: 32 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Cell {
    /// Its coordinates in cells of its level.
    pub place: [i32; 3],
    /// Its key: its level, or that of a level of an object.
    pub level: u32,
    /// Its first entry.
    pub first: u32,
    /// Number of its entries; 0 in a slot without a cell.
    pub count: u32,
    /// Pads the size to a multiple of 16 bytes.
    pub padding: [u32; 2],
}

/// Positions and normals of functions. Unused lanes are infinitely far away.
type Eight = [Vec3x8; 2];

/// Cells of all levels in one table.
#[derive(Clone, Default)]
pub struct FunctionGrid {
    /// Slots; their number is a power of two. A cell is in the first free slot from its hash on.
    slots: Vec<Cell>,
    /// Functions, cell by cell, ascending.
    entries: Vec<u32>,
    /// The points of the entries, eight at a time, of 192 bytes; each cell starts a new eight.
    eights: Vec<Eight>,
    /// The first eight of the cell in each slot.
    first_eight: Vec<u32>,
    /// Cells per meter of each level.
    cells_per_metre: Vec<f32>,
}

impl FunctionGrid {
    /// A grid over the functions at `points`, in `levels` with `radii`.
    pub(super) fn new(points: &[Surfel], levels: &[Range<usize>], radii: &[f32]) -> Self {
        let cells_per_metre: Vec<f32> = radii.iter().map(|radius| CELLS_PER_RADIUS / radius).collect();
        let of_level = |level: usize| entries_of(points, levels[level].clone(), radii[level], cells_per_metre[level]);
        let by_level: Vec<Vec<(IVec3, u32)>> = (0..levels.len()).into_par_iter().map(of_level).collect();
        let same_cell = |a: &(IVec3, u32), b: &(IVec3, u32)| a.0 == b.0;
        let cells: usize = by_level.iter().map(|entries| entries.chunk_by(same_cell).count()).sum();
        let slots = vec![Cell::default(); (2 * cells).next_power_of_two()];
        let first_eight = vec![0; slots.len()];
        let mut grid = Self { slots, entries: Vec::new(), eights: Vec::new(), first_eight, cells_per_metre };
        for (level, entries) in by_level.iter().enumerate() {
            entries.chunk_by(same_cell).for_each(|cell| grid.push(points, cell[0].0, level as u32, cell));
        }
        grid
    }

    fn push(&mut self, points: &[Surfel], place: IVec3, level: u32, functions: &[(IVec3, u32)]) {
        let (first, count) = (self.entries.len() as u32, functions.len() as u32);
        let slot = self.slot(place, level);
        self.slots[slot] = Cell { place: place.to_array(), level, first, count, padding: [0; 2] };
        self.entries.extend(functions.iter().map(|(_, function)| function));
        self.first_eight[slot] = self.eights.len() as u32;
        for eight in functions.chunks(8) {
            let point = |lane: usize| eight.get(lane).map(|&(_, function)| &points[function as usize]);
            let position = |lane| point(lane).map_or(Vec3::INFINITY, |point| point.position);
            let normal = |lane| point(lane).map_or(Vec3::ZERO, |point| point.normal);
            self.eights.push([Vec3x8::from_array(from_fn(position)), Vec3x8::from_array(from_fn(normal))]);
        }
    }

    /// The slot of a cell, or the free slot for it. Half of the slots are free, so there is always one.
    #[inline(always)]
    fn slot(&self, place: IVec3, level: u32) -> usize {
        let last = self.slots.len() - 1;
        let mut slot = hash(place, level) as usize & last;
        while self.slots[slot].count != 0 && (self.slots[slot].place, self.slots[slot].level) != (place.into(), level) {
            slot = (slot + 1) & last;
        }
        slot
    }

    /// The slot of a level's cell at a position.
    #[inline(always)]
    pub fn slot_at(&self, level: usize, position: Vec3) -> usize {
        self.slot(place(position, self.cells_per_metre[level]), level as u32)
    }

    /// The functions of the cell in a slot: the functions of its level that may reach positions in it. All others have
    /// no weight there.
    #[inline(always)]
    pub fn functions_in(&self, slot: usize) -> &[u32] {
        let cell = &self.slots[slot];
        &self.entries[cell.first as usize..(cell.first + cell.count) as usize]
    }

    /// Calls `visit` for the functions of the cell in a slot that reach a point of a unit normal, with their weights there.
    #[inline]
    pub(super) fn for_each_weight(&self, slot: usize, radius: f32, point: (Vec3, Vec3), visit: impl FnMut(u32, f32)) {
        InstructionSet::widest().run(Weights { grid: self, slot, radius, point, visit });
    }

    /// The table of cells.
    pub fn slots(&self) -> &[Cell] {
        &self.slots
    }

    /// Functions, cell by cell.
    pub fn entries(&self) -> &[u32] {
        &self.entries
    }

    /// Cells per meter of each level.
    pub fn cells_per_metre(&self) -> &[f32] {
        &self.cells_per_metre
    }
}

/// The cells that each function overlaps, by cell and then by function.
fn entries_of(points: &[Surfel], functions: Range<usize>, radius: f32, cells_per_metre: f32) -> Vec<(IVec3, u32)> {
    let of_function = |i: usize| {
        let half = half_extents(points[i].normal, radius);
        let [low, high] = [-half, half].map(|side| place(points[i].position + side, cells_per_metre));
        let [xs, ys, zs]: [_; 3] = from_fn(|axis| low[axis]..=high[axis]);
        let rows = move |x: i32| {
            let zs = zs.clone();
            ys.clone().flat_map(move |y| zs.clone().map(move |z| (IVec3::new(x, y, z), i as u32)))
        };
        xs.flat_map(rows).collect::<Vec<_>>()
    };
    let mut entries: Vec<(IVec3, u32)> = functions.into_par_iter().flat_map_iter(of_function).collect();
    entries.par_sort_unstable_by_key(|&(place, function)| (place.to_array(), function));
    entries
}

/// Half the extents of the ellipsoid that a function reaches, enlarged by more than rounding.
fn half_extents(normal: Vec3, radius: f32) -> Vec3 {
    const SLACK: f32 = 1e-4;
    let along = normal * normal;
    let thinness = (1.0 + SQUASH).powi(-2);
    let squares = (Vec3::ONE - along).max(Vec3::ZERO) + along * thinness;
    Vec3::from(squares.to_array().map(f32::sqrt)) * radius + radius * SLACK
}

/// The cell of a position, clamped to the range of `i32`.
#[inline(always)]
fn place(position: Vec3, cells_per_metre: f32) -> IVec3 {
    (position * cells_per_metre).floor().as_ivec3()
}

/// Teschner et al. 2003, "Optimized Spatial Hashing for Collision Detection of Deformable Objects", with the level as a
/// fourth number and its high bits mixed into the low ones.
#[inline(always)]
fn hash(place: IVec3, level: u32) -> u32 {
    let [x, y, z] = place.to_array().map(|x| x as u32);
    let mixed = x.wrapping_mul(73_856_093)
        ^ y.wrapping_mul(19_349_663)
        ^ z.wrapping_mul(83_492_791)
        ^ level.wrapping_mul(2_654_435_761);
    mixed ^ mixed >> 15
}

/// Weights of the functions of a cell, eight at a time.
struct Weights<'a, V> {
    grid: &'a FunctionGrid,
    slot: usize,
    radius: f32,
    point: (Vec3, Vec3),
    visit: V,
}

impl<V: FnMut(u32, f32)> Kernel for Weights<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let (position, normal): (Vec3x8<L>, Vec3x8<L>) = (Vec3x8::splat(self.point.0), Vec3x8::splat(self.point.1));
        let eights = &self.grid.eights[self.grid.first_eight[self.slot] as usize..];
        for (functions, eight) in self.grid.functions_in(self.slot).chunks(8).zip(eights) {
            let [center, axis] = [Vec3x8::load(&eight[0]), Vec3x8::load(&eight[1])];
            let weights = weight_x8((center, axis), self.radius, position, normal);
            let mut reached = weights.simd_gt(L::splat(0.0)).to_bitmask();
            let weights = weights.to_array();
            while reached != 0 {
                let lane = reached.trailing_zeros() as usize;
                reached &= reached - 1;
                (self.visit)(functions[lane], weights[lane]);
            }
        }
    }
}

/// Weights of eight functions of some radius at a point (meshless paper, Eq. 8 and 9, reduced between layers).
#[inline(always)]
fn weight_x8<L: Lanes>(
    (center, axis): (Vec3x8<L>, Vec3x8<L>),
    radius: f32,
    position: Vec3x8<L>,
    normal: Vec3x8<L>,
) -> L {
    let (facing, offset) = (normal.dot(axis), position - center);
    let height = offset.dot(axis);
    let distance_sq = offset.dot(offset) + L::splat(STRETCH) * height * height;
    // Eq. 10, squared: most functions of a cell are rejected here, without a square root.
    let is_reached = facing.simd_gt(L::splat(0.0)) & distance_sq.simd_lt(L::splat(radius * radius));
    if is_reached.to_bitmask() == 0 {
        return L::splat(0.0);
    }
    // As in [`super::distance::same_layer`].
    let step = L::splat(0.5) * offset.dot(normal + axis).abs() / L::splat(radius);
    let layer = L::splat(LEAST_WEIGHT) + L::splat(1.0 - LEAST_WEIGHT) * kernel_x8(L::splat(LAYERS) * step);
    (kernel_x8(distance_sq.sqrt() / L::splat(radius)) * layer * facing * facing) & is_reached
}

/// [`super::distance::kernel`] for eight distances.
#[inline(always)]
fn kernel_x8<L: Lanes>(t: L) -> L {
    let t = t.fast_min(L::splat(1.0));
    (L::splat(2.0) * t - L::splat(3.0)) * t * t + L::splat(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfel::distance::kernel;
    use crate::{
        meshless::{Basis, FunctionPlace},
        sphere::uniform_direction,
        test_scenes::sphere_points,
    };

    fn basis(points: Vec<Surfel>, radius: f32) -> Basis {
        let end = points.len() as u32;
        Basis::from_parts(points, vec![0, end], vec![radius], 1).unwrap()
    }

    fn weights(basis: &Basis, position: Vec3, normal: Vec3) -> Vec<(u32, f32)> {
        let mut found = Vec::new();
        let at = FunctionPlace::new(position, normal);
        basis.functions().for_each_weight(0, &at, |function, weight| found.push((function, weight)));
        found
    }

    #[test]
    fn the_grid_finds_what_brute_force_finds() {
        let points = sphere_points(500, 1.0);
        let basis = basis(points.clone(), 0.4);
        let mut random = fastrand::Rng::with_seed(1);
        let mut seen = 0;
        for _ in 0..500 {
            let normal = uniform_direction(random.f32(), random.f32());
            let position = normal * (0.85 + 0.3 * random.f32());
            let found = weights(&basis, position, normal);
            for (i, p) in points.iter().enumerate() {
                let offset = position - p.position;
                let distance = (offset + SQUASH * offset.dot(p.normal) * p.normal).length();
                let step = 4.0 * offset.dot(p.normal + normal).abs() / 0.4;
                let weight =
                    kernel(distance / 0.4) * (0.02 + 0.98 * kernel(step)) * normal.dot(p.normal).max(0.0).powi(2);
                let in_grid = found.iter().find(|f| f.0 == i as u32).map_or(0.0, |f| f.1);
                assert!((weight - in_grid).abs() < 1e-5, "{weight} and {in_grid} at {position}");
                seen += usize::from(weight > 1e-4);
            }
        }
        assert!(seen > 1000);
        let elsewhere = weights(&basis, Vec3::Y * 1.01, Vec3::Y);
        assert!(elsewhere != weights(&basis, Vec3::new(0.1, 1.01, 0.0), Vec3::Y), "negative control: a shifted point");
    }

    #[test]
    fn every_cell_is_found_and_lists_what_overlaps_it_once() {
        let points = [sphere_points(40, 1.0), sphere_points(160, 1.0)].concat();
        let basis = Basis::from_parts(points, vec![0, 40, 200], vec![0.8, 0.4], 1).unwrap();
        let grid = basis.functions().grid();
        let cells: Vec<&Cell> = grid.slots().iter().filter(|cell| cell.count > 0).collect();
        assert!(grid.slots().len().is_power_of_two() && 2 * cells.len() <= grid.slots().len());
        for cell in &cells {
            let edge = 1.0 / grid.cells_per_metre()[cell.level as usize];
            let middle = (IVec3::from(cell.place).as_vec3() + 0.5) * edge;
            let functions = grid.functions_in(grid.slot_at(cell.level as usize, middle));
            assert!(functions.len() == cell.count as usize && functions.is_sorted_by(|a, b| a < b));
            let of_level = basis.level(cell.level as usize);
            assert!(functions.iter().all(|&f| of_level.contains(&(f as usize))), "{functions:?}");
        }
        assert_eq!(cells.iter().map(|cell| cell.count as usize).sum::<usize>(), grid.entries().len());
        assert!(grid.functions_in(grid.slot_at(0, Vec3::splat(50.0))).is_empty(), "negative control: far from all");
    }

    #[test]
    fn functions_are_found_however_small_they_are() {
        for (radius, x) in [(1e-15, 3e8), (1e-12, -1e9), (1e-6, 4e3), (4e9, 1.0)] {
            let lone = Surfel { position: Vec3::splat(x), ..Default::default() };
            assert_eq!(weights(&basis(vec![lone], radius), Vec3::splat(x), Vec3::Y), [(0, 1.0)], "{radius} at {x}");
        }
    }

    #[test]
    fn layers_close_behind_each_other_hardly_mix_and_a_lone_one_reaches_as_far_as_before() {
        let layer = |y: f32| Surfel { position: Vec3::Y * y, ..Default::default() };
        let share_of_back = |gap: f32| {
            let found = weights(&basis(vec![layer(0.0), layer(-gap)], 1.0), Vec3::X * 0.2, Vec3::Y);
            let sum: f32 = found.iter().map(|f| f.1).sum();
            found.iter().find(|f| f.0 == 1).map_or(0.0, |f| f.1 / sum)
        };
        assert!(share_of_back(0.15) < 0.02 && share_of_back(0.005) > 0.45, "{}", share_of_back(0.15));
        assert!(
            kernel((0.04_f32 + 0.15 * 0.15 * 9.0).sqrt()) / kernel(0.2) > 0.5,
            "negative control: it is within reach"
        );
        let reached = weights(&basis(vec![layer(0.0)], 1.0), Vec3::Y * 0.3, Vec3::Y);
        assert!(reached.len() == 1 && reached[0].1 > 0.0);
    }

    #[test]
    fn an_empty_level_reaches_nothing() {
        assert!(weights(&basis(Vec::new(), 1.0), Vec3::ZERO, Vec3::Y).is_empty());
    }
}
