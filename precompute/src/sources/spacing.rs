//! How close together surface sources are, place by place.
//!
//! A receiver takes the light of a source to come from one place. What it receives is wrong by how far that is from where light
//! does come from, in units of how far away the receiver is: the rim of a table over a ledge of a centimetre wants sources of
//! millimetres, the ceiling does with decimetres. So rays go from receivers, where they end is divided into cells whose
//! sum of these squared errors is small ([`Cells`]), and the widths of these tell how far apart sources are.

use super::{
    candidates::{Candidates, Segment},
    cells::{Cells, Landing},
    disk::DENSITY,
};
use crate::errors::PointsError;
use lapidary_core::surfel::Surfel;
use rayon::prelude::*;

/// Segments of a cell, on average.
const SEGMENTS: usize = 128;
/// Segments count as no shorter than this share of the median: what is nearer lies in the same fold.
const SHORTEST: f32 = 0.02;
/// The spacing goes with this power of the width. Cells are as wide as the root of the length of the segments that land there.
/// But light from either side of a source cancels, so that what a receiver gets is wrong by the second order of the distance
/// over that length: for a least sum of its squares the spacing goes with the length to the power of 2/3 (best density of
/// centres on a surface for errors to the fourth). Cells divided by that measure themselves are worse, for few segments
/// decide then.
const OF_WIDTH: f32 = 4.0 / 3.0;
/// Sources are no farther apart than so many times as they are in an even set ([`even_spacing`]): little is seen of a lamp's
/// bright spot on a table from near by, and yet it lights the whole room.
const WIDEST: f32 = 2.0;
/// Neighbours that tell how close together places are, at so many of these.
const NEIGHBOURS: usize = 8;
const SAMPLED: usize = 256;

/// How far apart sources may be, but for a common factor.
pub struct Spacing {
    cells: Cells,
    /// Width in metres of a cell at which the spacing goes with the width itself.
    typical: f32,
    /// In metres.
    widest: f32,
}

impl Spacing {
    /// For `count` sources where candidates lie.
    ///
    /// # Errors
    /// [`PointsError::Cancelled`].
    pub fn new(candidates: &mut Candidates, count: usize) -> Result<Self, PointsError> {
        let segments = candidates.particle_segments(2 * count)?;
        let widest = WIDEST * even_spacing(&segments, count);
        let mut lengths: Vec<f32> = segments.iter().map(|segment| segment.length).collect();
        let shortest = SHORTEST * median(&mut lengths);
        let mut landings = Vec::with_capacity(SEGMENTS * count);
        while landings.len() < SEGMENTS * count {
            let Some(Segment { end, length }) = candidates.draw_segment()? else { break };
            landings.push(Landing::new(&end, length.max(shortest)));
        }
        Ok(Self::of(Cells::new(landings, count), widest))
    }

    fn of(cells: Cells, widest: f32) -> Self {
        // Of a power of widths as many sources fit as of the widths, if at this width both are alike.
        let power = 2.0 - 2.0 * OF_WIDTH;
        let (sum, count) = cells.widths().fold((0.0, 0), |(sum, count), width| (sum + width.powf(power), count + 1));
        let typical = if count > 0 { (sum / count as f32).powf(power.recip()) } else { widest };
        Self { cells, typical, widest }
    }

    /// Metres at a place, by the factor.
    pub fn at(&self, place: &Surfel, factor: f32) -> f32 {
        let width = self.cells.width_at(place) / self.typical;
        (factor * self.typical * width.powf(OF_WIDTH)).min(self.widest)
    }
}

/// 0 of none.
fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// Radius of a Poisson-disk set of `count` points spread evenly over all surface that places lie on: each stands for so much of it
/// as the nearest others leave it, however unevenly they lie.
fn even_spacing(places: &[Segment], count: usize) -> f32 {
    let area_of = |place: &Segment| {
        let distance_sq = |other: &Segment| other.end.position.distance_squared(place.end.position);
        let mut distances: Vec<f32> = places.iter().map(distance_sq).collect();
        let nearest = NEIGHBOURS.min(places.len() - 1);
        std::f32::consts::PI * *distances.select_nth_unstable_by(nearest, f32::total_cmp).1 / nearest.max(1) as f32
    };
    let step = (places.len() / SAMPLED).max(1);
    // Summed in order, which threads would not.
    let areas: Vec<f32> = places.par_iter().step_by(step).map(area_of).collect();
    let mean = areas.iter().sum::<f32>() / areas.len().max(1) as f32;
    (DENSITY * mean * places.len() as f32 / count as f32).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Segments of a quarter of a metre to the places of negative x, and of a metre to the others.
    #[test]
    fn spacing_goes_with_the_length_of_segments_to_the_power_of_two_thirds() {
        let surfel = |x, z| Surfel { position: Vec3::new(x, 0.0, z), ..Default::default() };
        let mut rng = fastrand::Rng::with_seed(11);
        let mut coordinate = || 2.0 * rng.f32() - 1.0;
        let places: Vec<Surfel> = (0..60_000).map(|_| surfel(coordinate(), coordinate())).collect();
        let length = |place: &Surfel| if place.position.x < 0.0 { 0.25 } else { 1.0 };
        let cells = |count| Cells::new(places.iter().map(|p| Landing::new(p, length(p))).collect(), count);
        let ratio = |at: &dyn Fn(&Surfel) -> f32| {
            let mean = |side: f32| {
                let of_side = places.iter().filter(|p| p.position.x * side > 0.1);
                of_side.clone().map(at).sum::<f32>() / of_side.count() as f32
            };
            mean(1.0) / mean(-1.0)
        };
        // Cells halve, on one side before the other: a mean over an octave of counts.
        let ratios = [453, 538, 640, 761].map(|count| {
            let widths = {
                let cells = cells(count);
                ratio(&|place| cells.width_at(place))
            };
            let spacing = Spacing::of(cells(count), 1.0);
            [widths, ratio(&|place| spacing.at(place, 1.0))].map(f32::ln)
        });
        let [widths, found] = [0, 1].map(|i| (ratios.iter().map(|r| r[i]).sum::<f32>() / 4.0).exp());
        let known = 4.0_f32.powf(2.0 / 3.0);
        assert!((found / known - 1.0).abs() < 0.1, "{found} for {known}");
        assert!((widths / known - 1.0).abs() > 0.12, "negative control: the cells themselves, {widths}");
        let unlit = Spacing::of(Cells::new(Vec::new(), 1), 1.0);
        assert_eq!([1.0, 12.0].map(|factor| unlit.at(&places[0], factor)), [1.0; 2], "no more than the widest");
    }
}
