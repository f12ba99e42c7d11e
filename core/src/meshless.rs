//! The meshless hierarchical basis (Lehtinen et al. 2008, "A Meshless Hierarchical Representation for Light Transport").

pub mod distance;
