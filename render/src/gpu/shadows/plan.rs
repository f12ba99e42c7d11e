//! Which light has which layers of the shadow maps, and how large they are.

use super::view::view_count;
use crate::device::layout::constants::NO_SHADOW;

use lapidary_core::lights::{Emission, Light};

/// How much there may be of shadow maps, and of suns with rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadowRoom {
    /// Layers in all; WebGPU's default limit is 256.
    pub layers: u32,
    /// Suns that cast shadows, by rays.
    pub suns: u32,
    /// Texels per side with few layers; halved down to [`SMALLEST`] with many layers.
    pub largest: u32,
}

/// Texels of a side with many layers.
pub const SMALLEST: u32 = 512;

/// Texels of all layers together, 256 MiB at 4 bytes each: 16 layers of 2048 x 2048, or 256 of 512 x 512.
const MOST_TEXELS: u64 = 64 << 20;

/// With at most this many layers, rectangles cast shadows from a finer grid: maps of 1024 x 1024 remain.
const LAYERS_FOR_FINE_GRID: u32 = 64;
const FINE_GRID: u32 = 3;
const COARSE_GRID: u32 = 2;

/// Layers of the lights.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// First layer of each light, or [`NO_SHADOW`].
    pub first: Vec<u32>,
    /// Layers in use.
    pub layers: u32,
    /// Texels of a side.
    pub size: u32,
    /// Rectangles cast shadows from `grid` x `grid` points.
    pub grid: u32,
}

impl Plan {
    /// Layers for `lights`. If not all fit, lights with the most power per layer in a scene of `radius` meters get
    /// them.
    pub fn new(lights: &[Light], room: ShadowRoom, radius: f32) -> Self {
        let grid = if layers_wanted(lights, FINE_GRID) <= LAYERS_FOR_FINE_GRID { FINE_GRID } else { COARSE_GRID };
        let casts = casting(lights, room.layers, grid, radius);
        let mut layers = 0;
        let mut place = |(light, casts): (&Light, bool)| {
            let first = if casts { layers } else { NO_SHADOW };
            layers += if casts { view_count(light, grid) } else { 0 };
            first
        };
        // In the order of the lights, so that most keep their layers while one changes.
        let first = lights.iter().zip(casts).map(&mut place).collect();
        Self { first, layers, size: map_size(layers, room.largest), grid }
    }

    /// Remark on lights without shadows.
    pub fn remark(&self, lights: &[Light], room: ShadowRoom) -> Option<String> {
        let without = self.first.iter().filter(|&&first| first == NO_SHADOW).count();
        let (all, wanted, limit) = (lights.len(), layers_wanted(lights, self.grid), room.layers);
        (without > 0).then(|| {
            format!(
                "{without} of {all} local lights shine without shadows: together they need {wanted} shadow maps, but this \
                 adapter has room for {limit}, which the strongest have; switch some off, or make them narrow spots"
            )
        })
    }
}

/// Which lights get layers.
fn casting(lights: &[Light], room: u32, grid: u32, radius: f32) -> Vec<bool> {
    let power = |i: usize| lights[i].power_bound(radius) / view_count(&lights[i], grid) as f32;
    let mut order: Vec<usize> = (0..lights.len()).collect();
    order.sort_by(|&a, &b| power(b).total_cmp(&power(a)));
    let (mut casts, mut left) = (vec![false; lights.len()], room);
    for i in order {
        let count = view_count(&lights[i], grid);
        if count <= left {
            (casts[i], left) = (true, left - count);
        }
    }
    casts
}

fn layers_wanted(lights: &[Light], grid: u32) -> u32 {
    lights.iter().map(|light| view_count(light, grid)).sum()
}

/// Layers to make room for, so that another light need not move all.
pub fn capacity(layers: u32, size: u32, room: ShadowRoom) -> u32 {
    let fitting = (MOST_TEXELS / u64::from(size).pow(2)).min(u64::from(room.layers)) as u32;
    layers.next_power_of_two().min(fitting).max(layers).max(1)
}

fn map_size(layers: u32, largest: u32) -> u32 {
    let mut size = if layers == 0 { SMALLEST } else { largest };
    while size > SMALLEST && u64::from(layers) * u64::from(size).pow(2) > MOST_TEXELS {
        size /= 2;
    }
    size
}

