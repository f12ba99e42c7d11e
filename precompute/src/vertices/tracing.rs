//! Visibility of all light samples from many bake points, on this machine's cores or on a device.

use super::{
    points::BakePoint,
    side::Side,
    visibility::{EXHAUSTIVE, Veils, VisibilitySampler},
};
use crate::errors::BakeError;
use glam::Vec3;
use lapidary_core::ray::{BoundarySet, BoundaryTracer, Intersector, OPEN, RayDevice, RayDevices, RayOrigin};
use rayon::prelude::*;

/// Tracing method and device.
#[derive(Clone, Copy)]
pub struct Tracing<'a> {
    /// Lights per probe, see [`VisibilitySampler::new`].
    pub lights_per_probe: usize,
    /// Devices that trace instead of the cores. Results differ only for rays along edges.
    pub devices: Option<&'a dyn RayDevices>,
}

/// Cores or device.
pub enum ManySampler<'a> {
    /// The cores.
    Cores(VisibilitySampler<'a>),
    /// A device.
    Device(DeviceSampler<'a>),
}

/// A scene on a device, which traces every light.
pub struct DeviceSampler<'a> {
    device: Box<dyn RayDevice>,
    directions: Vec<Vec3>,
    /// Boundaries to follow in the traced light, so that the device sees no more than the cores would; `None` uses all light.
    boundaries: Option<BoundarySet>,
    /// Thin surfaces, which the device lacks.
    veils: Veils<'a>,
}

impl<'a> ManySampler<'a> {
    /// For any unit directions in the given order.
    ///
    /// # Errors
    /// A device error.
    pub fn new(scene: &'a Intersector, directions: &[Vec3], tracing: Tracing) -> Result<Self, BakeError> {
        let device = match tracing.devices {
            Some(devices) => devices.device(scene, directions).map_err(BakeError::Device)?,
            None => None,
        };
        let per_probe = tracing.lights_per_probe;
        Ok(match device {
            None => Self::Cores(VisibilitySampler::of_directions(scene, directions, per_probe)),
            Some(device) => Self::Device(DeviceSampler {
                device,
                directions: directions.to_vec(),
                boundaries: (per_probe != EXHAUSTIVE).then(|| BoundarySet::new(directions, per_probe)),
                veils: Veils::new(scene, directions),
            }),
        })
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        match self {
            Self::Cores(sampler) => sampler.len(),
            Self::Device(sampler) => sampler.directions.len(),
        }
    }

    /// Whether a device traces.
    pub fn is_on_device(&self) -> bool {
        matches!(self, Self::Device(_))
    }

    /// Applies `make` to the visibility of each point, 0 to [`OPEN`] for each direction, and to its traced rays: on all cores, in
    /// point order. `scratch` creates buffers that are reused.
    ///
    /// # Errors
    /// A device error.
    pub fn each<S, T: Send>(
        &self,
        points: &[&BakePoint],
        scratch: impl Fn() -> S + Sync + Send,
        make: impl Fn(&mut S, &[u8], u64) -> T + Sync + Send,
    ) -> Result<Vec<T>, BakeError> {
        let scratch = || (BoundaryTracer::default(), vec![0; self.len()], scratch());
        type Buffers<S> = (BoundaryTracer, Vec<u8>, S);
        match self {
            Self::Cores(sampler) => {
                let one = |(tracer, visible, scratch): &mut Buffers<S>, point: &&BakePoint| {
                    let rays = sampler.sample(point, tracer, visible);
                    make(scratch, visible, rays)
                };
                Ok(points.par_iter().map_init(scratch, one).collect())
            }
            Self::Device(sampler) => {
                let traced = sampler.trace(points)?;
                let one = |(tracer, visible, scratch): &mut Buffers<S>, (point, rows): (&&BakePoint, &Vec<&[u32]>)| {
                    let rays = sampler.sample(point, rows, tracer, visible);
                    make(scratch, visible, rays)
                };
                let rows = sampler.rows(&traced, points);
                Ok(points.par_iter().zip(&rows).map_init(scratch, one).collect())
            }
        }
    }
}

