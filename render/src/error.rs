//! Why a renderer cannot go on.

use crate::remedy::{Remedy, Wording};
use lapidary_core::scene::MeshError;
use std::{error::Error, fmt};

/// Why a renderer cannot go on.
#[derive(Debug)]
pub enum BackendError {
    /// There is nothing to render on.
    NoAdapter {
        /// Why none can be used.
        reason: String,
    },
    /// The adapter went away or was reset.
    DeviceLost {
        /// Message of the driver.
        reason: String,
    },
    /// Something is larger than the adapter can hold.
    Limit {
        /// The data that are too large.
        what: &'static str,
        /// How much it needs.
        needed: u64,
        /// How much there may be.
        limit: u64,
        /// Unit of both.
        unit: &'static str,
        /// Whose limit it is.
        adapter: String,
        /// What to do; the CPU has no such limit on what is baked.
        remedy: Remedy,
    },
    /// The driver refused.
    Driver(String),
    /// Objects are posed out of reach.
    Pose(MeshError),
}

impl BackendError {
    /// In words, with remedies told by `wording`.
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
