//! A dataset with its ray hierarchy: made once, shared by the CPU renderer, the references and picking.

use lapidary_core::{dataset::Dataset, ray::Intersector};
use std::sync::{Arc, OnceLock};

/// A dataset that is ready to be shown. Copying it is cheap.
#[derive(Clone)]
pub struct Baked {
    /// The dataset.
    pub dataset: Arc<Dataset>,
    intersector: Arc<OnceLock<Arc<Intersector>>>,
}

impl std::fmt::Debug for Baked {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Baked").field("report", &self.dataset.report).finish_non_exhaustive()
    }
}

impl<D: Into<Arc<Dataset>>> From<D> for Baked {
    fn from(dataset: D) -> Self {
        Self { dataset: dataset.into(), intersector: Arc::default() }
    }
}

impl Baked {
    /// Begins to build the ray hierarchy on its own thread, so that it is ready, or nearly, when it is needed.
    pub fn begun(dataset: impl Into<Arc<Dataset>>) -> Self {
        let baked = Self::from(dataset);
        let builds = baked.clone();
        std::thread::spawn(move || drop(builds.intersector()));
        baked
    }

    /// Casts rays on the mesh. Built at the first call, seconds for a million triangles; other callers wait for it, so
    /// call it from a thread that may wait.
    pub fn intersector(&self) -> Arc<Intersector> {
        self.intersector.get_or_init(|| Intersector::new(&self.dataset.scene.mesh).into()).clone()
    }

    /// [`Self::intersector`] if it has been built.
    pub fn intersector_if_ready(&self) -> Option<&Intersector> {
        self.intersector.get().map(|built| &**built)
    }

    /// Whether both are one dataset, or none.
    pub fn are_same(a: Option<&Self>, b: Option<&Self>) -> bool {
        match (a, b) {
            (Some(a), Some(b)) => a.is_same(b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }

    /// Whether both are the same dataset, not only equal ones.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.dataset, &other.dataset)
    }
}
