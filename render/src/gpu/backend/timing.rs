//! How long the passes of a sample take.

use super::{GpuBackend, pipelines::Pipelines};
use crate::{error::BackendError, post::Post};
use lapidary_core::image::Region;
use std::time::{Duration, Instant};

/// Wall-clock time of each pass of one sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct PassTimes {
    /// Rasterising triangle numbers and depth.
    pub visibility: Duration,
    /// Barycentric weights, frames and BRDF parameters.
    pub deferred: Duration,
    /// Local lights, bounced light, and the merge.
    pub merge: Duration,
    /// The post pass.
    pub display: Duration,
}

impl GpuBackend {
    /// What the passes in use took to compile, by their labels.
    pub fn compile_times(&self) -> Vec<(&'static str, Duration)> {
        self.pipelines.passes.compile_times()
    }

    /// Renders one sample pass by pass, waiting for each. Returns the time of each.
    ///
    /// # Errors
    /// A lost device.
    ///
    /// # Panics
    /// Before [`crate::Backend::begin`].
    pub fn timed_sample(&mut self, sample: u32, post: &Post) -> Result<PassTimes, BackendError> {
        self.write_frame(sample, 1);
        let Self { pipelines, progress, .. } = self;
        let (gpu, passes, uniforms) = (pipelines.gpu(), &pipelines.passes, &pipelines.uniforms);
        let (picture, whole) = (progress.picture(), Region::whole(progress.picture().view.size));
        gpu.queue.write_buffer(&uniforms.display, 0, bytemuck::bytes_of(&picture.display(post)));
        progress.leave_sketch(sample);
        gpu.wait()?;
        let visibility = timed(pipelines, |encoder| progress.encode_visibility(passes, encoder))?;
        let deferred = timed(pipelines, |encoder| progress.encode_deferred(passes, encoder))?;
        let merge = timed(pipelines, |encoder| progress.encode_parts(&pipelines.passes, encoder, 1, &[whole]))?;
        progress.sample_done(sample);
        let display = timed(pipelines, |encoder| progress.encode_display(passes, encoder))?;
        Ok(PassTimes { visibility, deferred, merge, display })
    }
}

fn timed(pipelines: &Pipelines, encode: impl FnOnce(&mut wgpu::CommandEncoder)) -> Result<Duration, BackendError> {
    let start = Instant::now();
    pipelines.submit(encode)?;
    Ok(start.elapsed())
}
