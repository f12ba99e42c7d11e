//! A dataset that is ready to be shown.

use lapidary_core::{dataset::Dataset, ray::Intersector};
use std::sync::Arc;

/// A dataset and what picking needs.
#[derive(Clone)]
pub struct Baked {
    /// The dataset.
    pub dataset: Arc<Dataset>,
    /// Made of its mesh.
    pub intersector: Arc<Intersector>,
}

impl std::fmt::Debug for Baked {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Baked").field("report", &self.dataset.report).finish_non_exhaustive()
    }
}

impl Baked {
    /// Takes a while for large meshes: not for the window's thread.
    pub fn new(dataset: Arc<Dataset>) -> Self {
        let intersector = Arc::new(Intersector::new(&dataset.scene.mesh));
        Self { dataset, intersector }
    }
}
