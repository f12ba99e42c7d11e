//! The audit of a bake that follows boundaries.

use serde::{Deserialize, Serialize};

/// Some vertices, traced once as the bake does and once against every light, or every surface source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BakeAudit {
    /// Bake points that were audited.
    pub vertices: usize,
    /// Share of their leaves, lights or sources, that the bake takes for seen and are blocked, or the reverse; 0 to 1.
    pub leaves_wrong: f64,
    /// Root mean square over them and their lights of stored minus traced visibility; of sources that of
    /// `||stored - traced||` for solid angles, as a share of a vertex's `||traced||`, or of its mean where that is larger.
    pub rms_error: f64,
    /// The same of cuts that were selected from what was traced: what an exhaustive bake would have.
    pub rms_exhaustive: f64,
    /// Leaves for each that is probed. 1 where the audit of fewer probes failed: every one is traced.
    #[serde(alias = "lights_per_probe")]
    pub leaves_per_probe: usize,
}
