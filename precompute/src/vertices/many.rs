//! Visibility of all light samples from many bake points, on the cores of this machine or on a device.

use super::{points::BakePoint, side::Side, visibility::VisibilitySampler};
use crate::errors::BakeError;
use glam::Vec3;
use lapidary_core::ray::{BoundaryTracer, Intersector, RayDevice, RayDevices, RayOrigin};
use rayon::prelude::*;

/// How lights are traced, and by whom.
#[derive(Clone, Copy)]
pub struct Tracing<'a> {
    /// Lights for each that is probed, see [`VisibilitySampler::new`].
    pub lights_per_probe: usize,
    /// What traces every light in place of the cores.
    pub devices: Option<&'a dyn RayDevices>,
}

/// Who traces.
pub enum ManySampler<'a> {
    /// The cores.
    Cores(VisibilitySampler<'a>),
    /// A device, which traces every light.
    Device {
        /// The scene on the device.
        device: Box<dyn RayDevice>,
        /// The directions to the lights.
        directions: Vec<Vec3>,
    },
}

impl<'a> ManySampler<'a> {
    /// For any unit directions, in the order given.
    ///
    /// # Errors
    /// What is wrong with the device.
    pub fn new(scene: &'a Intersector, directions: &[Vec3], tracing: Tracing) -> Result<Self, BakeError> {
        Ok(match tracing.devices {
            None => Self::Cores(VisibilitySampler::of_directions(scene, directions, tracing.lights_per_probe)),
            Some(devices) => Self::Device {
                device: devices.device(scene, directions).map_err(BakeError::Device)?,
                directions: directions.to_vec(),
            },
        })
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        match self {
            Self::Cores(sampler) => sampler.len(),
            Self::Device { directions, .. } => directions.len(),
        }
    }

    /// What `make` makes of the visibility of each point, 0 or 1 for each direction, and of the rays traced for it: on all cores,
    /// in the order of the points. `scratch` makes buffers that are kept.
    ///
    /// # Errors
    /// What is wrong with the device.
    pub fn each<S, T: Send>(
        &self,
        points: &[&BakePoint],
        scratch: impl Fn() -> S + Sync + Send,
        make: impl Fn(&mut S, &[u8], u64) -> T + Sync + Send,
    ) -> Result<Vec<T>, BakeError> {
        match self {
            Self::Cores(sampler) => {
                let scratch = || (BoundaryTracer::default(), vec![0; sampler.len()], scratch());
                let one = |(tracer, visible, scratch): &mut (BoundaryTracer, Vec<u8>, S), point: &&BakePoint| {
                    let rays = sampler.sample(point, tracer, visible);
                    make(scratch, visible, rays)
                };
                Ok(points.par_iter().map_init(scratch, one).collect())
            }
            Self::Device { device, directions } => {
                let rows = rows_of(device.as_ref(), directions.len(), points)?;
                let scratch = || (vec![0; directions.len()], scratch());
                let one = |(visible, scratch): &mut (Vec<u8>, S), (point, row): (&&BakePoint, &Vec<u32>)| {
                    for (i, visible) in visible.iter_mut().enumerate() {
                        *visible = (row[i / 32] >> (i % 32)) as u8 & 1;
                    }
                    let is_traced = |d: &&Vec3| point.sides().contains(&point.side_of(**d));
                    make(scratch, visible, directions.iter().filter(is_traced).count() as u64)
                };
                Ok(points.par_iter().zip(&rows).map_init(scratch, one).collect())
            }
        }
    }
}

/// For each point the bits of what it sees, of all its sides.
fn rows_of(device: &dyn RayDevice, directions: usize, points: &[&BakePoint]) -> Result<Vec<Vec<u32>>, BakeError> {
    let at = |point: &BakePoint, side: Side| RayOrigin { origin: point.origin(side), half: point.half_of(side) };
    let of_point = |point: &&BakePoint| point.sides().iter().map(|&side| at(point, side)).collect::<Vec<_>>();
    let origins: Vec<RayOrigin> = points.iter().flat_map(of_point).collect();
    let open = device.open(&origins).map_err(BakeError::Device)?;
    let mut sides = open.chunks(directions.div_ceil(32));
    let row = |point: &&BakePoint| {
        let mut row = vec![0; directions.div_ceil(32)];
        for side in sides.by_ref().take(point.sides().len()) {
            row.iter_mut().zip(side).for_each(|(all, some)| *all |= some);
        }
        row
    };
    Ok(points.iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        test_scenes::{cuboid, floor, quad, scene_of},
        vertices::{points::BakePoints, sidedness::classify, visibility::EXHAUSTIVE},
    };
    use lapidary_core::{ray::DirectionSet, sphere::fibonacci_directions};

    /// A device that is this machine, with one scene.
    struct Emulated;

    struct Taken(Intersector, DirectionSet);

    /// The scene of the test, as a device takes it.
    fn scene() -> lapidary_core::scene::Scene {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.0, 1.5, 0.0), Vec3::splat(0.5)));
        let p = |x: f32, y: f32| Vec3::new(x, y, 1.7);
        triangles.extend(quad(p(-1.0, 0.5), p(1.0, 0.5), p(1.0, 2.0), p(-1.0, 2.0)));
        scene_of(&triangles)
    }

    impl RayDevices for Emulated {
        fn device(&self, _: &Intersector, directions: &[Vec3]) -> Result<Box<dyn RayDevice>, String> {
            match directions.len() {
                0 => Err("no room".into()),
                _ => Ok(Box::new(Taken(Intersector::new(&scene().mesh), DirectionSet::new(directions)))),
            }
        }
    }

    impl RayDevice for Taken {
        fn open(&self, origins: &[RayOrigin]) -> Result<Vec<u32>, String> {
            let row = |at: &RayOrigin| {
                let mut visible = vec![0; self.1.len()];
                self.0.trace_batch(at.origin, &self.1, |d| at.half.has(d), &mut visible);
                visible
                    .chunks(32)
                    .map(|bits| bits.iter().rev().fold(0, |word, &bit| word << 1 | u32::from(bit)))
                    .collect()
            };
            Ok(origins.iter().map(row).collect::<Vec<Vec<u32>>>().concat())
        }
    }

    #[test]
    fn points_see_the_same_on_a_device_and_on_the_cores() {
        let scene = scene();
        let points = BakePoints::new(&scene.mesh, &classify(&scene)).points;
        let points: Vec<&BakePoint> = points.iter().collect();
        assert!(points.iter().any(|p| p.two_sided) && points.iter().any(|p| !p.two_sided));
        let intersector = Intersector::new(&scene.mesh);
        let directions = fibonacci_directions(512);
        let seen = |devices: Option<&dyn RayDevices>| {
            let tracing = Tracing { lights_per_probe: EXHAUSTIVE, devices };
            let sampler = ManySampler::new(&intersector, &directions, tracing).unwrap();
            sampler.each(&points, || (), |(), visible, rays| (visible.to_vec(), rays)).unwrap()
        };
        let (cores, device) = (seen(None), seen(Some(&Emulated)));
        assert!(cores == device);
        assert!(cores[0] != cores[points.len() - 1], "negative control: another point");
        let tracing = Tracing { lights_per_probe: EXHAUSTIVE, devices: Some(&Emulated) };
        let refused = ManySampler::new(&intersector, &[], tracing);
        assert!(matches!(refused.err(), Some(BakeError::Device(reason)) if reason == "no room"));
    }
}
