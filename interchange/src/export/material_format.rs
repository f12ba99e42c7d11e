//! The list of material formats.

use super::{ExportError, ExportOptions, Exported, gltf, write_library, write_materialx};
use crate::file_format::FileFormat;
use lapidary_core::scene::Scene;
use std::path::Path;

/// Writes all materials of a scene.
type Export = fn(&Scene, &Path, &ExportOptions) -> Result<Exported, ExportError>;

/// A format of materials.
pub struct MaterialFormat {
    /// Display name.
    pub label: &'static str,
    endings: &'static [&'static str],
    /// Whether a single material can be loaded and saved.
    pub loads: bool,
    /// Whether a file can be a copy of the scene's file with rewritten materials.
    pub copies_scene: bool,
    /// Writes all materials of a scene, if the format can.
    pub(super) export: Option<Export>,
}

impl FileFormat for MaterialFormat {
    const ALL: &'static [Self] = &[
        Self { label: "JSON", endings: &["json"], loads: true, copies_scene: false, export: None },
        Self {
            label: "MaterialX",
            endings: &["mtlx"],
            loads: true,
            copies_scene: false,
            export: Some(write_materialx),
        },
        Self { label: "MTL", endings: &["mtl"], loads: false, copies_scene: false, export: Some(write_library) },
        Self { label: "glTF", endings: &["gltf", "glb"], loads: false, copies_scene: true, export: Some(gltf::write) },
    ];

    fn endings(&self) -> &'static [&'static str] {
        self.endings
    }
}

impl MaterialFormat {
    /// Names of the formats that can hold all materials of a scene.
    pub fn exported() -> Vec<&'static str> {
        Self::ALL.iter().filter(|format| format.exports()).map(|format| format.label).collect()
    }

    /// Whether it can hold all materials of a scene.
    pub fn exports(&self) -> bool {
        self.export.is_some()
    }
}
