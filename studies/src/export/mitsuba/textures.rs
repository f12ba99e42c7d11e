//! Maps of materials as linear EXR files, multiplied by the parameters that they modulate.

use super::xml;
use anyhow::Result;
use glam::{Vec3, Vec4};
use lapidary_core::{
    image::Image,
    texture::{Procedural, Texture, TextureSlot, Wrap},
};
use lapidary_interchange::image;
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Writes maps, each once.
pub struct TextureFolder<'a> {
    folder: PathBuf,
    textures: &'a [Arc<Texture>],
    written: BTreeSet<String>,
}

impl<'a> TextureFolder<'a> {
    /// For the exported `folder` and the `textures` of a scene.
    pub fn new(folder: &Path, textures: &'a [Arc<Texture>]) -> Self {
        Self { folder: folder.to_owned(), textures, written: BTreeSet::new() }
    }

    /// The property `name`, or a nested texture without a name, with `value` applied to each texel. `stem` names the file; equal
    /// stems must mean equal maps.
    ///
    /// # Errors
    /// An unwritable file.
    pub fn property(
        &mut self,
        name: Option<&str>,
        stem: &str,
        slot: &TextureSlot,
        value: impl Fn(Vec4) -> Vec3,
    ) -> Result<String> {
        let file = format!("textures/{stem}.exr");
        if self.written.insert(file.clone()) {
            let texture = match &slot.procedural {
                Some(pattern) => Arc::new(pattern.baked(Procedural::BAKED)),
                None => self.textures[slot.texture as usize].clone(),
            };
            let texel = |x: u32, y: u32| value(texture.texel(x.into(), y.into(), slot.color_space));
            image::write(&Image::from_fn(texture.size, texel), &self.folder.join(&file))?;
        }
        let wrap = match slot.wrap[0] {
            _ if slot.procedural.is_some() => "repeat",
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
        };
        let properties = xml::value("string", "filename", file)
            + &xml::value("boolean", "raw", true)
            + &xml::value("string", "wrap_mode", wrap)
            + &to_uv(slot);
        let name = name.map(|name| format!(" name=\"{name}\"")).unwrap_or_default();
        Ok(xml::plugin("texture", "bitmap", &name, &properties))
    }
}

/// A slot's transform. Its rotation turns the map rather than the coordinates, hence the sign.
fn to_uv(slot: &TextureSlot) -> String {
    let TextureSlot { scale, offset, rotation, .. } = slot;
    format!(
        "  <transform name=\"to_uv\"><scale x=\"{}\" y=\"{}\"/><rotate z=\"1\" angle=\"{}\"/><translate x=\"{}\" y=\"{}\"/></transform>\n",
        scale.x,
        scale.y,
        -rotation.to_degrees(),
        offset.x,
        offset.y
    )
}
