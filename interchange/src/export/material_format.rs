//! The list of all formats of materials.

use super::{ExportError, ExportOptions, Exported, gltf, write_library, write_materialx};
use crate::file_format::FileFormat;
use lapidary_core::scene::Scene;
use std::path::Path;

/// Writes all materials of a scene.
type Export = fn(&Scene, &Path, &ExportOptions) -> Result<Exported, ExportError>;

/// A format of materials.
pub struct MaterialFormat {
    /// Name for people.
    pub label: &'static str,
    endings: &'static [&'static str],
    /// Whether a material can be read from a file and saved to one.
    pub loads: bool,
    /// Whether a file can be a copy of that of a scene, with its materials written anew.
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
    /// Names of those that all materials of a scene can be written in.
    pub fn exported() -> Vec<&'static str> {
        Self::ALL.iter().filter(|format| format.exports()).map(|format| format.label).collect()
    }

    /// Whether all materials of a scene can be written in it.
    pub fn exports(&self) -> bool {
        self.export.is_some()
    }
}
