//! Devices emulated by this machine, some of which fail; and what is told of it.

use crate::observer::{Event, Observer};
use glam::Vec3;
use lapidary_core::{
    ray::{
        BoundarySet, BoundaryTracer, DirectionSet, Fan, FanDevice, Hit, Intersector, OPEN, OpenRays, RayDevice,
        RayDevices, RayDirections, RayOrigin, in_eights,
    },
    test_scenes::scene_of,
};
use std::sync::{
    Arc, Mutex,
    atomic::{AtomicUsize, Ordering::Relaxed},
};

/// Emulated devices, which leave a single direction to the cores.
pub struct Emulated {
    has_room: bool,
    is_blind: bool,
    work: Arc<Work>,
}

/// Pieces of work.
struct Work {
    done: AtomicUsize,
    /// Number after which devices are lost.
    most: usize,
}

impl Work {
    fn begin(&self) -> Result<(), String> {
        if self.done.fetch_add(1, Relaxed) < self.most { Ok(()) } else { Err("unplugged".into()) }
    }
}

impl Emulated {
    /// Devices that are lost after some pieces of work.
    pub fn lost_after(most: usize) -> Self {
        Self { has_room: true, is_blind: false, work: Arc::new(Work { done: AtomicUsize::new(0), most }) }
    }

    /// Devices that do all work.
    pub fn lasting() -> Self {
        Self::lost_after(usize::MAX)
    }

    /// Devices without room.
    pub fn full() -> Self {
        Self { has_room: false, ..Self::lasting() }
    }

    /// Devices that take no triangle of any scene.
    pub fn blind() -> Self {
        Self { is_blind: true, ..Self::lasting() }
    }

    /// Number of pieces of work that were begun.
    pub fn begun(&self) -> usize {
        self.work.done.load(Relaxed)
    }

    fn upload(&self, scene: &Intersector) -> Result<Intersector, String> {
        let solid = if self.is_blind { &[] } else { scene.hierarchy().1 };
        if self.has_room { Ok(Intersector::new(&scene_of(solid).mesh)) } else { Err("no room".into()) }
    }
}

impl RayDevices for Emulated {
    fn device(&self, scene: &Intersector, directions: RayDirections) -> Result<Option<Box<dyn RayDevice>>, String> {
        let directions = match directions {
            RayDirections::All([_]) => return Ok(None),
            RayDirections::All(directions) => Directions::All(DirectionSet::new(directions)),
            RayDirections::Along(set) => Directions::Along(set.clone()),
        };
        Ok(Some(Box::new(EmulatedRays { scene: self.upload(scene)?, directions, work: self.work.clone() })))
    }

    fn fans(&self, scene: &Intersector, directions: &[Vec3]) -> Result<Option<Box<dyn FanDevice>>, String> {
        let (scene, directions) = (self.upload(scene)?, directions.to_vec());
        Ok(Some(Box::new(EmulatedFans { scene, directions, work: self.work.clone() })))
    }
}

struct EmulatedRays {
    scene: Intersector,
    directions: Directions,
    work: Arc<Work>,
}

enum Directions {
    All(DirectionSet),
    Along(BoundarySet),
}

impl EmulatedRays {
    /// The row of an origin, and its rays.
    fn from(&self, at: &RayOrigin) -> (Vec<u32>, u32) {
        let RayOrigin { origin, half } = at;
        let (mut visible, rays);
        match &self.directions {
            Directions::All(set) => {
                visible = vec![0; set.len()];
                rays = self.scene.trace_batch(*origin, set, |_, d| half.has(d), &mut visible);
            }
            Directions::Along(set) => {
                visible = vec![0; set.len()];
                rays = BoundaryTracer::default().trace(&self.scene, *origin, set, half, &mut visible);
            }
        }
        let word = |bits: &[u8]| bits.iter().rev().fold(0, |word, &bit| word << 1 | u32::from(bit / OPEN));
        (visible.chunks(32).map(word).collect(), rays as u32)
    }
}

impl RayDevice for EmulatedRays {
    fn open(&self, origins: &[RayOrigin]) -> Result<OpenRays, String> {
        self.work.begin()?;
        let (rows, counts): (Vec<Vec<u32>>, Vec<u32>) = origins.iter().map(|at| self.from(at)).unzip();
        Ok(OpenRays { rows: rows.concat(), counts })
    }
}

struct EmulatedFans {
    scene: Intersector,
    directions: Vec<Vec3>,
    work: Arc<Work>,
}

impl FanDevice for EmulatedFans {
    fn first_hits(&self, fans: &[Fan]) -> Result<Vec<Option<Hit>>, String> {
        self.work.begin()?;
        let hits = |fan: &Fan| {
            let turned = self.directions.iter().map(|&direction| fan.frame * direction);
            let mut hits = self.scene.closest_hits(fan.origin, &in_eights(turned)).concat();
            hits.truncate(self.directions.len());
            hits
        };
        Ok(fans.iter().flat_map(hits).collect())
    }
}

/// Keeps warnings.
#[derive(Default)]
pub struct Warnings(Mutex<Vec<String>>);

impl Warnings {
    /// The only warning that it got.
    pub fn only_one(self) -> String {
        let mut warnings = self.0.into_inner().unwrap();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        warnings.remove(0)
    }
}

impl Observer for Warnings {
    fn event(&self, event: Event) {
        if let Event::Warning { message } = event {
            self.0.lock().unwrap().push(message.to_string());
        }
    }
}
