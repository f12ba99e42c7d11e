//! Small pictures of textures, made once for each.

use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use lapidary_core::{
    color::srgb_from_linear,
    texture::{ColorSpace, Texels, Texture},
};
use std::{
    collections::HashMap,
    sync::{Arc, Weak},
};

/// Pixels of the longer side.
const SIDE: u32 = 64;

/// Thumbnails by texture. The weak references keep addresses from being used again.
#[derive(Default)]
pub struct Thumbnails {
    made: HashMap<usize, (Weak<Texture>, TextureHandle)>,
}

impl Thumbnails {
    /// The thumbnail of `texture`.
    pub fn of(&mut self, context: &Context, texture: &Arc<Texture>) -> &TextureHandle {
        self.made.retain(|_, (texture, _)| texture.strong_count() > 0);
        let make = || {
            let handle = context.load_texture(texture.name.as_str(), shrunk(texture), TextureOptions::LINEAR);
            (Arc::downgrade(texture), handle)
        };
        &self.made.entry(Arc::as_ptr(texture) as usize).or_insert_with(make).1
    }
}

/// The texture at most [`SIDE`] pixels wide and high: means over at most four by four of the texels that each pixel covers.
pub(super) fn shrunk(texture: &Texture) -> ColorImage {
    let [w, h] = texture.size;
    let longer = w.max(h).max(SIDE);
    let [out_w, out_h] = [w, h].map(|side| (u64::from(side) * u64::from(SIDE) / u64::from(longer)).max(1) as u32);
    let pixel = |i: u32| {
        let (x, y) = (i % out_w, i / out_w);
        let mut sum = [0.0_f32; 3];
        for tap in 0..16 {
            let at = |p: u32, sub: u32, out: u32, size: u32| {
                (((p as f32 + (sub as f32 + 0.5) / 4.0) / out as f32 * size as f32) as u32).min(size - 1)
            };
            let texel = encoded_texel(texture, at(x, tap % 4, out_w, w), at(y, tap / 4, out_h, h));
            sum.iter_mut().zip(texel).for_each(|(s, t)| *s += t / 16.0);
        }
        let [r, g, b] = sum.map(|c| (c + 0.5) as u8);
        Color32::from_rgb(r, g, b)
    };
    ColorImage::new([out_w as usize, out_h as usize], (0..out_w * out_h).map(pixel).collect())
}

/// A texel as a picture viewer shows it, 0 to 255.
fn encoded_texel(texture: &Texture, x: u32, y: u32) -> [f32; 3] {
    let index = y as usize * texture.size[0] as usize + x as usize;
    match &texture.texels {
        Texels::U8(texels) => [0, 1, 2].map(|c| f32::from(texels[index][c])),
        Texels::U16(texels) => [0, 1, 2].map(|c| f32::from(texels[index][c]) / 257.0),
        Texels::F32(_) | Texels::Wide { .. } => {
            let texel = texture.texels.at(index, ColorSpace::Srgb);
            [0, 1, 2].map(|c| srgb_from_linear(texel[c]) * 255.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(size: [u32; 2], texel: impl Fn(u32) -> [u8; 4]) -> Arc<Texture> {
        let texels = Texels::U8((0..size[0] * size[1]).map(texel).collect());
        Texture::new("t", size, texels).into()
    }

    #[test]
    fn thumbnails_keep_the_shape_and_the_mean() {
        let image = shrunk(&texture([256, 64], |i| if i % 2 == 0 { [0, 0, 0, 255] } else { [200, 200, 200, 255] }));
        assert_eq!(image.size, [64, 16]);
        assert!(image.pixels.iter().all(|p| (95..=105).contains(&p.r())));
        assert_eq!(shrunk(&texture([1, 4000], |_| [7, 8, 9, 255])).size, [1, 64]);
        assert_eq!(shrunk(&texture([3, 2], |i| [i as u8 * 10, 0, 0, 255])).pixels[4].r(), 40);
        let deep = Texture::new("t", [1, 1], Texels::U16(vec![[257 * 40, 0, 0, 65535]]));
        assert_eq!(shrunk(&deep).pixels[0].r(), 40);
    }

    #[test]
    fn each_texture_is_shrunk_once_and_forgotten_with_it() {
        let (context, mut thumbnails) = (Context::default(), Thumbnails::default());
        let a = texture([2, 2], |_| [1, 1, 1, 255]);
        let first = thumbnails.of(&context, &a).id();
        assert_eq!(thumbnails.of(&context, &a).id(), first);
        let b = texture([2, 2], |_| [1, 1, 1, 255]);
        assert_ne!(thumbnails.of(&context, &b).id(), first, "negative control: another texture");
        drop(a);
        thumbnails.of(&context, &b);
        assert_eq!(thumbnails.made.len(), 1);
    }
}
