//! Meshless radiosity on the GPU (Zollhöfer and Stamminger 2011, 5): the functions of a level that gather are listed, gather by rays
//! that are kept, and split or are pulled. Twin of `core/src/meshless/radiosity/transport.rs`.
//!
//! Lists are exact. Light differs by the order of sums, and so may the split of a function whose difference is within rounding of the
//! threshold.

mod rows;

use super::{
    adapter::GpuDevice,
    buffers::{storage, uniform, written},
    compute::SharedDevice,
    kernel::Kernel,
    kernels::{
        FunctionLevel, GatheredRows, ListedReceivers, RADIOSITY_COUNT, RADIOSITY_GATHER, RADIOSITY_PULL,
        RADIOSITY_SCAN, RADIOSITY_WRITE, ReceivedLight,
    },
    layout::{Coefficient, LevelUniforms},
    readback::read_range,
};
use crate::{error::BackendError, remedy::Remedy};
use bytemuck::{Zeroable, bytes_of, cast_slice};
use glam::{Mat3A, Vec3, Vec3A};
use lapidary_core::meshless::{ActiveFunctions, ObjectBases, ReceiverRays, TransportDevice};
use rows::Rows;
use std::{ops::Range, sync::Arc};

/// Functions of a workgroup that lists, as in the shaders.
const BLOCK: usize = 256;

/// Functions of a workgroup that pulls.
const PULLED_PER_GROUP: usize = 64;

/// Functions on an adapter, with the rays of those that gathered.
pub struct GpuRadiosity {
    gpu: Arc<GpuDevice>,
    kernels: Kernels,
    levels: Vec<Range<usize>>,
    buffers: Buffers,
    rows: Rows,
    /// How many functions the list of those that gather has.
    active: usize,
}

struct Kernels {
    count: Arc<Kernel>,
    scan: Arc<Kernel>,
    write: Arc<Kernel>,
    gather: Arc<Kernel>,
    pull: Arc<Kernel>,
}

/// What kernels read and write beside rays.
struct Buffers {
    level: wgpu::Buffer,
    parent_starts: wgpu::Buffer,
    parents: wgpu::Buffer,
    /// Whether each function is covered or split.
    states: wgpu::Buffer,
    sums: wgpu::Buffer,
    receivers: wgpu::Buffer,
    unknown: wgpu::Buffer,
    directions: wgpu::Buffer,
    /// Of the senders.
    radiance: wgpu::Buffer,
    received: wgpu::Buffer,
}

impl GpuRadiosity {
    /// Takes functions and the directions of a receiver's rays. No buffer of rays is larger than `most_bytes`.
    ///
    /// # Errors
    /// Functions beyond the adapter's limits, or a lost device.
    pub fn new(
        device: &SharedDevice,
        bases: &ObjectBases,
        directions: &[Vec3],
        most_bytes: u64,
    ) -> Result<Self, BackendError> {
        let gpu = device.gpu.clone();
        let kernels = Kernels {
            count: device.kernel(&RADIOSITY_COUNT)?,
            scan: device.kernel(&RADIOSITY_SCAN)?,
            write: device.kernel(&RADIOSITY_WRITE)?,
            gather: device.kernel(&RADIOSITY_GATHER)?,
            pull: device.kernel(&RADIOSITY_PULL)?,
        };
        let buffers = Buffers::new(&gpu, bases, directions)?;
        let rows = Rows::new(&gpu, bases.len(), directions.len(), most_bytes.min(gpu.max_storage_bytes()));
        gpu.check()?;
        let levels = (0..bases.levels()).map(|level| bases.level(level)).collect();
        Ok(Self { gpu, kernels, levels, buffers, rows, active: 0 })
    }

    /// Tells the kernels a level, and binds it.
    fn level(&self, level: usize, enough: f32) -> wgpu::BindGroup {
        let (b, Range { start, end }) = (&self.buffers, self.levels[level].clone());
        let uniforms = LevelUniforms { first: start as u32, end: end as u32, enough };
        self.gpu.queue.write_buffer(&b.level, 0, bytes_of(&uniforms));
        FunctionLevel {
            level: &b.level,
            parent_starts: &b.parent_starts,
            parents: &b.parents,
            states: &b.states,
            slots: self.rows.slots(),
        }
        .bind(&self.gpu)
    }

    fn list(&mut self, level: usize) -> Result<ActiveFunctions, BackendError> {
        let (gpu, on, b) = (&self.gpu, &self.kernels, &self.buffers);
        let listed = ListedReceivers { sums: &b.sums, receivers: &b.receivers, unknown: &b.unknown };
        let data = [self.level(level, 0.0), listed.bind(gpu)];
        let blocks = self.levels[level].len().div_ceil(BLOCK);
        on.count.run(gpu, &data, blocks as u32)?;
        on.scan.run(gpu, &data, 1)?;
        on.write.run(gpu, &data, blocks as u32)?;
        let sums: Vec<[u32; 2]> = read_range(gpu, &b.sums, blocks..blocks + 1)?;
        let [active, unknown] = sums[0].map(|count| count as usize);
        let unknown = if unknown == 0 { vec![] } else { read_range(gpu, &b.unknown, 0..unknown)? };
        self.active = active;
        Ok(ActiveFunctions { count: active, unknown })
    }

