//! Errors of renderers.

use crate::remedy::{Remedy, Wording};
use lapidary_core::scene::MeshError;
use std::{error::Error, fmt};

/// Why a renderer cannot continue.
#[derive(Debug)]
pub enum BackendError {
    /// No adapter can be used.
    NoAdapter {
        /// Why no adapter can be used.
        reason: String,
    },
    /// The adapter was removed or reset.
    DeviceLost {
        /// Message of the driver.
        reason: String,
    },
    /// Something is larger than the adapter can hold.
    Limit {
        /// The oversized data.
        what: &'static str,
        /// Needed size.
        needed: u64,
        /// Largest allowed size.
        limit: u64,
        /// Unit of both.
        unit: &'static str,
        /// The adapter with this limit.
        adapter: String,
        /// Remedy; the CPU has no such limit on baked data.
        remedy: Remedy,
    },
    /// The driver failed.
    Driver(String),
    /// Objects are posed out of range.
    Pose(MeshError),
}

impl BackendError {
    /// The message, with remedies in `wording`.
    pub fn text(&self, wording: Wording) -> String {
        let cpu = wording(Remedy::Cpu);
        match self {
            Self::NoAdapter { reason } => format!(
                "there is no graphics adapter that can be used ({reason}); install a Vulkan, Metal or DirectX 12 driver, \
                 or {cpu}"
            ),
            Self::DeviceLost { reason } => {
                format!("the graphics device was lost ({reason}); the renderer starts again on it, or {cpu}")
            }
            Self::Limit { what, needed, limit, unit, adapter, remedy } => {
                let or_cpu = if *remedy == Remedy::SmallerPicture { String::new() } else { format!(", or {cpu}") };
                let remedy = wording(*remedy);
                format!("{what} need {needed} {unit}, but the adapter \"{adapter}\" allows {limit}; {remedy}{or_cpu}")
            }
            Self::Pose(source) => format!("the objects cannot be posed this way: {source}"),
            Self::Driver(reason) => format!("the graphics driver failed ({reason}); update it, or {cpu}"),
        }
    }
}

impl fmt::Display for BackendError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Remedy::words))
    }
}

impl Error for BackendError {}
