//! Visibility of all light samples from many bake points, on this machine's cores or on a device.

use super::{
    points::BakePoint,
    until_failure::UntilFailure,
    visibility::{EXHAUSTIVE, Veils, VisibilitySampler},
};
use crate::observer::Observer;
use glam::Vec3;
use lapidary_core::ray::{
    BoundarySet, BoundaryTracer, Intersector, OPEN, OpenRays, RayDevice, RayDevices, RayDirections, RayOrigin,
};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Points that the cores trace between checks for cancellation.
pub const POINTS_AT_A_TIME: usize = 256;

/// Points of one piece of work for a device. The cores use what they see while the next piece is traced.
const POINTS_PER_PIECE: usize = 1024;

/// Pieces of work of a device between checks for cancellation.
const PIECES_AT_A_TIME: usize = 4;

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
    device: UntilFailure<'a, Box<dyn RayDevice>>,
    /// Thin surfaces, which a device lacks.
    veils: Veils<'a>,
    /// Made where the cores trace.
    cores: OnceLock<VisibilitySampler<'a>>,
}

impl<'a> ManySampler<'a> {
    /// For any unit directions in the given order.
    pub fn new(scene: &'a Intersector, directions: &[Vec3], tracing: Tracing<'a>) -> Self {
        let Tracing { lights_per_probe, devices, observer } = tracing;
        let device = devices.map_or(Ok(None), |devices| match lights_per_probe {
            EXHAUSTIVE => devices.device(scene, RayDirections::All(directions)),
            _ => devices.device(scene, RayDirections::Along(&BoundarySet::new(directions, lights_per_probe))),
        });
        Self {
            scene,
            directions: directions.to_vec(),
            lights_per_probe,
            device: UntilFailure::new(device, observer),
            veils: Veils::new(scene, directions),
            cores: OnceLock::new(),
        }
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// Whether a device traces, or did until it failed.
    pub fn is_on_device(&self) -> bool {
        self.device.has_traced()
    }

    /// Number of points to trace between checks for cancellation.
    pub fn points_at_a_time(&self) -> usize {
        self.device.get().map_or(POINTS_AT_A_TIME, |_| PIECES_AT_A_TIME * POINTS_PER_PIECE)
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
        let mut results = Vec::with_capacity(points.len());
        let mut pieces = points.chunks(POINTS_PER_PIECE).peekable();
        let mut open = pieces.peek().and_then(|first| self.open_from(first));
        while let Some(piece) = pieces.next() {
            let make_all = || self.make_all(piece, open.as_ref(), &scratch, &make);
            let (made, next) = rayon::join(make_all, || pieces.peek().and_then(|next| self.open_from(next)));
            results.extend(made);
            open = next;
        }
        results
    }

    /// What a device finds from the sides of points in order; `None` if the cores trace.
    fn open_from(&self, points: &[&BakePoint]) -> Option<OpenRays> {
        let origins = origins_of(points.iter().copied());
        let words = origins.len() * self.len().div_ceil(32);
        self.device.run(|device| {
            let open = device.open(&origins)?;
            let is_whole = (open.rows.len(), open.counts.len()) == (words, origins.len());
            if is_whole { Ok(open) } else { Err("it gave fewer results than asked for".into()) }
        })
    }

    /// The results for points, from what a device found or by the cores.
    fn make_all<S, T: Send>(
        &self,
        points: &[&BakePoint],
        open: Option<&OpenRays>,
        scratch: impl Fn() -> S + Sync + Send,
        make: impl Fn(&mut S, &[u8], u64) -> T + Sync + Send,
    ) -> Vec<T> {
        let scratch = || (BoundaryTracer::default(), vec![0; self.len()], scratch());
        type Buffers<S> = (BoundaryTracer, Vec<u8>, S);
        if let Some(open) = open {
            let one = |(_, visible, scratch): &mut Buffers<S>, (point, of_point): (&&BakePoint, OpenFrom)| {
                self.see(point, of_point, visible);
                make(scratch, visible, of_point.rays)
            };
            let seen = open_from_each(open, self.len(), points.iter().copied());
            return points.par_iter().zip(seen).map_init(scratch, one).collect();
        }
        let cores = self.cores();
        let one = |(tracer, visible, scratch): &mut Buffers<S>, point: &&BakePoint| {
            let rays = cores.sample(point, tracer, visible);
            make(scratch, visible, rays)
        };
        points.par_iter().map_init(scratch, one).collect()
    }

    /// Sets `visible` to what a device found from a point.
    fn see(&self, point: &BakePoint, open: OpenFrom, visible: &mut [u8]) {
        visible.fill(0);
        for row in open.rows.chunks(self.len().div_ceil(32)) {
            visible.iter_mut().enumerate().for_each(|(i, v)| *v |= OPEN * ((row[i / 32] >> (i % 32)) as u8 & 1));
        }
        self.veils.dim(point, visible);
    }
}

/// Where a device traces from: each side of the points in order.
pub fn origins_of<'p>(points: impl IntoIterator<Item = &'p BakePoint>) -> Vec<RayOrigin> {
    let of_side = |point: &BakePoint, side| RayOrigin { origin: point.origin(side), half: point.half_of(side) };
    points.into_iter().flat_map(|point| point.sides().iter().map(move |&side| of_side(point, side))).collect()
}

/// What a device found from a point.
#[derive(Clone, Copy)]
struct OpenFrom<'t> {
    /// The rows of its sides.
    rows: &'t [u32],
    /// The rays traced from all of them.
    rays: u64,
}

