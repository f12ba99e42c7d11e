//! Rays on the GPU for bakes: which directions meet nothing, from many origins at a time. Twin of
//! [`Intersector::trace_batch`], and of [`BoundaryTracer::trace`](lapidary_core::ray::BoundaryTracer::trace) along boundaries. The
//! walk itself is `shaders/traverse.wgsl`, for other compute passes too.

use super::{
    adapter::GpuDevice,
    boundaries,
    box_hierarchy::BoxHierarchy,
    buffers::{storage, uniform, written},
    compute::{Compute, SharedDevice},
    fans::GpuFans,
    kernels::{BOUNDARIES, BoundaryWork, RAYS, RayWork},
    layout,
    readback::read_words,
};
use crate::{error::BackendError, remedy::Remedy};
use bytemuck::Zeroable;
use glam::Vec3;
use lapidary_core::ray::{
    BoundarySet, FanDevice, Intersector, OpenRays, RayDevice, RayDevices, RayDirections, RayOrigin,
};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// Directions of all origins of one piece of work, so that a desktop stays alive and a bake can be cancelled. About half of them
/// are traced.
const DIRECTIONS_AT_A_TIME: usize = 1 << 21;

/// The same along boundaries, where one of six to ten is traced.
const ALONG_BOUNDARIES_AT_A_TIME: usize = 1 << 23;

/// Most workgroups along a dimension, by WebGPU's default limits.
const MOST_WORKGROUPS: usize = 65_535;

/// Directions of a workgroup, as in the shaders.
const DIRECTIONS_PER_GROUP: u32 = 64;

/// An adapter that traces rays.
pub struct GpuRays {
    /// Whether a scene that it does not take is an error for the caller, or left to the cores.
    is_asked_for: bool,
    device: SharedDevice,
}

impl GpuRays {
    /// On a device. Whether a scene that it does not take is an error, or left to the cores, is for the caller to say.
    ///
    /// # Errors
    /// A driver that refuses.
    pub fn on(device: &SharedDevice, is_asked_for: bool) -> Result<Self, BackendError> {
        device.ray_pipeline(&RAYS, &RayWork::LAYOUT)?;
        Ok(Self { is_asked_for, device: device.clone() })
    }

    /// The fastest adapter that is more than an emulation on the processor, if there is one that works. Scenes that it does not
    /// take are left to the cores.
    pub fn of_hardware() -> Option<Self> {
        let Compute::Device(device) = Compute::of_hardware() else { return None };
        Self::on(&device, false).ok()
    }

    fn scene(&self, scene: &Intersector, directions: RayDirections) -> Result<GpuRayScene, BackendError> {
        let gpu = self.device.gpu.clone();
        let hierarchy = self.device.hierarchy(scene)?;
        let work = match directions {
            RayDirections::All(directions) => self.all(directions),
            RayDirections::Along(set) => self.along(set),
        }?;
        gpu.check()?;
        Ok(GpuRayScene { gpu, hierarchy, work })
    }

    fn all(&self, directions: &[Vec3]) -> Result<RayProgram, BackendError> {
        let gpu = &self.device.gpu;
        let words = directions.len().div_ceil(32);
        let results = RowsOfOrigins::new(gpu, words, origins_at_a_time(gpu, DIRECTIONS_AT_A_TIME, directions.len(), 0));
        let uniforms = layout::RayUniforms { directions: directions.len() as u32, words: words as u32 };
        let uniforms = uniform(gpu, "uniforms of rays", bytemuck::bytes_of(&uniforms));
        let toward: Vec<[f32; 4]> = directions.iter().map(|d| d.extend(0.0).to_array()).collect();
        let toward = storage(gpu, "directions of rays", bytemuck::cast_slice(&toward));
        let RowsOfOrigins { origins, open, .. } = &results;
        let work = RayWork { rays: &uniforms, directions: &toward, origins, open_words: open }.bind(gpu);
        let pipeline = self.device.ray_pipeline(&RAYS, &RayWork::LAYOUT)?;
        Ok(RayProgram { pipeline, work, results, all: Some(directions.to_vec()) })
    }

    fn along(&self, set: &BoundarySet) -> Result<RayProgram, BackendError> {
        let gpu = &self.device.gpu;
        let tables = set.tables();
        let bytes = boundaries::bytes_of_states(&tables);
        let at_a_time = origins_at_a_time(gpu, ALONG_BOUNDARIES_AT_A_TIME, set.len(), bytes);
        // The number of rays follows the bits.
        let results = RowsOfOrigins::new(gpu, set.len().div_ceil(32) + 1, at_a_time);
        let work = boundaries::bind(gpu, &tables, &results);
        let pipeline = self.device.ray_pipeline(&BOUNDARIES, &BoundaryWork::LAYOUT)?;
        Ok(RayProgram { pipeline, work, results, all: None })
    }

    /// What was made, or nothing if the cores shall trace instead.
    fn offered<T>(&self, made: Result<T, BackendError>) -> Result<Option<T>, String> {
        match made {
            Ok(made) => Ok(Some(made)),
            Err(_) if !self.is_asked_for => Ok(None),
            Err(error) => Err(told(&self.device.gpu, &error)),
        }
    }
}

impl RayDevices for GpuRays {
    fn device(&self, scene: &Intersector, directions: RayDirections) -> Result<Option<Box<dyn RayDevice>>, String> {
        let made = self.offered(self.scene(scene, directions))?;
        Ok(made.map(|scene| Box::new(scene) as Box<dyn RayDevice>))
    }

