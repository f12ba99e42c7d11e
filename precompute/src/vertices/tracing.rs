//! Visibility of all light samples from many bake points, on this machine's cores or on a device.

use super::{
    points::BakePoint,
    side::Side,
    visibility::{EXHAUSTIVE, Veils, VisibilitySampler},
};
use crate::{
    observer::{Event, Observer},
    warning::Warning,
};
use glam::Vec3;
use lapidary_core::ray::{BoundarySet, BoundaryTracer, Intersector, OPEN, RayDevice, RayDevices, RayOrigin};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Tracing method and device.
#[derive(Clone, Copy)]
pub struct Tracing<'a> {
    /// Lights per probe, see [`VisibilitySampler::new`].
    pub lights_per_probe: usize,
    /// Devices that trace instead of the cores. Results differ only for rays along edges.
    pub devices: Option<&'a dyn RayDevices>,
    /// Learns of a device that fails.
    pub observer: &'a dyn Observer,
}

/// Traces from many points: on a device if there is one, and on the cores where it fails.
pub struct ManySampler<'a> {
    scene: &'a Intersector,
    directions: Vec<Vec3>,
    lights_per_probe: usize,
    device: Option<DeviceSampler<'a>>,
    /// Made where the cores trace.
    cores: OnceLock<VisibilitySampler<'a>>,
    observer: &'a dyn Observer,
}

/// A scene on a device, which traces every light.
struct DeviceSampler<'a> {
    device: Box<dyn RayDevice>,
    /// Boundaries to follow in the traced light, so that the device sees no more than the cores would; `None` uses all light.
    boundaries: Option<BoundarySet>,
    /// Thin surfaces, which the device lacks.
    veils: Veils<'a>,
}

impl<'a> ManySampler<'a> {
    /// For any unit directions in the given order.
    pub fn new(scene: &'a Intersector, directions: &[Vec3], tracing: Tracing<'a>) -> Self {
        let Tracing { lights_per_probe, devices, observer } = tracing;
        let mut sampler = Self {
            scene,
            directions: directions.to_vec(),
            lights_per_probe,
            device: None,
            cores: OnceLock::new(),
            observer,
        };
        match devices.map_or(Ok(None), |devices| devices.device(scene, directions)) {
            Ok(device) => sampler.device = device.map(|device| DeviceSampler::new(device, &sampler)),
            Err(reason) => sampler.go_on_with_cores(reason),
        }
        sampler
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// The device, unless it failed.
    fn device(&self) -> Option<&DeviceSampler<'a>> {
        self.device.as_ref().filter(|_| self.cores.get().is_none())
    }

    /// Whether a device traces, or did until it failed.
    pub fn is_on_device(&self) -> bool {
        self.device.is_some()
    }

    /// Says why a device does not trace any more.
    fn go_on_with_cores(&self, reason: String) {
        self.cores();
        self.observer.event(Event::Warning { message: Warning::DeviceFailed { reason } });
    }

    fn cores(&self) -> &VisibilitySampler<'a> {
        let make = || VisibilitySampler::of_directions(self.scene, &self.directions, self.lights_per_probe);
        self.cores.get_or_init(make)
    }

    /// Applies `make` to the visibility of each point, 0 to [`OPEN`] for each direction, and to its traced rays: on all cores, in
    /// point order. `scratch` creates buffers that are reused.
    pub fn each<S, T: Send>(
        &self,
        points: &[&BakePoint],
        scratch: impl Fn() -> S + Sync + Send,
        make: impl Fn(&mut S, &[u8], u64) -> T + Sync + Send,
    ) -> Vec<T> {
        let scratch = || (BoundaryTracer::default(), vec![0; self.len()], scratch());
        type Buffers<S> = (BoundaryTracer, Vec<u8>, S);
        if let Some(device) = self.device() {
            match device.trace(points) {
                Ok(traced) => {
                    let one = |(tracer, visible, scratch): &mut Buffers<S>,
                               (point, rows): (&&BakePoint, &Vec<&[u32]>)| {
                        let rays = device.sample(point, (rows, &self.directions), tracer, visible);
                        make(scratch, visible, rays)
                    };
                    let rows = device.rows(&traced, points, self.len());
                    return points.par_iter().zip(&rows).map_init(scratch, one).collect();
                }
                Err(reason) => self.go_on_with_cores(reason),
            }
        }
        let sampler = self.cores();
        let one = |(tracer, visible, scratch): &mut Buffers<S>, point: &&BakePoint| {
            let rays = sampler.sample(point, tracer, visible);
            make(scratch, visible, rays)
        };
        points.par_iter().map_init(scratch, one).collect()
    }
}

impl<'a> DeviceSampler<'a> {
    fn new(device: Box<dyn RayDevice>, of: &ManySampler<'a>) -> Self {
        let (directions, per_probe) = (&of.directions, of.lights_per_probe);
        Self {
            device,
            boundaries: (per_probe != EXHAUSTIVE).then(|| BoundarySet::new(directions, per_probe)),
            veils: Veils::new(of.scene, directions),
        }
    }

