//! Textures for pictures of studies.

use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use lapidary_studies::sheet::DisplayPicture;

/// A picture as a texture, which replaces the pixels of the previous one, if any.
pub fn texture_of(
    ctx: &Context,
    name: &str,
    known: Option<TextureHandle>,
    shown: &DisplayPicture,
    how: TextureOptions,
) -> TextureHandle {
    let image = ColorImage::from_rgba_unmultiplied(shown.size.map(|s| s as usize), shown.pixels.as_flattened());
    match known {
        Some(mut texture) => {
            texture.set(image, how);
            texture
        }
        None => ctx.load_texture(name, image, how),
    }
}
