//! The option that selects the rendering device, for the window and all commands.

use crate::terminal::remedy_option;
use clap::ValueEnum;
use lapidary_render::{
    Backend, BackendError, CpuBackend,
    gpu::{GpuBackend, Room, ShaderSource},
};

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

/// Environment variable with a folder of shaders that replaces the program's own, for shader work: they reload on change.
const SHADERS: &str = "LAPIDARY_SHADERS";

impl BackendOption {
    /// The renderer on the adapter, or `None` for the CPU.
    ///
    /// # Errors
    /// No adapter, or a refusing driver, if an adapter is required.
    pub fn gpu(self) -> Result<Option<GpuBackend>, BackendError> {
        match self {
            Self::Cpu => Ok(None),
            Self::Gpu => GpuBackend::new(Room::All, &shader_source()).map(Some),
            // An emulated adapter would only use the same cores more slowly.
            Self::Auto => match GpuBackend::on_hardware(Room::All, &shader_source()) {
                Ok(gpu) => Ok(Some(gpu)),
                Err(BackendError::NoAdapter { .. }) => Ok(None),
                Err(error) => {
                    eprintln!("warning: rendering on the CPU: {}", error.text(remedy_option));
                    Ok(None)
                }
            },
        }
    }

    /// The renderer.
    ///
    /// # Errors
    /// As [`Self::gpu`].
    pub fn open(self) -> Result<Box<dyn Backend>, BackendError> {
        Ok(match self.gpu()? {
            Some(gpu) => Box::new(gpu),
            None => Box::new(CpuBackend::new()),
        })
    }
}

/// The program's own shaders, or the folder in the environment variable.
pub fn shader_source() -> ShaderSource {
    std::env::var_os(SHADERS).map_or(ShaderSource::Embedded, |folder| ShaderSource::Folder(folder.into()))
}
