//! Rays of receivers in buffers of limited size. A receiver has a slot from the first time that it gathers.

use crate::{
    device::{
        adapter::GpuDevice,
        buffers::{uniform, written},
        layout::RowUniforms,
    },
    error::BackendError,
    remedy::Remedy,
};
use bytemuck::{bytes_of, cast_slice};
use glam::Mat3;
use lapidary_core::meshless::ReceiverRays;
use std::f32::consts::TAU;

/// Most bytes of all rays on the adapter: as many rays as the cores keep in 2 GiB.
const MOST_BYTES: u64 = 1 << 30;

/// A frame as the kernel reads it.
type PackedFrame = [[f32; 4]; 3];

/// The rays of receivers.
pub struct Rows {
    /// Rays of a receiver.
    rays: usize,
    /// Receivers of a part.
    per_part: usize,
    parts: Vec<Part>,
    /// For each function its slot plus 1; 0 if it has none.
    slots: Vec<u32>,
    /// The same for those whose rays are as they are now; 0 for others.
    known: Vec<u32>,
    /// `known` on the adapter.
    on_device: wgpu::Buffer,
    taken: u32,
}

/// The rays of some slots.
pub struct Part {
    pub uniforms: wgpu::Buffer,
    pub senders: wgpu::Buffer,
    pub frames: wgpu::Buffer,
}

impl Rows {
    /// No rays of some functions yet. No buffer is larger than `most_bytes`.
    pub fn new(gpu: &GpuDevice, functions: usize, rays: usize, most_bytes: u64) -> Self {
        let in_limit = most_bytes as usize / (rays * size_of::<u32>()).max(size_of::<PackedFrame>());
        Self {
            rays,
            per_part: in_limit.min(functions),
            parts: Vec::new(),
            slots: vec![0; functions],
            known: vec![0; functions],
            on_device: written(gpu, "slots of rays", (functions.max(1) * size_of::<u32>()) as u64),
            taken: 0,
        }
    }

    /// For each function the slot of its rays plus 1; 0 if they are unknown.
    pub fn slots(&self) -> &wgpu::Buffer {
        &self.on_device
    }

    /// The buffers of rays.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Counts all rays as unknown.
    pub fn forget(&mut self, gpu: &GpuDevice) {
        self.known.fill(0);
        gpu.queue.write_buffer(&self.on_device, 0, cast_slice(&self.known));
    }

    /// Takes the rays of receivers in ascending order.
    ///
    /// # Errors
    /// More rays than there is room for, or a lost device.
    pub fn take(&mut self, gpu: &GpuDevice, receivers: &[ReceiverRays]) -> Result<(), BackendError> {
        let [Some(first), Some(last)] = [receivers.first(), receivers.last()] else { return Ok(()) };
        for receiver in receivers {
            let function = receiver.function as usize;
            if self.slots[function] == 0 {
                self.taken += 1;
                self.slots[function] = self.taken;
            }
            self.known[function] = self.slots[function];
        }
        self.make_room(gpu)?;
        self.write(gpu, receivers);
        let functions = first.function as usize..=last.function as usize;
        let start = (first.function as usize * size_of::<u32>()) as u64;
        gpu.queue.write_buffer(&self.on_device, start, cast_slice(&self.known[functions]));
        // Else what is written waits in memory for the next kernel.
        gpu.queue.submit([]);
        gpu.wait()
    }

    /// Adds parts until there is one for each slot.
    fn make_room(&mut self, gpu: &GpuDevice) -> Result<(), BackendError> {
        let bytes = (self.taken as usize * self.rays * size_of::<u32>()) as u64;
        gpu.within("the rays of meshless functions", "bytes", bytes, MOST_BYTES, Remedy::Cpu)?;
        gpu.within("the rays of a receiver", "rows", 1, self.per_part as u64, Remedy::Cpu)?;
        while self.parts.len() * self.per_part < self.taken as usize {
            let part = Part::new(gpu, self.parts.len() * self.per_part, self.per_part, self.rays);
            self.parts.push(part);
        }
        gpu.check()
    }

    /// Writes rays; those of neighboring slots at once.
    fn write(&self, gpu: &GpuDevice, receivers: &[ReceiverRays]) {
        let slot = |receiver: &ReceiverRays| self.slots[receiver.function as usize] as usize - 1;
        let mut by_slot: Vec<&ReceiverRays> = receivers.iter().collect();
        by_slot.sort_by_key(|receiver| slot(receiver));
        let are_together =
            |a: &&ReceiverRays, b: &&ReceiverRays| slot(b) == slot(a) + 1 && slot(b) % self.per_part != 0;
        for run in by_slot.chunk_by(are_together) {
            let (part, row) = (&self.parts[slot(run[0]) / self.per_part], slot(run[0]) % self.per_part);
            let senders: Vec<u32> = run.iter().flat_map(|receiver| &receiver.senders).copied().collect();
            let frames: Vec<PackedFrame> = run.iter().map(|receiver| packed(receiver.frame)).collect();
            let at = |bytes: usize| (row * bytes) as u64;
            gpu.queue.write_buffer(&part.senders, at(self.rays * size_of::<u32>()), cast_slice(&senders));
            gpu.queue.write_buffer(&part.frames, at(size_of::<PackedFrame>()), cast_slice(&frames));
        }
    }
}

impl Part {
    fn new(gpu: &GpuDevice, first_slot: usize, slots: usize, rays: usize) -> Self {
        let uniforms = RowUniforms {
            rays: rays as u32,
            solid_angle: TAU / rays as f32,
            first_slot: first_slot as u32,
            slots: slots as u32,
        };
        Self {
            uniforms: uniform(gpu, "slots of a part", bytes_of(&uniforms)),
            senders: written(gpu, "senders that rays meet", (slots * rays * size_of::<u32>()) as u64),
            frames: written(gpu, "frames of receivers", (slots * size_of::<PackedFrame>()) as u64),
        }
    }
}

fn packed(frame: Mat3) -> PackedFrame {
    [frame.x_axis, frame.y_axis, frame.z_axis].map(|column| column.extend(0.0).to_array())
}
