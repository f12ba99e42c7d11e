//! A whole picture from a renderer that makes it in steps, and how it was made.

use lapidary_core::image::Image;
use lapidary_render::{Backend, BackendError, BrdfSampling, CPU, RenderStats, View};

/// Rows that are rendered at once: drivers stop work that holds up a graphics adapter for seconds, as the whole of a large
/// picture with thousands of lights may.
pub const BAND_ROWS: u32 = 64;

/// Renders all samples of all pixels of a lit scene. Returns the scene-linear picture, and how much of each pixel is covered by
/// surfaces.
///
/// # Errors
/// A picture beyond the adapter's limits, or a lost device.
pub fn whole_picture(
    backend: &mut dyn Backend,
    view: &View,
    sampling: BrdfSampling,
) -> Result<(Image, Vec<f32>), BackendError> {
    backend.begin(view, sampling)?;
    let height = view.size[1];
    for sample in 0..view.aa {
        for first in (0..height).step_by(BAND_ROWS as usize) {
            backend.render_rows(sample, first..height.min(first + BAND_ROWS))?;
        }
    }
    backend.read(view.aa)
}

/// How the picture that was rendered last was made; it took `seconds`.
///
/// # Errors
/// A lost device.
pub fn stats(backend: &mut dyn Backend, seconds: f64) -> Result<RenderStats, BackendError> {
    let done = backend.stats()?;
    let on_gpu = backend.name() != CPU;
    Ok(RenderStats {
        backend: if on_gpu { "gpu" } else { "cpu" }.into(),
        adapter: on_gpu.then(|| backend.name()),
        seconds,
        pixels_shaded: done.pixels_shaded,
        mean_merged_nodes: done.mean_merged_nodes,
        mean_brdf_evaluations: done.mean_brdf_evaluations,
    })
}
