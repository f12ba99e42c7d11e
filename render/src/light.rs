//! The light of a picture: the environment on its tree, local lights, and the bounced light of both.

pub(crate) mod bounce;
pub(crate) mod buried;
pub(crate) mod components;
pub(crate) mod drift;
pub(crate) mod environment;
pub(crate) mod implicit;
pub(crate) mod local;
pub(crate) mod mirrored_map;
pub(crate) mod node_row;
pub(crate) mod situation;
pub(crate) mod solver;

/// How bright each node of a tree is somewhere, over the mean of the whole tree: the root of the mean square of the
/// leaves' intensities, and at least 1. From `means` and mean squares by heap index.
///
/// A lobe that hardly looks at a node still shows it, in proportion to its light.
pub(crate) fn brightness(means: &[f32], means_sq: &[f32]) -> Vec<f32> {
    let of_node = |sq: &f32| {
        let ratio = sq.sqrt() / means[1];
        if ratio.is_finite() { ratio.max(1.0) } else { 1.0 }
    };
    means_sq.iter().map(of_node).collect()
}
