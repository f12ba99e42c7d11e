//! The texture pool: all textures that materials use, as 32-bit words in the rows of one 2D texture.
//!
//! Any number of textures of any size thus needs one binding, which WebGPU's default limits allow, and is looked up by the
//! same arithmetic as on the CPU. Textures that do not fit are halved, the largest first.

use super::scene::extent;
use crate::{
    appearance::Appearance,
    device::{
        GpuDevice,
        layout::constants::{KIND_FLOAT, KIND_LINEAR, KIND_SRGB, POOL_WIDTH_LOG2},
    },
};
use lapidary_core::{
    material::{BUMP, Material, NORMAL},
    texture::{ColorSpace, SlopeSource, Texels, Texture, TextureSlot, level_sizes},
};
use std::sync::Arc;

/// What the levels below a texture hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MipContent {
    /// Its texels in this encoding.
    Values(ColorSpace),
    /// Slopes.
    Slopes(SlopeSource),
}

impl MipContent {
    fn of(map: &str, slot: &TextureSlot, texture: &Texture) -> Self {
        match (map, &texture.texels) {
            (NORMAL, _) => Self::Slopes(SlopeSource::Normals),
            (BUMP, _) => Self::Slopes(SlopeSource::heights(slot)),
            (_, texels) => Self::Values(texels.distinct(slot.color_space)),
        }
    }

    /// The encoding of the texels of the texture itself.
    fn color_space(self) -> ColorSpace {
        match self {
            Self::Values(color_space) => color_space,
            Self::Slopes(_) => ColorSpace::Linear,
        }
    }

    /// How the shader decodes a texture. Texels of 16 bits and of other primaries are decoded before, to floats.
    fn kind(self, texture: &Texture) -> u32 {
        match self.color_space() {
            color_space if !texture.texels.keeps_codes(color_space) => KIND_FLOAT,
            ColorSpace::Srgb => KIND_SRGB,
            _ => KIND_LINEAR,
        }
    }
}

/// Where a texture with its levels lies in the pool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// First word.
    pub first: u32,
    /// Size in texels, after halving.
    pub size: [u32; 2],
    /// How the shader decodes it.
    pub kind: u32,
}

/// A texture in use, by its index, and what its levels hold. One that is read in two ways lies in the pool twice.
#[derive(Clone)]
struct Used {
    index: u32,
    detail: MipContent,
    texture: Arc<Texture>,
}

impl Used {
    fn is_same(&self, other: &Self) -> bool {
        (self.index, self.detail) == (other.index, other.detail) && Arc::ptr_eq(&self.texture, &other.texture)
    }
}

/// The uploaded textures.
pub struct TexturePool {
    pub view: wgpu::TextureView,
    places: Vec<Place>,
    /// The packed textures, to find them and to detect changes.
    packed: Vec<Used>,
}

impl TexturePool {
    /// Packs and uploads the textures in use. Also returns which were scaled, in sentences.
    pub fn new(gpu: &GpuDevice, appearance: &Appearance) -> (Self, Vec<String>) {
        let packed = in_use(appearance);
        let capacity = u64::from(gpu.limits.max_texture_dimension_2d) << POOL_WIDTH_LOG2;
        let (fitted, messages) = fit(&packed, capacity.min(u64::from(u32::MAX)));
        let mut words = Vec::new();
        let place = |used: &Used| {
            let first = words.len() as u32;
            append(&mut words, &used.texture, used.detail);
            Place { first, size: used.texture.size, kind: used.detail.kind(&used.texture) }
        };
        let places = fitted.iter().map(place).collect();
        (Self { view: upload(gpu, words), places, packed }, messages)
    }

    /// Where the texture of a slot lies, with the levels that this map needs.
    pub fn place(&self, map: &str, slot: &TextureSlot) -> Option<Place> {
        let is_wanted =
            |used: &Used| used.index == slot.texture && used.detail == MipContent::of(map, slot, &used.texture);
        self.packed.iter().position(is_wanted).map(|i| self.places[i])
    }

    /// Whether `appearance` uses the textures that were packed.
    pub fn serves(&self, appearance: &Appearance) -> bool {
        in_use(appearance).iter().all(|wanted| self.packed.iter().any(|used| used.is_same(wanted)))
    }
}

/// The textures that some slot refers to, each once for each way to read it.
fn in_use(appearance: &Appearance) -> Vec<Used> {
    let mut all: Vec<Used> = Vec::new();
    // What is stored and not rendered takes no memory from what is.
    let is_read = |m: &Material, map: &str| m.model.stored_parameter(map).is_none();
    let slots = appearance.materials.iter().flat_map(|m| m.maps.iter().filter(move |(map, _)| is_read(m, map)));
    for (map, slot) in slots.filter(|(_, slot)| slot.image().is_some()) {
        let texture = appearance.textures[slot.texture as usize].clone();
        let used = Used { index: slot.texture, detail: MipContent::of(map, slot, &texture), texture };
        if !all.iter().any(|other| other.is_same(&used)) {
            all.push(used);
        }
    }
    all
}

