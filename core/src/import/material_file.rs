//! A material as a JSON file of its own: like [`Material`], but its maps name picture files beside it.

use super::{ImportError, read_file, textures::find_file};
use crate::{
    image::{ImageError, decode},
    input,
    material::{BrdfModel, BrdfParameters, MapKind, Maps, Material},
    scene::Scene,
    texture::{Channel, ColorSpace, TextureSlot},
};
use glam::Vec2;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The contents of a material file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaterialFile {
    /// Name of the material; the file's name if empty.
    pub name: String,
    /// Reflectance model.
    pub model: BrdfModel,
    /// Values that the maps multiply.
    pub parameters: BrdfParameters,
    /// Picture files.
    pub maps: MapFiles,
    /// Both sides reflect.
    pub double_sided: bool,
}

/// The maps of a [`MaterialFile`].
pub type MapFiles = Maps<SlotFile>;

/// A picture in use; see [`TextureSlot`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlotFile {
    /// The picture, relative to the material file.
    pub file: String,
    /// Colour space of 8-bit texels; by default sRGB for the base colour and linear for all else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color_space: Option<ColorSpace>,
    /// Component for scalar parameters.
    #[serde(default)]
    pub channel: Channel,
    /// Repetitions across the unit square.
    #[serde(default = "one")]
    pub scale: Vec2,
    /// Added after scaling and rotating.
    #[serde(default)]
    pub offset: Vec2,
    /// Counter-clockwise rotation of the coordinates in degrees.
    #[serde(default)]
    pub rotation_degrees: f32,
    /// Scales normals and heights.
    #[serde(default = "full_strength")]
    pub strength: f32,
    /// Normals have their green channel down (DirectX).
    #[serde(default)]
    pub flip_y: bool,
}

fn one() -> Vec2 {
    Vec2::ONE
}

fn full_strength() -> f32 {
    1.0
}

/// Reads a material file, and adds its pictures to the textures of `scene` unless they are there already.
///
/// # Errors
/// A file or picture that cannot be read, or contents that are no material. The scene is unchanged then.
pub fn load_material(path: &Path, scene: &mut Scene) -> Result<Material, ImportError> {
    let parse_error =
        |e: serde_json::Error| ImportError::Parse { path: path.into(), format: "a material", reason: e.to_string() };
    let file: MaterialFile = serde_json::from_slice(&read_file(path)?).map_err(parse_error)?;
    let before = scene.textures.len();
    let load = |kind: MapKind, slot: &SlotFile| load_slot(slot, kind.color_space(), path, scene);
    let maps = file.maps.try_map(load).inspect_err(|_| scene.textures.truncate(before))?;
    let stem = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Material {
        name: if file.name.is_empty() { stem() } else { file.name },
        model: file.model,
        parameters: file.parameters.sanitized(),
        maps,
        double_sided: file.double_sided,
    })
}

fn load_slot(
    slot: &SlotFile,
    default_space: ColorSpace,
    material: &Path,
    scene: &mut Scene,
) -> Result<TextureSlot, ImportError> {
    let folder = material.parent().unwrap_or(Path::new(""));
    let path = find_file(folder, &slot.file).unwrap_or_else(|| folder.join(&slot.file));
    let bytes = input::read(&path).map_err(|source| ImageError::Io { action: "read", path: path.clone(), source })?;
    let known = scene.textures.iter().position(|t| *t.encoded == *bytes);
    let texture = match known {
        Some(index) => index,
        None => {
            let mut texture = decode(&bytes, &path)?;
            texture.name.clone_from(&slot.file);
            scene.textures.push(texture.into());
            scene.textures.len() - 1
        }
    };
    Ok(TextureSlot {
        texture: texture as u32,
        color_space: slot.color_space.unwrap_or(default_space),
        channel: slot.channel,
        scale: slot.scale,
        offset: slot.offset,
        rotation: slot.rotation_degrees.to_radians(),
        strength: slot.strength,
        flip_y: slot.flip_y,
    })
}
