//! How close together surface sources are, place by place.
//!
//! A receiver takes the light of a source to come from one place. What it receives is wrong by how far that is from where light
//! does come from, in units of how far away the receiver is: the rim of a table over a ledge of a centimetre wants sources of
//! millimetres, the ceiling does with decimetres. So rays fly from receivers, and where they end is divided into cells whose
//! sum of these squared errors is small, the worst cell first (divisive k-means). Sources are apart in proportion to the width of
//! the cells that they lie in.

use super::{Candidates, PointsError, candidates::Flight};
use glam::Vec3;
use lapidary_core::surfel::{GradedGrid, Surfel};
use rayon::prelude::*;
use std::{cmp::Ordering, collections::BinaryHeap};

/// Flights of a cell, on average.
const FLIGHTS: usize = 64;
/// Fewer do not tell how wide their cell is.
const LEAST_FLIGHTS: usize = 8;
/// Flights count as no shorter than this share of the median: what is nearer lies in the same fold.
const SHORTEST: f32 = 0.03;
/// A cell has a say for places within so many of its widths.
const REACH: f32 = 3.0;
/// Sources are no farther apart than so many times as they are if all are as far: little is seen of a lamp's bright spot on a
/// table from near by, and yet it lights the whole room.
const WIDEST: f32 = 2.0;
/// Neighbours that tell how close together places are, at so many of these.
const NEIGHBOURS: usize = 8;
const SAMPLED: usize = 256;

/// How far apart sources may be, but for a common factor.
pub struct Spacing {
    cells: GradedGrid,
    /// In metres, whatever the factor.
    widest: f32,
}

impl Spacing {
    /// For `count` sources where candidates lie.
    ///
    /// # Errors
    /// [`PointsError::Cancelled`].
    pub fn new(candidates: &mut Candidates, count: usize) -> Result<Self, PointsError> {
        let strays = candidates.strays(2 * count)?;
        let widest = WIDEST * even_spacing(&strays, count);
        let mut flights = Vec::with_capacity(FLIGHTS * count);
        while flights.len() < FLIGHTS * count {
            let Some(flight) = candidates.draw_flight()? else { break };
            flights.push(flight);
        }
        let reach = |(at, width): (Surfel, f32)| (at, REACH * width);
        Ok(Self { cells: GradedGrid::of(divided(&mut flights, count).into_iter().map(reach)), widest })
    }

    /// Metres at a place, by the factor. The mean of the cells around, in logarithm.
    pub fn at(&self, place: &Surfel, factor: f32) -> f32 {
        let (mut sum, mut weights) = (0.0, 0.0);
        self.cells.any_near(place.position, |_, cell, reach| {
            let weight = (1.0 - cell.position.distance(place.position) / reach).max(0.0).powi(2);
            sum += weight * reach.ln();
            weights += weight;
            false
        });
        let width = if weights > 0.0 { (sum / weights).exp() / REACH } else { self.widest };
        (factor * width).min(self.widest)
    }
}

/// Radius of a Poisson-disk set of `count` points on the surface over which places are spread evenly, at random.
fn even_spacing(places: &[Flight], count: usize) -> f32 {
    /// Squared radius of such a set, as a share of the area that each of its points stands for.
    const DENSITY: f32 = 0.79;
    let reach_sq = |place: &Flight| {
        let distance_sq = |other: &Flight| other.end.position.distance_squared(place.end.position);
        let mut distances: Vec<f32> = places.iter().map(distance_sq).collect();
        *distances.select_nth_unstable_by(NEIGHBOURS.min(places.len() - 1), f32::total_cmp).1
    };
    let step = (places.len() / SAMPLED).max(1);
    let mut reaches: Vec<f32> = places.par_iter().step_by(step).map(reach_sq).collect();
    if reaches.is_empty() {
        return 0.0;
    }
    let middle = reaches.len() / 2;
    let area_of_place =
        std::f32::consts::PI * *reaches.select_nth_unstable_by(middle, f32::total_cmp).1 / NEIGHBOURS as f32;
    (DENSITY * area_of_place * places.len() as f32 / count as f32).sqrt()
}

/// A place and the width in metres of each of at most `count` cells. Changes the order of the flights.
fn divided(flights: &mut [Flight], count: usize) -> Vec<(Surfel, f32)> {
    let shortest = SHORTEST * median_length(flights);
    let mut cells = BinaryHeap::from([Cell::new(flights, 0, flights.len(), shortest)]);
    let mut whole = Vec::new();
    while cells.len() + whole.len() < count {
        let Some(cell) = cells.pop() else { break };
        if cell.end - cell.first < 2 * LEAST_FLIGHTS || cell.error == 0.0 {
            whole.push(cell);
            continue;
        }
        let members = &mut flights[cell.first..cell.end];
        members.sort_unstable_by(|a, b| a.end.position[cell.axis].total_cmp(&b.end.position[cell.axis]));
        let below = members.partition_point(|f| f.end.position[cell.axis] < cell.mean);
        let middle = cell.first + below.clamp(LEAST_FLIGHTS, members.len() - LEAST_FLIGHTS);
        cells.push(Cell::new(flights, cell.first, middle, shortest));
        cells.push(Cell::new(flights, middle, cell.end, shortest));
    }
    whole.extend(cells);
    whole.retain(|cell| cell.width > 0.0);
    whole.iter().map(|cell| (flights[(cell.first + cell.end) / 2].end, cell.width)).collect()
}

fn median_length(flights: &mut [Flight]) -> f32 {
    let middle = flights.len() / 2;
    if flights.is_empty() {
        return 0.0;
    }
    flights.select_nth_unstable_by(middle, |a, b| a.flown.total_cmp(&b.flown)).1.flown
}

/// Flights that end close together: those from `first` to before `end`.
struct Cell {
    first: usize,
    end: usize,
    /// Sum of the squared errors of its flights.
    error: f32,
    /// The axis along which they spread most, and their mean on it.
    axis: usize,
    mean: f32,
    /// Root of their mean squared distance from the mean, in metres.
    width: f32,
}

impl Cell {
    /// Flights weigh by the inverse square of their length, which is at least `shortest`.
    fn new(flights: &[Flight], first: usize, end: usize, shortest: f32) -> Self {
        let flights = &flights[first..end];
        let weighted = flights.iter().map(|f| (f.end.position, f.flown.max(shortest).max(f32::MIN_POSITIVE).powi(-2)));
        let (sum, weight) = weighted.clone().fold((Vec3::ZERO, 0.0), |(sum, weight), (p, w)| (sum + p * w, weight + w));
        let mean = sum / weight;
        let squares: Vec3 = weighted.map(|(p, w)| (p - mean) * (p - mean) * w).sum();
        let error = squares.element_sum();
        let axis = squares.max_position();
        Self { first, end, error, axis, mean: mean[axis], width: (error / weight).sqrt() }
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error).then(self.first.cmp(&other.first))
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}