    fn fans(&self, scene: &Intersector, directions: &[Vec3]) -> Result<Option<Box<dyn FanDevice>>, String> {
        let made = self.offered(GpuFans::new(&self.device, scene, directions))?;
        Ok(made.map(|fans| Box::new(fans) as Box<dyn FanDevice>))
    }
}

/// Origins of one piece of work with so many directions in all. Each has some bytes in one buffer.
fn origins_at_a_time(gpu: &GpuDevice, in_all: usize, directions: usize, bytes: usize) -> usize {
    let room = gpu.max_storage_bytes() as usize / bytes.max(size_of::<layout::RayOrigin>());
    (in_all / directions.max(1)).min(room).clamp(1, MOST_WORKGROUPS)
}

/// An adapter that will not do, and why.
pub(super) fn told(gpu: &GpuDevice, error: &BackendError) -> String {
    error.of_adapter(&gpu.info.name, Remedy::words).unwrap_or_else(|| error.to_string())
}

/// Origins of one piece of work, and a row of results for each.
pub(super) struct RowsOfOrigins {
    pub origins: wgpu::Buffer,
    pub open: wgpu::Buffer,
    /// Words of a row.
    words: usize,
    pub at_a_time: usize,
    /// Held while rays of its origins are traced.
    tracing: Mutex<()>,
}

impl RowsOfOrigins {
    fn new(gpu: &GpuDevice, words: usize, at_a_time: usize) -> Self {
        let no_origins = vec![layout::RayOrigin::zeroed(); at_a_time];
        let origins = storage(gpu, "origins of rays", bytemuck::cast_slice(&no_origins));
        let open = written(gpu, "open rays", (at_a_time * words * size_of::<u32>()) as u64);
        Self { origins, open, words, at_a_time, tracing: Mutex::default() }
    }
}

/// A program with the directions that it is bound to.
struct RayProgram {
    pipeline: wgpu::ComputePipeline,
    work: wgpu::BindGroup,
    results: RowsOfOrigins,
    /// The directions of a program that traces all that count; `None` if its rows end with the number of rays.
    all: Option<Vec<Vec3>>,
}

/// A scene and directions on the GPU.
struct GpuRayScene {
    gpu: Arc<GpuDevice>,
    hierarchy: Arc<BoxHierarchy>,
    work: RayProgram,
}

impl GpuRayScene {
    /// The rows of one piece of work.
    fn trace(&self, origins: &[RayOrigin]) -> Result<Vec<u32>, BackendError> {
        let (gpu, RayProgram { pipeline, work, results, all }) = (&self.gpu, &self.work);
        let packed: Vec<layout::RayOrigin> = origins.iter().map(packed_origin).collect();
        let _one_at_a_time = results.tracing.lock().unwrap_or_else(PoisonError::into_inner);
        gpu.queue.write_buffer(&results.origins, 0, bytemuck::cast_slice(&packed));
        // One workgroup follows the boundaries of an origin.
        let directions = all.as_ref().map_or(1, |all| all.len() as u32);
        dispatch(gpu, pipeline, [&self.hierarchy.group, work], [directions, origins.len() as u32]);
        read_words(gpu, &results.open, origins.len() * results.words)
    }

    /// Rows with the numbers of rays.
    fn counted(&self, origins: &[RayOrigin], rows: Vec<u32>) -> OpenRays {
        let Some(directions) = &self.work.all else {
            let rows = rows.chunks(self.work.results.words).filter_map(<[u32]>::split_last);
            let (counts, rows): (Vec<u32>, Vec<&[u32]>) = rows.map(|(&count, row)| (count, row)).unzip();
            return OpenRays { rows: rows.concat(), counts };
        };
        let count = |at: &RayOrigin| directions.iter().filter(|d| at.half.has(**d)).count() as u32;
        OpenRays { rows, counts: origins.par_iter().map(count).collect() }
    }
}

/// Traces so many directions from so many origins by a program of [`pipeline`].
pub(super) fn dispatch(
    gpu: &GpuDevice,
    pipeline: &wgpu::ComputePipeline,
    [hierarchy, work]: [&wgpu::BindGroup; 2],
    [directions, origins]: [u32; 2],
) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, hierarchy, &[]);
        pass.set_bind_group(1, work, &[]);
        pass.dispatch_workgroups(directions.div_ceil(DIRECTIONS_PER_GROUP), origins, 1);
    }
    gpu.queue.submit([encoder.finish()]);
}

impl RayDevice for GpuRayScene {
    fn open(&self, origins: &[RayOrigin]) -> Result<OpenRays, String> {
        let mut open = OpenRays::default();
        for some in origins.chunks(self.work.results.at_a_time) {
            let rows = self.trace(some).map_err(|error| told(&self.gpu, &error))?;
            let OpenRays { rows, counts } = self.counted(some, rows);
            open.rows.extend(rows);
            open.counts.extend(counts);
        }
        Ok(open)
    }
}

fn packed_origin(at: &RayOrigin) -> layout::RayOrigin {
    layout::RayOrigin {
        origin: at.origin.into(),
        height: at.half.height,
        normal: at.half.normal.into(),
        is_above: u32::from(at.half.is_above),
    }
}

#[cfg(test)]
mod tests;