    /// The list gathers, buffer by buffer of rays.
    fn gather_listed(&self) -> Result<(), BackendError> {
        let (gpu, b) = (&self.gpu, &self.buffers);
        for part in self.rows.parts() {
            let rows = GatheredRows {
                bound: &part.uniforms,
                receivers: &b.receivers,
                slots: self.rows.slots(),
                rows: &part.senders,
                frames: &part.frames,
                directions: &b.directions,
                radiance: &b.radiance,
                received: &b.received,
            };
            self.kernels.gather.run(gpu, &[rows.bind(gpu)], self.active as u32)?;
        }
        Ok(())
    }

    fn pull(&self, level: usize, enough: f32) -> Result<(), BackendError> {
        let light = ReceivedLight { received: &self.buffers.received }.bind(&self.gpu);
        let groups = self.levels[level].len().div_ceil(PULLED_PER_GROUP);
        self.kernels.pull.run(&self.gpu, &[self.level(level, enough), light], groups as u32)?;
        Ok(())
    }
}

impl TransportDevice for GpuRadiosity {
    fn send(&mut self, radiance: &[Vec3A], covered: &[bool]) -> Result<(), String> {
        let (queue, b) = (&self.gpu.queue, &self.buffers);
        let radiance: Vec<[f32; 4]> = radiance.iter().map(|sent| sent.extend(0.0).to_array()).collect();
        queue.write_buffer(&b.radiance, 0, cast_slice(&radiance));
        let states: Vec<u32> = covered.iter().map(|&covered| u32::from(covered)).collect();
        queue.write_buffer(&b.states, 0, cast_slice(&states));
        self.gpu.check().map_err(described)
    }

    fn find_active(&mut self, level: usize) -> Result<ActiveFunctions, String> {
        self.list(level).map_err(described)
    }

    fn take_rays(&mut self, receivers: &[ReceiverRays]) -> Result<(), String> {
        self.rows.take(&self.gpu, receivers).map_err(described)
    }

    fn forget_rays(&mut self) {
        self.rows.forget(&self.gpu);
    }

    fn gather(&mut self, level: usize, enough: f32) -> Result<(), String> {
        self.gather_listed().and_then(|()| self.pull(level, enough)).map_err(described)
    }

    fn received(&self, functions: Range<usize>) -> Result<Vec<Mat3A>, String> {
        if functions.is_empty() {
            return Ok(Vec::new());
        }
        let light: Vec<Coefficient> = read_range(&self.gpu, &self.buffers.received, functions).map_err(described)?;
        let vector = |light: &Coefficient| {
            let [x, y, z] = light.vector.map(|[x, y, z, _]| Vec3A::new(x, y, z));
            Mat3A::from_cols(x, y, z)
        };
        Ok(light.iter().map(vector).collect())
    }
}

impl Buffers {
    fn new(gpu: &GpuDevice, bases: &ObjectBases, directions: &[Vec3]) -> Result<Self, BackendError> {
        let bytes = |count: usize, size: usize| (count.max(1) * size) as u64;
        let (starts, parents) = packed_parents(bases);
        let largest = bytes(bases.len(), size_of::<Coefficient>()).max(size_of_val(&parents[..]) as u64);
        gpu.within("the meshless functions", "bytes", largest, gpu.max_storage_bytes(), Remedy::Cpu)?;
        let toward: Vec<[f32; 4]> = directions.iter().map(|d| d.extend(0.0).to_array()).collect();
        let widest = (0..bases.levels()).map(|level| bases.level(level).len()).max().unwrap_or(0);
        let senders = bases.level(bases.sender_level()).len();
        Ok(Self {
            level: uniform(gpu, "level of functions", bytes_of(&LevelUniforms::zeroed())),
            parent_starts: storage(gpu, "starts of parents", cast_slice(&starts)),
            parents: storage(gpu, "parents of functions", cast_slice(&parents)),
            states: written(gpu, "states of functions", bytes(bases.len(), size_of::<u32>())),
            sums: written(gpu, "sums of blocks", bytes(widest.div_ceil(BLOCK) + 1, size_of::<[u32; 2]>())),
            receivers: written(gpu, "receivers", bytes(widest, size_of::<u32>())),
            unknown: written(gpu, "receivers of unknown rays", bytes(widest, size_of::<u32>())),
            directions: storage(gpu, "directions of receivers", cast_slice(&toward)),
            radiance: written(gpu, "radiance of senders", bytes(senders, size_of::<[f32; 4]>())),
            received: written(gpu, "light of functions", bytes(bases.len(), size_of::<Coefficient>())),
        })
    }
}

/// First parent of each function, with the end of the last, and parents with their weights. There is at least one entry, since a
/// buffer has contents.
fn packed_parents(bases: &ObjectBases) -> (Vec<u32>, Vec<[u32; 2]>) {
    let (mut starts, mut entries) = (vec![0], Vec::new());
    for function in 0..bases.len() {
        entries.extend(bases.parents().row(function).iter().map(|&(parent, weight)| [parent, weight.to_bits()]));
        starts.push(entries.len() as u32);
    }
    entries.resize(entries.len().max(1), [0; 2]);
    (starts, entries)
}

fn described(error: BackendError) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests;
