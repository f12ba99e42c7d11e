//! One compute pipeline, whose work is cut into slices of a few milliseconds.

use super::{
    adapter::GpuDevice,
    bindings::{GroupLayout, Shaders, module_of},
    buffers::uniform,
    kernels::{Hierarchy, KernelProgram, Slice},
    pace::Pace,
    shaders::Program,
};
use crate::error::BackendError;
use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

/// A kernel: a program with one compute entry point. Its data are in the groups from 1 on; group 0 tells the slice
/// (`shaders/slice.wgsl`).
pub struct Kernel {
    pipeline: wgpu::ComputePipeline,
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
    /// Compiles a program, with values of its specialization constants.
    ///
    /// # Errors
    /// A shader that does not compile, or a lost device.
    pub fn new(
        gpu: &GpuDevice,
        shaders: &Shaders,
        KernelProgram { program, groups }: &KernelProgram,
        constants: &[(&str, f64)],
    ) -> Result<Self, BackendError> {
        let label = Some(program.name);
        let first = uniform(gpu, "first workgroup", &0_u32.to_ne_bytes());
        let slice = Slice { slice: &first }.bind(gpu);
        let groups: Vec<_> = [&Slice::LAYOUT].into_iter().chain(*groups).map(|group| Some(group.on(gpu))).collect();
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &groups.iter().map(Option::as_ref).collect::<Vec<_>>(),
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&layout),
            module: &module_of(gpu, program.name, &shaders.text(program)?, shaders.loops_end()),
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: gpu.pipeline_cache(),
        });
        gpu.check()?;
        Ok(Self { pipeline, slice, running: Mutex::new(Running { first, pace: Pace::default() }) })
    }

    /// Runs workgroups on bound data, slice by slice. Returns after the last, with the time of all.
    ///
    /// # Errors
    /// A lost device, or what the driver reports.
    pub fn run(&self, gpu: &GpuDevice, data: &[wgpu::BindGroup], workgroups: u32) -> Result<Duration, BackendError> {
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

    fn dispatch(&self, gpu: &GpuDevice, data: &[wgpu::BindGroup], workgroups: u32) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.slice, &[]);
            for (group, data) in (1..).zip(data) {
                pass.set_bind_group(group, data, &[]);
            }
            pass.dispatch_workgroups(workgroups, 1, 1);
        }
        gpu.queue.submit([encoder.finish()]);
    }
}

/// The pipeline of a program of rays, whose groups are [`Hierarchy`] and its work. It runs in no slices.
///
/// # Errors
/// A shader that does not compile, or a lost device.
pub fn ray_pipeline(
    gpu: &GpuDevice,
    program: &Program,
    work: &GroupLayout,
) -> Result<wgpu::ComputePipeline, BackendError> {
    let groups = [Hierarchy::LAYOUT.on(gpu), work.on(gpu)];
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(program.name),
        bind_group_layouts: &groups.each_ref().map(Some),
        immediate_size: 0,
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(program.name),
        layout: Some(&layout),
        module: &module_of(gpu, program.name, &Shaders::default().text(program)?, true),
        entry_point: None,
        compilation_options: Default::default(),
        cache: gpu.pipeline_cache(),
    });
    gpu.check()?;
    Ok(pipeline)
}
