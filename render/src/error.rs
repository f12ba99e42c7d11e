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

    /// Says that the CPU renders in place of an adapter, and why; `None` for an error that the CPU would have, too.
    pub fn cpu_instead(&self, adapter: &str, wording: Wording) -> Option<String> {
        Some(format!("the CPU renders in place of {}", self.of_adapter(adapter, wording)?))
    }

    /// The adapter, and why it will not do; `None` for an error that the CPU would have, too.
    pub fn of_adapter(&self, adapter: &str, wording: Wording) -> Option<String> {
        let why = match self {
            Self::Pose(_) => return None,
            Self::DeviceLost { reason } => format!("its device was lost ({reason}); update its driver"),
            Self::NoAdapter { reason } | Self::Driver(reason) => {
                format!("the graphics driver failed ({reason}); update it")
            }
            Self::Limit { what, needed, limit, unit, remedy: Remedy::Cpu, .. } => {
                format!("{what} need {needed} {unit}, but it allows {limit}")
            }
            Self::Limit { what, needed, limit, unit, remedy, .. } => {
                format!("{what} need {needed} {unit}, but it allows {limit}; {}", wording(*remedy))
            }
        };
        Some(format!("\"{adapter}\": {why}"))
    }
}

impl fmt::Display for BackendError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Remedy::words))
    }
}

impl Error for BackendError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cpu_stands_in_for_what_adapters_cannot_do_and_says_whose_place_it_takes() {
        let lost = BackendError::DeviceLost { reason: "unplugged".into() };
        let text = lost.cpu_instead("a card", Remedy::words).unwrap();
        assert!(text.contains("\"a card\"") && text.contains("unplugged") && !text.contains("starts again"), "{text}");
        let limit = BackendError::Limit {
            what: "the cuts",
            needed: 2,
            limit: 1,
            unit: "bytes",
            adapter: "a card".into(),
            remedy: Remedy::SmallerCuts,
        };
        let text = limit.cpu_instead("a card", Remedy::words).unwrap();
        assert!(text.contains("need 2 bytes") && text.contains("allows 1"), "{text}");
        let driver = BackendError::Driver("no such function".into()).cpu_instead("a card", Remedy::words).unwrap();
        assert!(![text, driver].iter().any(|text| text.contains(Remedy::Cpu.words())), "it does so already");
        let pose = BackendError::Pose(MeshError::Empty);
        assert_eq!(pose.cpu_instead("a card", Remedy::words), None, "negative control");
    }
}
