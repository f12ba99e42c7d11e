//! A scene that can be baked.

use lapidary_core::{
    animation::{Animation, AnimationError},
    dataset::{BakeSettings, scene_hash},
    scene::Scene,
};
use lapidary_interchange::{
    animation::{self, AnimationFileError},
    import::{ImportError, ImportOptions, ImportReport, import_with},
};
use lapidary_precompute::{BounceTrial, Trial, unshadowed};
use lapidary_render::Baked;
use std::{
    path::Path,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    time::Instant,
};

/// An imported scene.
#[derive(Clone, Debug)]
pub struct Imported {
    /// As imported.
    pub scene: Arc<Scene>,
    /// Identifies the scene in its datasets.
    pub hash: String,
    /// Seconds that the import took.
    pub import_secs: f64,
    /// Report of the import and its repairs.
    pub report: ImportReport,
    /// Its animation, if any.
    pub animation: Option<Arc<Animation>>,
    trial: Arc<Tried<Trial>>,
    bounces: Arc<Tried<BounceTrial>>,
}

impl Imported {
    /// Imports a scene of a file.
    ///
    /// # Errors
    /// A file that cannot be read, or is no scene.
    pub fn read(path: &Path, options: &ImportOptions) -> Result<Self, ImportError> {
        let start = Instant::now();
        let mut imported = import_with(path, options)?;
        let animation = match animation::read(path, options) {
            Ok(animation) => Some(animation.into()),
            Err(AnimationFileError::NoGltf { .. } | AnimationFileError::Unplayable(AnimationError::NoClips { .. })) => {
                None
            }
            Err(error) => {
                imported.report.warnings.push(error.to_string());
                None
            }
        };
        let hash = scene_hash(&imported.scene);
        let import_secs = start.elapsed().as_secs_f64();
        Ok(Self {
            scene: imported.scene.into(),
            hash,
            import_secs,
            report: imported.report,
            animation,
            trial: Arc::default(),
            bounces: Arc::default(),
        })
    }

    /// The scene without shadows, shown until it is baked with these settings: on the same ground, in the same light.
    pub fn unshadowed(&self, settings: &BakeSettings) -> Baked {
        Baked::begun(unshadowed((*self.scene).clone(), self.hash.clone(), settings))
    }

    /// Trial of a bake. The first call with `may_begin` starts it on a thread; later ones return its result once known.
    pub fn trial(&self, may_begin: bool) -> Option<Trial> {
        self.trial.get(&self.scene, may_begin, Trial::of)
    }

    /// The same for the parts that bounce light.
    pub fn bounce_trial(&self, may_begin: bool) -> Option<BounceTrial> {
        self.bounces.get(&self.scene, may_begin, BounceTrial::of)
    }
}

/// A trial of a scene, running or finished.
#[derive(Debug)]
struct Tried<T> {
    found: OnceLock<Option<T>>,
    has_begun: AtomicBool,
}

impl<T> Default for Tried<T> {
    fn default() -> Self {
        Self { found: OnceLock::new(), has_begun: AtomicBool::new(false) }
    }
}

impl<T: Copy + Send + Sync + 'static> Tried<T> {
    fn get(self: &Arc<Self>, scene: &Arc<Scene>, may_begin: bool, of: fn(&Scene) -> Option<T>) -> Option<T> {
        if may_begin && !self.has_begun.swap(true, Ordering::Relaxed) {
            let (scene, tried) = (scene.clone(), self.clone());
            // At full priority, since it measures time.
            std::thread::spawn(move || tried.found.set(of(&scene)));
        }
        self.found.get().copied().flatten()
    }
}