/// Whether a light gives any light: those that do not take no layers.
pub fn shines(light: &Light) -> bool {
    light.shines() && (matches!(light.emission, Emission::Point) || light.forward().is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const RADIUS: f32 = 1.0;
    const ROOM: ShadowRoom = ShadowRoom { layers: 256, suns: 8, largest: 2048 };

    fn light(emission: Emission) -> Light {
        Light { emission, position: Vec3::Y, ..Default::default() }
    }

    #[test]
    fn layers_follow_the_lights_and_maps_shrink_as_they_grow_in_number() {
        let rectangle = light(Emission::Rectangle { width: 1.0, height: 1.0 });
        let spot = light(Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 });
        let point = light(Emission::Point);
        let plan = Plan::new(&[point.clone(), spot.clone(), spot.clone()], ROOM, RADIUS);
        assert_eq!((plan.first.as_slice(), plan.layers, plan.size), (&[0, 6, 7][..], 8, 2048));
        let sun = Plan::new(&[light(Emission::PARALLEL)], ROOM, RADIUS);
        assert_eq!((sun.layers, sun.size), (0, SMALLEST), "a sun has rays");
        let plan = Plan::new(&[rectangle.clone(), spot.clone()], ROOM, RADIUS);
        assert_eq!((plan.first.as_slice(), plan.size, plan.grid), (&[0, 45][..], 1024, 3));
        let plan = Plan::new(&vec![rectangle; 5], ROOM, RADIUS);
        assert_eq!((plan.layers, plan.size, plan.grid), (100, 512, 2));
        assert_eq!(Plan::new(&vec![spot; 16], ROOM, RADIUS).size, 2048);
        assert_eq!(Plan::new(&vec![point; 42], ROOM, RADIUS).size, 512);
    }

    #[test]
    fn lights_beyond_the_limit_go_without_and_a_remark_has_both_numbers() {
        let mut lights = vec![light(Emission::Point); 45];
        lights.push(light(Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 }));
        let plan = Plan::new(&lights, ROOM, RADIUS);
        assert_eq!((plan.first[41], plan.first[42], plan.first[45], plan.layers), (246, NO_SHADOW, 252, 253));
        let remark = plan.remark(&lights, ROOM).unwrap();
        assert!(["3 of 46", "271", "256"].iter().all(|n| remark.contains(n)), "{remark}");
        assert_eq!(Plan::new(&lights[..42], ROOM, RADIUS).remark(&lights[..42], ROOM), None);
    }

    #[test]
    fn the_strongest_of_thousands_have_shadows() {
        let mut lights = vec![light(Emission::Point); 2000];
        let strong = [7, 900, 1999];
        strong.iter().for_each(|&i| lights[i].intensity *= 10.0);
        lights[1500] = light(Emission::Spot { cone_degrees: 80.0, penumbra_degrees: 5.0 });
        let plan = Plan::new(&lights, ROOM, RADIUS);
        let casting: Vec<usize> = (0..2000).filter(|&i| plan.first[i] != NO_SHADOW).collect();
        assert_eq!((casting.len(), plan.layers, plan.size), (42, 6 * 42, 512));
        assert!(strong.iter().all(|i| casting.contains(i)) && !casting.contains(&1500), "{casting:?}");
        let taken: Vec<u32> = casting.iter().map(|&i| plan.first[i]).collect();
        assert_eq!(taken, (0..42).map(|i| 6 * i).collect::<Vec<_>>(), "in the order of the lights");
        lights[1500].intensity *= 100.0;
        assert_ne!(Plan::new(&lights, ROOM, RADIUS).first[1500], NO_SHADOW, "negative control");
        let remark = plan.remark(&lights, ROOM).unwrap();
        assert!(["1958 of 2000", "11999", "256"].iter().all(|n| remark.contains(n)), "{remark}");
    }

    #[test]
    fn room_grows_by_doubling_and_stays_within_the_budget() {
        assert_eq!([1, 3, 9, 16].map(|n| capacity(n, 2048, ROOM)), [1, 4, 16, 16]);
        assert_eq!([17, 40, 64].map(|n| capacity(n, 1024, ROOM)), [32, 64, 64]);
        assert_eq!([0, 256].map(|n| capacity(n, 512, ROOM)), [1, 256]);
    }

    #[test]
    fn what_gives_no_light_is_left_out() {
        let lamp = light(Emission::PARALLEL);
        assert!(shines(&lamp) && !shines(&Light { enabled: false, ..lamp.clone() }));
        assert!(!shines(&Light { intensity: Vec3::ZERO, ..lamp.clone() }));
        assert!(!shines(&Light { target: lamp.position, ..lamp }), "without a direction");
    }
}
