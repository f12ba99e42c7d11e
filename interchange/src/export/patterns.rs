//! Converts patterns to pictures, for formats without patterns.

use crate::image::{encode_png_pixels, srgb_bytes};
use lapidary_core::{
    material::map_color_space,
    scene::Scene,
    texture::{ColorSpace, Procedural, Texels, Texture, TextureSlot},
};
use std::borrow::Cow;

/// The scene with an 8-bit picture of 1024 x 1024 texels in place of each pattern.
pub fn as_pictures(scene: &Scene) -> Cow<'_, Scene> {
    let has_pattern = |slot: &TextureSlot| slot.procedural.is_some();
    if !scene.materials.iter().any(|material| material.maps.slots().any(has_pattern)) {
        return Cow::Borrowed(scene);
    }
    let mut scene = scene.clone();
    let Scene { materials, textures, .. } = &mut scene;
    for material in materials {
        let patterns: Vec<String> =
            material.maps.iter().filter(|(_, slot)| has_pattern(slot)).map(|(name, _)| name.to_owned()).collect();
        for name in patterns {
            let Some(slot) = material.maps.get_mut(&name) else { continue };
            let Some(pattern) = slot.procedural.take() else { continue };
            (slot.texture, slot.color_space) = (textures.len() as u32, map_color_space(&name));
            // As patterns do.
            slot.wrap = Default::default();
            textures.push(picture(&pattern, slot.color_space).into());
        }
    }
    Cow::Owned(scene)
}

fn picture(pattern: &Procedural, color_space: ColorSpace) -> Texture {
    let baked = pattern.baked(Procedural::BAKED);
    let texel = |i: u32| {
        let [x, y] = [i % Procedural::BAKED, i / Procedural::BAKED].map(i64::from);
        let value = baked.texel(x, y, ColorSpace::Linear).truncate();
        let [r, g, b] = match color_space {
            ColorSpace::Srgb => srgb_bytes(value),
            _ => value.to_array().map(|x| (255.0 * x).round() as u8),
        };
        [r, g, b, 255]
    };
    let texels: Vec<[u8; 4]> = (0..Procedural::BAKED * Procedural::BAKED).map(texel).collect();
    let encoded = encode_png_pixels([Procedural::BAKED; 2], &texels).into();
    Texture { encoded, ..Texture::new(baked.name, baked.size, Texels::U8(texels)) }
}
