//! Pictures whose components come from several textures: glTF packs roughness and metalness into one. Also the list of
//! all pictures of a file.

use crate::image::encode_png_pixels;
use glam::Vec2;
use lapidary_core::{
    color::srgb_from_linear,
    texture::{Channel, ColorSpace, Texture, TextureSlot, Wrap},
};
use serde_json::{Value, json};
use std::{collections::HashMap, sync::Arc};

/// Source of a component of a new picture.
#[derive(Clone, Copy)]
pub struct Component {
    /// The texture and its component; `None` is white.
    of: Option<(u32, Channel, ColorSpace)>,
    inverted: bool,
}

impl Component {
    /// White.
    pub const ONE: Self = Self { of: None, inverted: false };

    /// A component of a slot's texture.
    pub fn of(slot: &TextureSlot, channel: Channel) -> Self {
        Self { of: Some((slot.texture, channel, slot.color_space)), inverted: false }
    }

    /// One minus the component.
    pub fn inverted(self) -> Self {
        Self { inverted: true, ..self }
    }

    fn texture<'a>(&self, textures: &'a [Arc<Texture>]) -> Option<&'a Texture> {
        self.of.map(|(texture, ..)| &*textures[texture as usize])
    }

    fn value(&self, textures: &[Arc<Texture>], uv: Vec2, wrap: [Wrap; 2]) -> f32 {
        let Some((texture, channel, color_space)) = self.of else { return 1.0 };
        let value = textures[texture as usize].sample(uv, color_space, wrap)[channel as usize];
        if self.inverted { 1.0 - value } else { value }
    }
}

/// A new picture.
pub struct Picture {
    /// Red, green, blue and alpha.
    pub components: [Component; 4],
    /// Whether colors are sRGB encoded.
    pub encodes: bool,
    /// What is shown beyond its edges.
    pub wrap: [Wrap; 2],
}

impl Picture {
    /// Renders an 8-bit picture, as large as its largest source.
    pub fn png(&self, textures: &[Arc<Texture>]) -> Vec<u8> {
        let sizes = self.components.iter().filter_map(|component| component.texture(textures)).map(|t| t.size);
        let size = sizes.fold([1, 1], |[w, h], size| [w.max(size[0]), h.max(size[1])]);
        let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
        let pixel = |x: u32, y: u32| {
            let uv = Vec2::new((x as f32 + 0.5) / size[0] as f32, (y as f32 + 0.5) / size[1] as f32);
            let [r, g, b, a] = self.components.each_ref().map(|component| component.value(textures, uv, self.wrap));
            let encode = |x: f32| byte(if self.encodes { srgb_from_linear(x) } else { x });
            [encode(r), encode(g), encode(b), byte(a)]
        };
        let pixels: Vec<[u8; 4]> =
            (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        encode_png_pixels(size, &pixels)
    }
}

/// The mean of a slot's component.
pub fn mean(texture: &Texture, slot: &TextureSlot) -> f32 {
    texture.mean(slot.color_space)[slot.channel as usize]
}

/// The pictures and textures of a file that materials refer to.
#[derive(Default)]
pub struct Textures {
    /// The file's texture for a texture of the scene and what it shows beyond its edges, if it has one.
    pub known: HashMap<(u32, [Wrap; 2]), usize>,
    /// Number of textures, pictures and samplers in the file.
    pub textures: usize,
    pub images: usize,
    pub samplers: usize,
    /// New pictures.
    pub pictures: Vec<Arc<[u8]>>,
    /// New textures: the number of their new picture, and what they show beyond its edges.
    pub new: Vec<(usize, [Wrap; 2])>,
    /// New samplers.
    pub wraps: Vec<[Wrap; 2]>,
}

impl Textures {
    /// The texture of a slot in the file.
    pub fn known(&self, slot: &TextureSlot) -> Option<usize> {
        self.known.get(&(slot.texture, slot.wrap)).copied()
    }

    /// The texture of a picture, added on first use.
    pub fn of_bytes(&mut self, bytes: Arc<[u8]>, wrap: [Wrap; 2]) -> usize {
        let picture = index_in(&mut self.pictures, bytes);
        if wrap != [Wrap::Repeat; 2] {
            index_in(&mut self.wraps, wrap);
        }
        self.textures + index_in(&mut self.new, (picture, wrap))
    }

    /// The elements to add to `textures`.
    pub fn new_textures(&self) -> Vec<Value> {
        let texture = |(picture, wrap): &(usize, [Wrap; 2])| {
            let mut texture = json!({"source": self.images + picture});
            if let Some(sampler) = self.wraps.iter().position(|known| known == wrap) {
                texture["sampler"] = (self.samplers + sampler).into();
            }
            texture
        };
        self.new.iter().map(texture).collect()
    }

    /// The elements to add to `samplers`.
    pub fn new_samplers(&self) -> Vec<Value> {
        let mode = |wrap| match wrap {
            Wrap::Repeat => 10_497,
            Wrap::Mirror => 33_648,
            Wrap::Clamp => 33_071,
        };
        self.wraps.iter().map(|[u, v]| json!({"wrapS": mode(*u), "wrapT": mode(*v)})).collect()
    }
}

/// The place of an item in a list, added on first use.
fn index_in<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    let known = list.iter().position(|known| *known == item);
    known.unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    })
}