/// What a device found from [`origins_of`] points, point by point.
fn open_from_each<'t, 'p>(
    open: &'t OpenRays,
    directions: usize,
    points: impl Iterator<Item = &'p BakePoint>,
) -> Vec<OpenFrom<'t>> {
    let (mut rows, mut counts) = (&open.rows[..], &open.counts[..]);
    let mut of_point = |point: &BakePoint| {
        let sides = point.sides().len();
        let own = rows.split_off(..sides * directions.div_ceil(32)).unwrap_or_default();
        let counted = counts.split_off(..sides).unwrap_or_default();
        OpenFrom { rows: own, rays: counted.iter().copied().map(u64::from).sum() }
    };
    points.map(&mut of_point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        observer::Silent,
        test_devices::{Emulated, Warnings},
        test_scenes::{cuboid, floor, quad, scene_of},
        vertices::{points::BakePoints, sidedness::classify, visibility::FINEST},
    };
    use lapidary_core::{scene::Scene, sphere::fibonacci_directions};

    fn scene() -> Scene {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.0, 1.5, 0.0), Vec3::splat(0.5)));
        let p = |x: f32, y: f32| Vec3::new(x, y, 1.7);
        triangles.extend(quad(p(-1.0, 0.5), p(1.0, 0.5), p(1.0, 2.0), p(-1.0, 2.0)));
        scene_of(&triangles)
    }

    /// Points of the scene, one- and two-sided, over and over.
    fn points(scene: &Scene, count: usize) -> Vec<BakePoint> {
        let points = BakePoints::new(&scene.mesh, &classify(scene)).points;
        assert!(points.iter().any(|p| p.two_sided) && points.iter().any(|p| !p.two_sided));
        points.into_iter().cycle().take(count).collect()
    }

    #[test]
    fn points_see_the_same_on_a_device_and_on_the_cores() {
        let scene = scene();
        let points = points(&scene, 40);
        let points: Vec<&BakePoint> = points.iter().collect();
        let intersector = Intersector::new(&scene.mesh);
        let directions = fibonacci_directions(512);
        let emulated = Emulated::lasting();
        let sampler = |directions: &[Vec3], lights_per_probe, devices| {
            ManySampler::new(&intersector, directions, Tracing { lights_per_probe, devices, observer: &Silent })
        };
        let devices: Option<&dyn RayDevices> = Some(&emulated);
        let seen = |lights_per_probe, devices| {
            let sampler = sampler(&directions, lights_per_probe, devices);
            assert_eq!(sampler.is_on_device(), devices.is_some());
            sampler.each(&points, || (), |(), visible, rays| (visible.to_vec(), rays))
        };
        let all = seen(EXHAUSTIVE, None);
        // Probes for few and for many lights; the latter miss some visibility.
        for lights_per_probe in [EXHAUSTIVE, FINEST, 128] {
            let begun = emulated.begun();
            assert!(seen(lights_per_probe, None) == seen(lights_per_probe, devices));
            assert_eq!(emulated.begun(), begun + 1, "the device traces");
        }
        let visible = |of: &[(Vec<u8>, u64)]| of.iter().map(|(visible, _)| visible.clone()).collect::<Vec<_>>();
        assert!(visible(&seen(128, devices)) != visible(&all), "negative control: both miss the same");
        let rays = |of: &[(Vec<u8>, u64)]| of.iter().map(|(_, rays)| rays).sum::<u64>();
        assert!(
            rays(&seen(128, devices)) < rays(&all),
            "negative control: a device traces fewer rays along boundaries"
        );
        assert!(!sampler(&directions[..1], EXHAUSTIVE, devices).is_on_device(), "the cores trace it");
    }

    #[test]
    fn pieces_of_work_keep_the_order_of_points() {
        let scene = scene();
        let points = points(&scene, 2 * POINTS_PER_PIECE + 3);
        let points: Vec<&BakePoint> = points.iter().collect();
        let intersector = Intersector::new(&scene.mesh);
        let directions = fibonacci_directions(40);
        let emulated = Emulated::lasting();
        let seen = |devices, points: &[&BakePoint]| {
            let tracing = Tracing { lights_per_probe: FINEST, devices, observer: &Silent };
            let sampler = ManySampler::new(&intersector, &directions, tracing);
            sampler.each(points, || (), |(), visible, rays| (visible.to_vec(), rays))
        };
        let cores = seen(None, &points);
        assert!(seen(Some(&emulated), &points) == cores);
        assert_eq!(emulated.begun(), 3);
        let turned: Vec<&BakePoint> = points.iter().copied().skip(1).chain([points[0]]).collect();
        assert!(seen(Some(&emulated), &turned) != cores, "negative control: another order");
    }

    #[test]
    fn the_cores_go_on_where_a_device_fails_and_say_so_once() {
        let scene = scene();
        let points = points(&scene, 40);
        let points: Vec<&BakePoint> = points.iter().collect();
        let intersector = Intersector::new(&scene.mesh);
        let directions = fibonacci_directions(256);
        // Lost at its second piece of work, or without room.
        for (devices, reason) in [(Emulated::lost_after(1), "unplugged"), (Emulated::full(), "no room")] {
            let warnings = Warnings::default();
            let tracing = |devices| Tracing { lights_per_probe: FINEST, devices, observer: &warnings };
            let seen = |sampler: &ManySampler| sampler.each(&points, || (), |(), visible, _| visible.to_vec());
            let failing = ManySampler::new(&intersector, &directions, tracing(Some(&devices)));
            let has_room = reason == "unplugged";
            assert_eq!(failing.is_on_device(), has_room);
            let cores = seen(&ManySampler::new(&intersector, &directions, tracing(None)));
            assert!((0..3).all(|_| seen(&failing) == cores), "{reason}");
            assert!(failing.is_on_device() == has_room, "it may have traced");
            assert_eq!(devices.begun(), 2 * usize::from(has_room), "it is not asked again");
            assert!(warnings.only_one().contains(reason));
        }
    }
}