/// Words of a texture with its levels.
fn words_of(texture: &Texture, detail: MipContent) -> u64 {
    let texels = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
    let own = if texture.texels.keeps_codes(detail.color_space()) { 1 } else { 4 };
    let below = if matches!(detail, MipContent::Slopes(_)) { 3 } else { own };
    own * texels(texture.size) + below * level_sizes(texture.size).map(texels).sum::<u64>()
}

/// Halves the largest texture until all fit into `capacity` words.
fn fit(textures: &[Used], capacity: u64) -> (Vec<Used>, Vec<String>) {
    let words = |used: &Used| words_of(&used.texture, used.detail);
    let mut fitted = textures.to_vec();
    while fitted.iter().map(words).sum::<u64>() > capacity {
        let largest = fitted.iter_mut().max_by_key(|used| words(used));
        let Some(largest) = largest.filter(|used| used.texture.size != [1, 1]) else { break };
        largest.texture = Arc::new(halved(&largest.texture));
    }
    let scaled = textures.iter().zip(&fitted).map(|(a, b)| (&a.texture, &b.texture)).filter(|(a, b)| a.size != b.size);
    let message = |(a, b): (&Arc<Texture>, &Arc<Texture>)| {
        format!(
            "the texture \"{}\" was scaled from {} x {} to {} x {}: all textures together may take {} MB on this adapter",
            a.name,
            a.size[0],
            a.size[1],
            b.size[0],
            b.size[1],
            (4 * capacity) >> 20
        )
    };
    let messages = scaled.map(message).collect();
    (fitted, messages)
}

/// Half the size, rounded up; each texel is the mean of the four that it covers. Codes are averaged as they are,
/// which darkens hard edges a little.
fn halved(texture: &Texture) -> Texture {
    let [width, height] = texture.size;
    let size = [width.div_ceil(2), height.div_ceil(2)];
    let sources = |x: u32, y: u32| {
        let (x1, y1) = ((2 * x + 1).min(width - 1), (2 * y + 1).min(height - 1));
        [(2 * x, 2 * y), (x1, 2 * y), (2 * x, y1), (x1, y1)].map(|(x, y)| (y * width + x) as usize)
    };
    let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let float_mean = |t: &[[f32; 4]], x, y| {
        let quad = sources(x, y);
        std::array::from_fn(|c| quad.iter().map(|&i| t[i][c]).sum::<f32>() * 0.25)
    };
    let texels = match &texture.texels {
        Texels::U8(t) => {
            let mean = |i: [usize; 4], c: usize| ((i.iter().map(|&i| u32::from(t[i][c])).sum::<u32>() + 2) / 4) as u8;
            Texels::U8(positions.map(|(x, y)| std::array::from_fn(|c| mean(sources(x, y), c))).collect())
        }
        Texels::U16(t) => {
            let mean = |i: [usize; 4], c: usize| ((i.iter().map(|&i| u32::from(t[i][c])).sum::<u32>() + 2) / 4) as u16;
            Texels::U16(positions.map(|(x, y)| std::array::from_fn(|c| mean(sources(x, y), c))).collect())
        }
        Texels::F32(t) => Texels::F32(positions.map(|(x, y)| float_mean(t, x, y)).collect()),
        Texels::Wide { texels, to_rec_709 } => {
            Texels::Wide { texels: positions.map(|(x, y)| float_mean(texels, x, y)).collect(), to_rec_709: *to_rec_709 }
        }
    };
    Texture::new(texture.name.clone(), size, texels)
}

/// Appends a texture and its levels, the largest first.
fn append(words: &mut Vec<u32>, texture: &Texture, detail: MipContent) {
    append_texels(words, &texture.texels, detail.color_space());
    match detail {
        MipContent::Values(color_space) => {
            texture.levels(color_space).iter().for_each(|level| append_texels(words, &level.texels, level.color_space));
        }
        MipContent::Slopes(source) => {
            let texels = texture.slope_levels(source).iter().flat_map(|level| &level.texels);
            words.extend(texels.flat_map(|texel| texel.words()));
        }
    }
}

fn append_texels(words: &mut Vec<u32>, texels: &Texels, color_space: ColorSpace) {
    match texels {
        Texels::U8(t) if texels.keeps_codes(color_space) => words.extend(t.iter().map(|&c| u32::from_le_bytes(c))),
        _ => words.extend((0..texels.count()).flat_map(|i| texels.at(i, color_space).to_array().map(f32::to_bits))),
    }
}

