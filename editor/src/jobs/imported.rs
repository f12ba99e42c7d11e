//! A scene that can be baked.

use lapidary_core::{
    animation::{Animation, AnimationError},
    dataset::scene_hash,
    ground::Ground,
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
    /// Tells whether a dataset was baked from it.
    pub hash: String,
    /// Seconds that the import took.
    pub import_secs: f64,
    /// Report of the import and its repairs.
    pub report: ImportReport,
    /// What moves in it, if anything does.
    pub animation: Option<Arc<Animation>>,
    trial: Arc<Tried<Trial>>,
    bounces: Arc<Tried<BounceTrial>>,
}

impl Imported {
    /// Imports a scene file; `allow_outside` lets it name files outside its folder.
    ///
    /// # Errors
    /// A file that cannot be read, or is no scene.
    pub fn read(path: &Path, allow_outside: bool) -> Result<Self, ImportError> {
        let start = Instant::now();
        let options = ImportOptions { allow_outside, ..Default::default() };
        let mut imported = import_with(path, &options)?;
        let animation = match animation::read(path, &options) {
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

    /// It without shadows, over a ground of this kind, to be seen until it is baked.
    pub fn unshadowed(&self, ground: Ground) -> Baked {
        Baked::begun(unshadowed((*self.scene).clone(), self.hash.clone(), ground))
    }

    /// What a bake of it will find. The first call that `may_begin` begins to find out, on a thread; later ones tell it when it
    /// is known.
    pub fn trial(&self, may_begin: bool) -> Option<Trial> {
        self.trial.get(&self.scene, may_begin, Trial::of)
    }

    /// The same for the parts that bounce light.
    pub fn bounce_trial(&self, may_begin: bool) -> Option<BounceTrial> {
        self.bounces.get(&self.scene, may_begin, BounceTrial::of)
    }
}

/// A trial of a scene, as far as it is.
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
            // It measures time, so that it is no guest.
            std::thread::spawn(move || tried.found.set(of(&scene)));
        }
        self.found.get().copied().flatten()
    }
}
