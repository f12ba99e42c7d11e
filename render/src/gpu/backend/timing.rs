//! How long the passes of a sample take.

use super::GpuBackend;
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
    /// Renders one sample pass by pass, waiting for each. Returns the time of each.
    ///
    /// # Errors
    /// A lost device.
    ///
    /// # Panics
    /// Before [`crate::Backend::begin`].
    pub fn timed_sample(&mut self, sample: u32, post: &Post) -> Result<PassTimes, BackendError> {
        let whole = Region::whole(self.picture().view.size);
        self.write_frame(sample, 1);
        self.leave_sketch(sample);
        self.gpu.wait()?;
        self.write_display(post);
        Ok(PassTimes {
            visibility: self.timed(|s, encoder| s.encode_visibility(encoder))?,
            deferred: self.timed(|s, encoder| s.encode_deferred(encoder))?,
            merge: self.timed(|s, encoder| {
                s.encode_parts(encoder, 1, &[whole]);
                s.sample_done(sample);
            })?,
            display: self.timed(|s, encoder| s.encode_display(encoder))?,
        })
    }

    fn timed(&mut self, encode: impl FnOnce(&mut Self, &mut wgpu::CommandEncoder)) -> Result<Duration, BackendError> {
        let start = Instant::now();
        self.submit(encode)?;
        Ok(start.elapsed())
    }
}