impl DeviceSampler<'_> {
    /// Words of visibility bits for each side of the points in order.
    fn trace(&self, points: &[&BakePoint]) -> Result<Vec<u32>, BakeError> {
        let at = |point: &BakePoint, side: Side| RayOrigin { origin: point.origin(side), half: point.half_of(side) };
        let of_point = |point: &&BakePoint| point.sides().iter().map(|&side| at(point, side)).collect::<Vec<_>>();
        let origins: Vec<RayOrigin> = points.iter().flat_map(of_point).collect();
        self.device.open(&origins).map_err(BakeError::Device)
    }

    /// The words of each point's sides.
    fn rows<'t>(&self, traced: &'t [u32], points: &[&BakePoint]) -> Vec<Vec<&'t [u32]>> {
        let mut rows = traced.chunks(self.directions.len().div_ceil(32));
        points.iter().map(|point| rows.by_ref().take(point.sides().len()).collect()).collect()
    }

    /// Sets `visible` from the words of a point's sides. Returns the traced rays.
    fn sample(&self, point: &BakePoint, rows: &[&[u32]], tracer: &mut BoundaryTracer, visible: &mut [u8]) -> u64 {
        visible.fill(0);
        for (&side, open) in point.sides().iter().zip(rows) {
            match &self.boundaries {
                Some(set) => tracer.follow(open, set, &point.half_of(side), visible),
                None => visible
                    .iter_mut()
                    .enumerate()
                    .for_each(|(i, v)| *v |= OPEN * ((open[i / 32] >> (i % 32)) as u8 & 1)),
            }
        }
        self.veils.dim(point, visible);
        let is_traced = |d: &&Vec3| point.sides().contains(&point.side_of(**d));
        self.directions.iter().filter(is_traced).count() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        test_scenes::{cuboid, floor, quad, scene_of},
        vertices::{points::BakePoints, sidedness::classify, visibility::FINEST},
    };
    use lapidary_core::{ray::DirectionSet, sphere::fibonacci_directions};

    /// A device emulated by this machine, with one scene.
    struct Emulated;

    struct Taken(Intersector, DirectionSet);

    /// The test's scene as passed to a device.
    fn scene() -> lapidary_core::scene::Scene {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.0, 1.5, 0.0), Vec3::splat(0.5)));
        let p = |x: f32, y: f32| Vec3::new(x, y, 1.7);
        triangles.extend(quad(p(-1.0, 0.5), p(1.0, 0.5), p(1.0, 2.0), p(-1.0, 2.0)));
        scene_of(&triangles)
    }

    impl RayDevices for Emulated {
        fn device(&self, _: &Intersector, directions: &[Vec3]) -> Result<Option<Box<dyn RayDevice>>, String> {
            match directions.len() {
                0 => Err("no room".into()),
                1 => Ok(None),
                _ => Ok(Some(Box::new(Taken(Intersector::new(&scene().mesh), DirectionSet::new(directions))))),
            }
        }
    }

    impl RayDevice for Taken {
        fn open(&self, origins: &[RayOrigin]) -> Result<Vec<u32>, String> {
            let row = |at: &RayOrigin| {
                let mut visible = vec![0; self.1.len()];
                self.0.trace_batch(at.origin, &self.1, |_, d| at.half.has(d), &mut visible);
                visible
                    .chunks(32)
                    .map(|bits| bits.iter().rev().fold(0, |word, &bit| word << 1 | u32::from(bit / OPEN)))
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
        let sampler = |directions: &[Vec3], lights_per_probe, devices| {
            ManySampler::new(&intersector, directions, Tracing { lights_per_probe, devices })
        };
        let devices: Option<&dyn RayDevices> = Some(&Emulated);
        let seen = |lights_per_probe, devices| {
            let sampler = sampler(&directions, lights_per_probe, devices).unwrap();
            assert_eq!(sampler.is_on_device(), devices.is_some());
            sampler.each(&points, || (), |(), visible, rays| (visible.to_vec(), rays)).unwrap()
        };
        let all = seen(EXHAUSTIVE, None);
        assert!(all == seen(EXHAUSTIVE, devices));
        let visible = |of: Vec<(Vec<u8>, u64)>| of.into_iter().map(|(visible, _)| visible).collect::<Vec<_>>();
        // Probes for few and for many lights; the latter miss some visibility.
        for lights_per_probe in [FINEST, 128] {
            assert!(visible(seen(lights_per_probe, None)) == visible(seen(lights_per_probe, devices)));
        }
        assert!(visible(seen(128, devices)) != visible(all), "negative control: both miss the same");
        let refused = sampler(&[], EXHAUSTIVE, devices);
        assert!(matches!(refused.err(), Some(BakeError::Device(reason)) if reason == "no room"));
        assert!(!sampler(&directions[..1], EXHAUSTIVE, devices).unwrap().is_on_device(), "the cores trace it");
    }
}
