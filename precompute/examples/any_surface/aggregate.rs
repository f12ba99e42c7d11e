//! Surfaces of different kinds combined into one.

use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    meshless::{Carrier, Owner},
    surfel::{Surface, Surfel},
};

/// Range of `place.triangle` values reserved for each part.
const PLACES: u32 = 1 << 16;

/// All parts of the scene.
pub struct Aggregate {
    parts: Vec<Box<dyn Surface + Send>>,
}

impl Aggregate {
    pub fn new(parts: Vec<Box<dyn Surface + Send>>) -> Self {
        Self { parts }
    }

    /// The part that a surfel belongs to.
    pub fn part_of(&self, at: &Surfel) -> usize {
        (at.place.triangle / PLACES) as usize
    }
}

impl Surface for Aggregate {
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel> {
        let hits = self.parts.iter().zip(0_u32..).filter_map(|(part, index)| {
            let mut hit = part.first_hit(origin, direction)?;
            hit.place.triangle += index * PLACES;
            Some(hit)
        });
        let distance = |hit: &Surfel| hit.position.distance_squared(origin);
        hits.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    fn sees(&self, from: Vec3, to: Vec3) -> bool {
        self.parts.iter().all(|part| part.sees(from, to))
    }

    fn reflectance(&self, at: &Surfel) -> Vec3 {
        let mut within = *at;
        within.place.triangle %= PLACES;
        self.parts[self.part_of(at)].reflectance(&within)
    }

    fn bounds(&self) -> Bounds {
        Bounds::around(self.parts.iter().flat_map(|part| [part.bounds().min, part.bounds().max]))
    }

    fn offset(&self) -> f32 {
        self.parts.iter().map(|part| part.offset()).fold(0.0, f32::max)
    }
}

/// Each part carries functions of its own.
impl Carrier for Aggregate {
    fn owner(&self, at: &Surfel) -> Owner {
        Owner { object: self.part_of(at) as u32, ..Owner::default() }
    }
}

/// Whether a part lets light pass between two points.
pub fn passes(part: &dyn Surface, from: Vec3, to: Vec3) -> bool {
    let distance = from.distance(to);
    let hit = part.first_hit(from, (to - from) / distance.max(f32::MIN_POSITIVE));
    hit.is_none_or(|hit| hit.position.distance(from) > distance)
}
