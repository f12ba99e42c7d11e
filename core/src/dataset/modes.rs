//! How the surface sources were made.

use super::BakeAudit;
use crate::cut::SourceCriterion;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Settings of the parts that bounce light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndirectSettings {
    /// Number of surface sources, `2^H`, at most 32,768.
    pub sources: usize,
    /// How fine the vertices' cuts over the sources are.
    pub criterion: SourceCriterion,
    /// A point in the open that separates reachable surfaces from enclosed ones; `None` for that of a camera or a local
    /// light, or a search.
    pub viewpoint: Option<Vec3>,
}

impl Default for IndirectSettings {
    fn default() -> Self {
        Self { sources: 32_768, criterion: SourceCriterion::default(), viewpoint: None }
    }
}

/// Report of the bake of the surface sources.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct IndirectReport {
    /// The viewpoint that was used.
    pub viewpoint: [f32; 3],
    /// Surface sources.
    pub sources: usize,
    /// Least distance of any two in position and normal, in meters.
    pub radius: f32,
    /// Largest spacing of the sources; 0 for a dataset with equal spacing.
    pub widest_spacing: f32,
    /// Total area in m² of the sources: the surface that light reaches.
    pub area: f64,
    /// Number of sources without area, which bounce no light.
    pub without_area: usize,
    /// Mean number of nodes of a bake point's cut over the sources.
    pub mean_cut: f64,
    /// Largest of these cuts.
    pub max_cut: usize,
    /// Root mean square over the bake points, which several vertices may share, of `||stored - traced|| / ||traced||`
    /// for solid angles, of what boundaries tell ([`Self::audit`] has what they miss). It was measured before cuts were
    /// coarsened to fit a texture.
    pub relative_error: f64,
    /// Factor by which the bounds of these cuts were raised to fit a texture, if they were.
    pub coarsened: Option<f32>,
    /// Mean number of nodes of a source's cut over the environment.
    pub mean_environment_cut: f64,
    /// Bytes of both kinds of cuts.
    pub bytes_cuts: u64,
    /// Rays traced between vertices and sources, and around vertices for near ones.
    pub rays_traced: u64,
    /// What following boundaries between distant sources has missed; `None` for an exhaustive bake.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub audit: Option<BakeAudit>,
}

impl IndirectReport {
    /// How distant sources were traced: sources for each that is probed, 1 if every one is.
    pub fn sources_per_probe(&self) -> usize {
        self.audit.map_or(1, |audit| audit.leaves_per_probe)
    }

    /// The criterion that the cuts over the sources meet, where `asked` was asked for.
    pub fn criterion(&self, asked: SourceCriterion) -> SourceCriterion {
        self.coarsened.map_or(asked, |factor| asked.coarser(factor))
    }
}

/// A sigma as text: as it was asked for, or rounded, with the one asked for, where a limit of size raised it.
pub fn sigma_text(held: f32, asked: f32) -> String {
    if held == asked {
        return asked.to_string();
    }
    let rounded = format!("{held:.2e}").parse().unwrap_or(held);
    format!("{rounded} ({asked} asked for)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sigma_that_a_limit_raised_is_told_rounded_and_others_as_asked() {
        assert_eq!(sigma_text(2.0 * 1.05_f32.powi(2), 2.0), "2.2 (2 asked for)");
        assert_eq!(sigma_text(2.0 * 1.05_f32.powi(3), 2.0), "2.32 (2 asked for)");
        assert_eq!(sigma_text(0.001_234_5, 0.001_234_5), "0.0012345");
    }
}
