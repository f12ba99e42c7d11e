//! A scene that can be baked.

use lapidary_core::{
    dataset::scene_hash,
    import::{ImportError, ImportOptions, ImportReport, import_with},
    scene::Scene,
};
use std::{path::Path, sync::Arc, time::Instant};

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
}

impl Imported {
    /// Imports a scene file; `allow_outside` lets it name files outside its folder.
    ///
    /// # Errors
    /// A file that cannot be read, or is no scene.
    pub fn read(path: &Path, allow_outside: bool) -> Result<Self, ImportError> {
        let start = Instant::now();
        let imported = import_with(path, &ImportOptions { allow_outside, ..Default::default() })?;
        let hash = scene_hash(&imported.scene);
        let import_secs = start.elapsed().as_secs_f64();
        Ok(Self { scene: imported.scene.into(), hash, import_secs, report: imported.report })
    }
}
