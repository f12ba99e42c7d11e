//! The audit of a bake that follows boundaries.

use serde::{Deserialize, Serialize};

/// Some vertices, traced once as in the bake and once against every light or surface source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BakeAudit {
    /// Number of audited bake points.
    pub vertices: usize,
    /// Share of their leaves, lights or sources, whose baked visibility is wrong, 0 to 1.
    pub leaves_wrong: f64,
    /// Root mean square of stored minus traced visibility over vertices and lights. For sources, root mean square of
    /// `||stored - traced||` of solid angles, as a share of a vertex's `||traced||`, or of its mean where that is larger.
    pub rms_error: f64,
    /// The same error of cuts selected from the traced values, as in an exhaustive bake.
    pub rms_exhaustive: f64,
    /// Leaves per probe. 1 where the audit of fewer probes failed: every leaf is traced.
    #[serde(alias = "lights_per_probe")]
    pub leaves_per_probe: usize,
}