fn upload(gpu: &GpuDevice, mut words: Vec<u32>) -> wgpu::TextureView {
    let width = 1_usize << POOL_WIDTH_LOG2;
    let rows = words.len().div_ceil(width).max(1);
    words.resize(rows * width, 0);
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("texture pool"),
        size: extent([width as u32, rows as u32]),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    super::scene::write_rows(gpu, &texture, 0, 4 * width, bytemuck::cast_slice(&words));
    texture.create_view(&Default::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(size: [u32; 2], value: u8) -> Arc<Texture> {
        let texels = vec![[value; 4]; (size[0] * size[1]) as usize];
        Arc::new(Texture::new("gray", size, Texels::U8(texels)))
    }

    #[test]
    fn textures_that_fit_stay_and_the_largest_is_halved_first() {
        let detail = MipContent::Values(ColorSpace::Linear);
        let used = |size, value| Used { index: 0, detail, texture: gray(size, value) };
        let textures = [used([64, 64], 7), used([8, 8], 9)];
        let needed = words_of(&textures[0].texture, detail) + words_of(&textures[1].texture, detail);
        let (fitted, messages) = fit(&textures, needed);
        assert!(messages.is_empty() && fitted[0].texture.size == [64, 64]);
        let (fitted, messages) = fit(&textures, needed - 1);
        assert_eq!([fitted[0].texture.size, fitted[1].texture.size], [[32, 32], [8, 8]]);
        assert!(messages.len() == 1 && messages[0].contains("64 x 64 to 32 x 32"), "{messages:?}");
    }

    #[test]
    fn maps_that_are_stored_and_not_rendered_take_no_room() {
        let mut material = Material { model: lapidary_core::material::BrdfModel::OpenPbr, ..Default::default() };
        material.maps.set("transmission_weight", Some(TextureSlot::default()));
        let used = |material: &Material| {
            let textures = vec![gray([8, 8], 9)];
            in_use(&Appearance { materials: vec![material.clone()], textures, assigned: None }).len()
        };
        assert_eq!(used(&material), 0);
        material.maps.set("coat_weight", Some(TextureSlot::default()));
        assert_eq!(used(&material), 1, "negative control");
    }

    #[test]
    fn what_is_packed_has_the_length_that_is_told() {
        let slopes = [SlopeSource::Normals, SlopeSource::heights(&Default::default())].map(MipContent::Slopes);
        let floats = Texture::new("floats", [5, 9], Texels::F32(vec![[0.5; 4]; 45]));
        let deep = Texture::new("deep", [5, 9], Texels::U16(vec![[700; 4]; 45]));
        let values = [ColorSpace::Srgb, ColorSpace::AcesCg].map(MipContent::Values);
        for detail in [values[0], values[1], slopes[0], slopes[1]] {
            for texture in [&*gray([16, 3], 100), &floats, &deep] {
                let mut words = Vec::new();
                append(&mut words, texture, detail);
                assert_eq!(words.len() as u64, words_of(texture, detail), "{detail:?}");
            }
        }
    }

    #[test]
    fn sixteen_bits_are_uploaded_as_floats_in_the_color_space_of_the_slot() {
        let deep = Texture::new("deep", [1, 1], Texels::U16(vec![[257 * 128, 300, 0, 65535]]));
        let red = |detail: MipContent| {
            let mut words = Vec::new();
            append(&mut words, &deep, detail);
            assert_eq!(detail.kind(&deep), KIND_FLOAT);
            f32::from_bits(words[0])
        };
        let [srgb, linear] = [ColorSpace::Srgb, ColorSpace::Linear].map(|space| red(MipContent::Values(space)));
        assert!((srgb - 0.21586).abs() < 1e-5 && (linear - 128.0 / 255.0).abs() < 1e-6, "{srgb} {linear}");
        assert_eq!(red(MipContent::Slopes(SlopeSource::Normals)), linear, "normals are values");
        let slot = TextureSlot { color_space: ColorSpace::Srgb, ..Default::default() };
        assert_eq!(MipContent::of("base_color", &slot, &deep), MipContent::Values(ColorSpace::Srgb));
    }

    #[test]
    fn halving_averages_and_keeps_odd_edges() {
        let texels = [0, 4, 8, 12, 16, 20].map(|v: u8| [v; 4]).to_vec();
        let odd = Texture::new("odd", [3, 2], Texels::U8(texels));
        let half = halved(&odd);
        assert_eq!(half.size, [2, 1]);
        assert_eq!(half.texels, Texels::U8(vec![[8; 4], [14; 4]]));
        let deep = [0, 400, 800, 1200, 1600, 2000].map(|v: u16| [v; 4]).to_vec();
        assert_eq!(
            halved(&Texture::new("deep", [3, 2], Texels::U16(deep))).texels,
            Texels::U16(vec![[800; 4], [1400; 4]])
        );
    }
}
