//! The options that select the rendering device, for the window and all commands.

use crate::terminal::remedy_option;
use clap::{Args, ValueEnum};
use lapidary_render::{
    Backend, BackendError, CpuBackend,
    gpu::{GpuBackend, GpuPath, Room, ShaderSource, SharedDevice, faster_path},
};
use serde::{Deserialize, Serialize};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

/// Where and how pictures are rendered.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceArgs {
    /// Rendering device
    #[arg(long, value_enum, default_value_t)]
    pub backend: BackendOption,
    /// What the graphics adapter runs for each pixel; both give the same pixels
    #[arg(long, value_enum, default_value_t)]
    gpu_path: PathOption,
}

/// Rendering device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum BackendOption {
    /// The graphics adapter; the CPU if there is none or only an emulated one
    #[default]
    Auto,
    /// The graphics adapter, even an emulated one; an error if there is none
    Gpu,
    /// All cores of the CPU
    Cpu,
}

/// What the adapter runs for each pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum PathOption {
    /// What is faster there, by a measurement of some milliseconds
    #[default]
    Auto,
    /// A fragment shader
    Fragment,
    /// A compute shader
    Compute,
}

/// The path that was faster on an adapter.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeasuredPath {
    /// Its name and driver.
    pub adapter: String,
    /// What is faster there.
    pub path: GpuPath,
}

/// What was measured last, if anything was.
pub type PathMemory = Arc<Mutex<Option<MeasuredPath>>>;

/// What is known of adapters from earlier.
#[derive(Clone, Debug, Default)]
pub struct AdapterMemory {
    /// The path is measured only if this lacks it.
    pub path: PathMemory,
    /// The folder of compiled pipelines; none are kept without it.
    pub pipelines: Option<PathBuf>,
}

/// Environment variable with a folder of shaders that replaces the program's own, for shader work: they reload on change.
const SHADERS: &str = "LAPIDARY_SHADERS";

impl DeviceArgs {
    /// The graphics adapter, even an emulated one.
    pub const GPU: Self = Self { backend: BackendOption::Gpu, gpu_path: PathOption::Auto };
    /// The CPU.
    pub const CPU: Self = Self { backend: BackendOption::Cpu, gpu_path: PathOption::Auto };

    /// The renderer on the adapter, or `None` for the CPU.
    ///
    /// # Errors
    /// No adapter, or a refusing driver, if an adapter is required.
    pub fn gpu(self) -> Result<Option<GpuBackend>, BackendError> {
        self.gpu_with(&AdapterMemory::default())
    }

    /// The same with what is known of adapters.
    fn gpu_with(self, memory: &AdapterMemory) -> Result<Option<GpuBackend>, BackendError> {
        if self.backend == BackendOption::Cpu {
            return Ok(None);
        }
        match (self.on_adapter(memory), self.backend) {
            (Err(BackendError::NoAdapter { .. }), BackendOption::Auto) => Ok(None),
            (Err(error), BackendOption::Auto) => {
                eprintln!("warning: rendering on the CPU: {}", error.text(remedy_option));
                Ok(None)
            }
            (opened, _) => opened,
        }
    }

    /// An emulated adapter would only use the same cores more slowly: only who asks for it has it.
    fn on_adapter(self, memory: &AdapterMemory) -> Result<Option<GpuBackend>, BackendError> {
        let device = SharedDevice::with_cache(Room::All, memory.pipelines.as_deref())?;
        if self.backend == BackendOption::Auto && device.is_emulated() {
            return Ok(None);
        }
        let path = match self.gpu_path {
            PathOption::Fragment => GpuPath::Fragment,
            PathOption::Compute => GpuPath::Compute,
            PathOption::Auto => remembered(&device, &memory.path)?,
        };
        GpuBackend::new(device, &shader_source(), path).map(Some)
    }

    /// The renderer.
    ///
    /// # Errors
    /// As [`Self::gpu`].
    pub fn open(self) -> Result<Box<dyn Backend>, BackendError> {
        self.open_with(&AdapterMemory::default())
    }

    /// The renderer with what is known of adapters.
    ///
    /// # Errors
    /// As [`Self::gpu`].
    pub fn open_with(self, memory: &AdapterMemory) -> Result<Box<dyn Backend>, BackendError> {
        Ok(match self.gpu_with(memory)? {
            Some(gpu) => Box::new(gpu),
            None => Box::new(CpuBackend::new()),
        })
    }
}

/// The path that is faster on a device: as it is remembered, or measured now. An emulated one runs both on the same cores; there it is
/// fragments, and Mesa 22.3 fails in some kernels.
fn remembered(device: &SharedDevice, memory: &PathMemory) -> Result<GpuPath, BackendError> {
    if device.is_emulated() {
        return Ok(GpuPath::Fragment);
    }
    known_or(memory, &format!("{}, {}", device.name(), device.facts().driver), || faster_path(device))
}

/// The path that is remembered of an adapter, or the measured one, which is remembered.
fn known_or(
    memory: &PathMemory,
    adapter: &str,
    measure: impl FnOnce() -> Result<GpuPath, BackendError>,
) -> Result<GpuPath, BackendError> {
    let mut memory = memory.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = memory.as_ref().filter(|known| known.adapter == adapter) {
        return Ok(known.path);
    }
    let path = measure()?;
    *memory = Some(MeasuredPath { adapter: adapter.into(), path });
    Ok(path)
}

/// The program's own shaders, or the folder in the environment variable.
pub fn shader_source() -> ShaderSource {
    std::env::var_os(SHADERS).map_or(ShaderSource::Embedded, |folder| ShaderSource::Folder(folder.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_measured_once_for_each_adapter() {
        let memory = PathMemory::default();
        let of = |adapter, measured| known_or(&memory, adapter, || Ok(measured)).unwrap();
        assert_eq!(of("a card", GpuPath::Compute), GpuPath::Compute);
        assert_eq!(of("a card", GpuPath::Fragment), GpuPath::Compute, "it is remembered");
        assert_eq!(of("another", GpuPath::Fragment), GpuPath::Fragment, "negative control");
    }
}
