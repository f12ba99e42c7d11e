//! The local spacing of surface sources.
//!
//! A receiver treats a source's light as coming from its center. The error is the distance between that center and the light's true
//! origin, relative to the distance to the receiver. The rim of a table one centimeter above a ledge needs sources millimeters
//! apart; decimeters suffice for a ceiling. So rays start at receivers, and their hits are divided into cells with a small sum of
//! squared errors ([`Cells`]). The cell widths determine the spacing of the sources.

use super::{
    candidates::{Candidates, Segment},
    cells::{Cells, WeightedHit},
    disk::DENSITY,
};
use crate::errors::PointsError;
use lapidary_core::surfel::Surfel;
use rayon::prelude::*;

/// Mean number of segments per cell.
const SEGMENTS: usize = 128;
/// Smallest segment length relative to the median: closer surfaces belong to the same fold.
const SHORTEST: f32 = 0.02;
/// The spacing is proportional to this power of the width. A cell's width is proportional to the root of the length of the segments
/// that end there. But light from both sides of a source cancels, so the error of a receiver is of second order in spacing over
/// length. The sum of its squares is smallest for a spacing proportional to the length to the power of 2/3 (best density of centers
/// on a surface for errors to the fourth). Cells divided by that measure directly are worse, because then few segments decide.
const WIDTH_POWER: f32 = 4.0 / 3.0;
/// Largest spacing relative to an even set ([`even_spacing`]): few receivers are close to a lamp's bright spot on a table, yet it
/// lights the whole room.
const WIDEST: f32 = 2.0;
/// Neighbors that measure the local density of points, and the number of points measured.
const NEIGHBOURS: usize = 8;
const SAMPLED: usize = 256;

/// The largest spacing of sources, up to a common factor.
pub struct Spacing {
    cells: Cells,
    /// Width in meters of a cell whose spacing is the width itself.
    typical: f32,
    /// Largest spacing in meters.
    widest: f32,
}

impl Spacing {
    /// For `count` sources on the candidates' surfaces.
    ///
    /// # Errors
    /// [`PointsError::Cancelled`].
    pub fn new(candidates: &mut Candidates, count: usize) -> Result<Self, PointsError> {
        let segments = candidates.particle_segments(2 * count)?;
        let widest = WIDEST * even_spacing(&segments, count);
        let mut lengths: Vec<f32> = segments.iter().map(|segment| segment.length).collect();
        let shortest = SHORTEST * median(&mut lengths);
        let mut hits = Vec::with_capacity(SEGMENTS * count);
        while hits.len() < SEGMENTS * count {
            let Some(Segment { end, length }) = candidates.draw_segment()? else { break };
            hits.push(WeightedHit::new(&end, length.max(shortest)));
        }
        Ok(Self::of(Cells::new(hits, count), widest))
    }

    fn of(cells: Cells, widest: f32) -> Self {
        // The power of the widths allows as many sources as the widths if both are equal at this width.
        let power = 2.0 - 2.0 * WIDTH_POWER;
        let (sum, count) = cells.widths().fold((0.0, 0), |(sum, count), width| (sum + width.powf(power), count + 1));
        let typical = if count > 0 { (sum / count as f32).powf(power.recip()) } else { widest };
        Self { cells, typical, widest }
    }

    /// Spacing in meters at a point, scaled by the factor.
    pub fn at(&self, place: &Surfel, factor: f32) -> f32 {
        let width = self.cells.width_at(place) / self.typical;
        (factor * self.typical * width.powf(WIDTH_POWER)).min(self.widest)
    }
}

/// Median; 0 without values.
fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// Radius of an even Poisson-disk set of `count` points over the surface of the given points. Each point represents the area left
/// by its nearest neighbors, even in an uneven set.
fn even_spacing(places: &[Segment], count: usize) -> f32 {
    let area_of = |place: &Segment| {
        let distance_sq = |other: &Segment| other.end.position.distance_squared(place.end.position);
        let mut distances: Vec<f32> = places.iter().map(distance_sq).collect();
        let nearest = NEIGHBOURS.min(places.len() - 1);
        std::f32::consts::PI * *distances.select_nth_unstable_by(nearest, f32::total_cmp).1 / nearest.max(1) as f32
    };
    let step = (places.len() / SAMPLED).max(1);
    // Summed in order; parallel sums would vary.
    let areas: Vec<f32> = places.par_iter().step_by(step).map(area_of).collect();
    let mean = areas.iter().sum::<f32>() / areas.len().max(1) as f32;
    (DENSITY * mean * places.len() as f32 / count as f32).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Segments of a quarter of a meter to points with negative x, and of one meter to the others.
    #[test]
    fn spacing_goes_with_the_length_of_segments_to_the_power_of_two_thirds() {
        let surfel = |x, z| Surfel { position: Vec3::new(x, 0.0, z), ..Default::default() };
        let mut rng = fastrand::Rng::with_seed(11);
        let mut coordinate = || 2.0 * rng.f32() - 1.0;
        let places: Vec<Surfel> = (0..60_000).map(|_| surfel(coordinate(), coordinate())).collect();
        let length = |place: &Surfel| if place.position.x < 0.0 { 0.25 } else { 1.0 };
        let cells = |count| Cells::new(places.iter().map(|p| WeightedHit::new(p, length(p))).collect(), count);
        let ratio = |at: &dyn Fn(&Surfel) -> f32| {
            let mean = |side: f32| {
                let of_side = places.iter().filter(|p| p.position.x * side > 0.1);
                of_side.clone().map(at).sum::<f32>() / of_side.count() as f32
            };
            mean(1.0) / mean(-1.0)
        };
        // Cells halve at different counts on both sides: average over an octave of counts.
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
