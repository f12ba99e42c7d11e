//! One compute pipeline, whose work is cut into slices of a few milliseconds.

use super::{
    adapter::GpuDevice,
    bindings::{Binding, Shaders, bind, bind_layout, module},
    buffers::uniform,
    pace::Pace,
    shaders::KernelProgram,
};
use crate::error::BackendError;
use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

/// A kernel: a program with one compute entry point. Its data are in group 1; group 0 tells the slice (`shaders/slice.wgsl`).
pub struct Kernel {
    label: &'static str,
    pipeline: wgpu::ComputePipeline,
    data: wgpu::BindGroupLayout,
    slice: wgpu::BindGroup,
    /// Held while it runs.
    running: Mutex<Running>,
}

struct Running {
    /// Number of the first workgroup of the slice.
    first: wgpu::Buffer,
    pace: Pace,
}

impl Kernel {
    /// Compiles a program.
    ///
    /// # Errors
    /// A shader that does not compile, or a lost device.
    pub fn new(gpu: &GpuDevice, &KernelProgram { program, bindings }: &KernelProgram) -> Result<Self, BackendError> {
        let label = program.name;
        let slices = bind_layout(gpu, "slice", &[Binding::Uniform]);
        let first = uniform(gpu, "first workgroup", &0_u32.to_ne_bytes());
        let slice = bind(gpu, "slice", &slices, &[first.as_entire_binding()]);
        let data = bind_layout(gpu, label, bindings);
        let module = module(gpu, &Shaders::default(), &program)?;
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &[Some(&slices), Some(&data)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: Some(&layout),
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { label, pipeline, data, slice, running: Mutex::new(Running { first, pace: Pace::default() }) })
    }

    /// Binds its data.
    pub fn bind(&self, gpu: &GpuDevice, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
        let resources: Vec<_> = buffers.iter().map(|buffer| buffer.as_entire_binding()).collect();
        bind(gpu, self.label, &self.data, &resources)
    }

    /// Runs workgroups on bound data, slice by slice. Returns after the last, with the time of all.
    ///
    /// # Errors
    /// A lost device, or what the driver reports.
    pub fn run(&self, gpu: &GpuDevice, data: &wgpu::BindGroup, workgroups: u32) -> Result<Duration, BackendError> {
        let begin = Instant::now();
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        let mut done = 0;
        while done < workgroups {
            let some = running.pace.next().min(workgroups - done);
            let start = Instant::now();
            gpu.queue.write_buffer(&running.first, 0, &done.to_ne_bytes());
            self.dispatch(gpu, data, some);
            gpu.wait()?;
            running.pace.took(some, start.elapsed());
            done += some;
        }
        Ok(begin.elapsed())
    }

    fn dispatch(&self, gpu: &GpuDevice, data: &wgpu::BindGroup, workgroups: u32) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.slice, &[]);
            pass.set_bind_group(1, data, &[]);
            pass.dispatch_workgroups(workgroups, 1, 1);
        }
        gpu.queue.submit([encoder.finish()]);
    }
}
