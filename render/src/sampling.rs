//! How the BRDF is sampled.

use serde::{Deserialize, Serialize};

/// Which cuts are merged, and how the BRDF is sampled on the nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BrdfSampling {
    /// Stored cuts and the illumination cut; the BRDF once per node at its direction, as in the paper (Eq. 6).
    Once,
    /// The same cuts. Nodes too wide for the lobe are split, and the lobe is filtered by the remaining width.
    Refine,
    /// Lit cuts, and the stored cuts below nodes too wide for the lobe; then as [`Self::Refine`].
    #[default]
    Lit,
}
