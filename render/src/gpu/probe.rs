//! Which path is faster on an adapter: a measurement of some milliseconds. Cards for data centres run fragments on few of their
//! processors, and kernels on all.

use super::{
    draw::{BoundFrame, encode_areas},
    entries::PROBE,
    targets::{Target, format, target},
};
use crate::{
    device::{
        GpuDevice, Shaders, SharedDevice,
        layout::FrameUniforms,
        pass::{GpuPath, Pass},
        uniform,
    },
    error::BackendError,
};
use lapidary_core::image::Region;
use std::time::{Duration, Instant};

/// Sides of the pictures that are drawn, until one takes long enough to tell.
const SIDES: [u32; 3] = [128, 512, 2048];
/// Times below are those of submitting work.
const ENOUGH: Duration = Duration::from_millis(2);
const RUNS: usize = 3;
/// Kernels are taken if fragments take this many times as long: less is noise.
const CLEARLY: f64 = 1.1;

/// The faster path on a device.
///
/// # Errors
/// A lost device, or a driver that refuses.
pub fn faster_path(device: &SharedDevice) -> Result<GpuPath, BackendError> {
    let gpu = &*device.gpu;
    let pass = |path| Ok::<_, BackendError>(device.texts.of(gpu, &Shaders::default(), path, &PROBE)?.variant(&[]));
    let passes = [pass(GpuPath::Fragment)?, pass(GpuPath::Compute)?];
    let frame = BoundFrame::new(gpu, &uniform(gpu, "frame", &[0; size_of::<FrameUniforms>()]));
    let mut faster = GpuPath::Fragment;
    for side in SIDES {
        let to = target(gpu, "probe", format::FLOATS, [side, side]);
        let [fragment, compute] = passes.each_ref().map(|pass| time(gpu, pass, &frame, &to));
        let (fragment, compute) = (fragment?, compute?);
        faster = if compute.mul_f64(CLEARLY) < fragment { GpuPath::Compute } else { GpuPath::Fragment };
        if fragment.max(compute) > ENOUGH {
            break;
        }
    }
    Ok(faster)
}

/// The shortest time of a pass over a target. The first run also compiles.
fn time(gpu: &GpuDevice, pass: &Pass, frame: &BoundFrame, to: &Target) -> Result<Duration, BackendError> {
    let size = [to.texture.width(), to.texture.height()];
    let mut shortest = Duration::MAX;
    for _ in 0..=RUNS {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encode_areas(&mut encoder, pass, frame, &[], &[to], &[Region::whole(size)]);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        shortest = shortest.min(start.elapsed());
    }
    Ok(shortest)
}