    /// Words of visibility bits for each side of the points in order.
    fn trace(&self, points: &[&BakePoint]) -> Result<Vec<u32>, String> {
        let at = |point: &BakePoint, side: Side| RayOrigin { origin: point.origin(side), half: point.half_of(side) };
        let of_point = |point: &&BakePoint| point.sides().iter().map(|&side| at(point, side)).collect::<Vec<_>>();
        let origins: Vec<RayOrigin> = points.iter().flat_map(of_point).collect();
        self.device.open(&origins)
    }

    /// The words of each point's sides, with bits for so many directions.
    fn rows<'t>(&self, traced: &'t [u32], points: &[&BakePoint], directions: usize) -> Vec<Vec<&'t [u32]>> {
        let mut rows = traced.chunks(directions.div_ceil(32));
        points.iter().map(|point| rows.by_ref().take(point.sides().len()).collect()).collect()
    }

    /// Sets `visible` from the words of a point's sides for the directions. Returns the traced rays.
    fn sample(
        &self,
        point: &BakePoint,
        (rows, directions): (&[&[u32]], &[Vec3]),
        tracer: &mut BoundaryTracer,
        visible: &mut [u8],
    ) -> u64 {
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
        directions.iter().filter(is_traced).count() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        observer::Silent,
        test_scenes::{cuboid, floor, quad, scene_of},
        vertices::{points::BakePoints, sidedness::classify, visibility::FINEST},
    };
    use lapidary_core::{ray::DirectionSet, sphere::fibonacci_directions};
    use std::sync::{
        Mutex,
        atomic::{AtomicU32, Ordering::Relaxed},
    };

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
            ManySampler::new(&intersector, directions, Tracing { lights_per_probe, devices, observer: &Silent })
        };
        let devices: Option<&dyn RayDevices> = Some(&Emulated);
        let seen = |lights_per_probe, devices| {
            let sampler = sampler(&directions, lights_per_probe, devices);
            assert_eq!(sampler.is_on_device(), devices.is_some());
            sampler.each(&points, || (), |(), visible, rays| (visible.to_vec(), rays))
        };
        let all = seen(EXHAUSTIVE, None);
        assert!(all == seen(EXHAUSTIVE, devices));
        let visible = |of: Vec<(Vec<u8>, u64)>| of.into_iter().map(|(visible, _)| visible).collect::<Vec<_>>();
        // Probes for few and for many lights; the latter miss some visibility.
        for lights_per_probe in [FINEST, 128] {
            assert!(visible(seen(lights_per_probe, None)) == visible(seen(lights_per_probe, devices)));
        }
        assert!(visible(seen(128, devices)) != visible(all), "negative control: both miss the same");
        assert!(!sampler(&directions[..1], EXHAUSTIVE, devices).is_on_device(), "the cores trace it");
    }

    /// A device without room, or one that is lost at its second piece of work.
    struct Failing {
        has_room: bool,
    }

    struct Lost(Taken, AtomicU32);

    impl RayDevices for Failing {
        fn device(&self, _: &Intersector, directions: &[Vec3]) -> Result<Option<Box<dyn RayDevice>>, String> {
            let taken = Taken(Intersector::new(&scene().mesh), DirectionSet::new(directions));
            if self.has_room { Ok(Some(Box::new(Lost(taken, AtomicU32::new(0))))) } else { Err("no room".into()) }
        }
    }

    impl RayDevice for Lost {
        fn open(&self, origins: &[RayOrigin]) -> Result<Vec<u32>, String> {
            if self.1.fetch_add(1, Relaxed) == 0 { self.0.open(origins) } else { Err("unplugged".into()) }
        }
    }

    /// The warnings that it got.
    #[derive(Default)]
    struct Told(Mutex<Vec<String>>);

    impl Observer for Told {
        fn event(&self, event: Event) {
            if let Event::Warning { message } = event {
                self.0.lock().unwrap().push(message.to_string());
            }
        }
    }

    #[test]
    fn the_cores_go_on_where_a_device_fails_and_say_so_once() {
        let scene = scene();
        let points = BakePoints::new(&scene.mesh, &classify(&scene)).points;
        let points: Vec<&BakePoint> = points.iter().collect();
        let intersector = Intersector::new(&scene.mesh);
        let directions = fibonacci_directions(256);
        for (has_room, reason) in [(true, "unplugged"), (false, "no room")] {
            let (told, devices) = (Told::default(), Failing { has_room });
            let tracing = |devices| Tracing { lights_per_probe: FINEST, devices, observer: &told };
            let seen = |sampler: &ManySampler| sampler.each(&points, || (), |(), visible, _| visible.to_vec());
            let failing = ManySampler::new(&intersector, &directions, tracing(Some(&devices)));
            assert_eq!(failing.is_on_device(), has_room);
            let cores = seen(&ManySampler::new(&intersector, &directions, tracing(None)));
            assert!((0..3).all(|_| seen(&failing) == cores), "{reason}");
            assert!(failing.device().is_none() && failing.is_on_device() == has_room, "it may have traced");
            let warnings = told.0.lock().unwrap();
            assert!(warnings.len() == 1 && warnings[0].contains(reason), "{warnings:?}");
        }
    }
}
