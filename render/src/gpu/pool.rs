//! The texture pool: all textures that materials use, as 32-bit words in the rows of one 2D texture.
//!
//! Any number of textures of any size thus needs one binding, which WebGPU's default limits allow, and is looked up by the
//! same arithmetic as on the CPU. Textures that do not fit are halved, the largest first.

use super::{
    device::GpuDevice,
    layout::constants::{KIND_FLOAT, KIND_LINEAR, KIND_SRGB, POOL_WIDTH_LOG2},
    scene::extent,
};
use crate::appearance::Appearance;
use lapidary_core::texture::{ColorSpace, Texels, Texture};
use std::sync::Arc;

/// Where a texture lies in the pool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// First word.
    pub first: u32,
    /// Size in texels, after halving.
    pub size: [u32; 2],
    float: bool,
}

impl Place {
    /// How the shader decodes it.
    pub fn kind(&self, color_space: ColorSpace) -> u32 {
        match (self.float, color_space) {
            (true, _) => KIND_FLOAT,
            (false, ColorSpace::Linear) => KIND_LINEAR,
            (false, ColorSpace::Srgb) => KIND_SRGB,
        }
    }
}

/// The uploaded textures.
pub struct TexturePool {
    pub view: wgpu::TextureView,
    /// Indexed by the appearance's texture; `None` for textures not in use.
    pub places: Vec<Option<Place>>,
    /// The packed textures, to detect changes.
    packed: Vec<Option<Arc<Texture>>>,
}

impl TexturePool {
    /// Packs and uploads the textures in use. Also returns which were scaled, in sentences.
    pub fn new(gpu: &GpuDevice, appearance: &Appearance) -> (Self, Vec<String>) {
        let packed = in_use(appearance);
        let capacity = u64::from(gpu.limits.max_texture_dimension_2d) << POOL_WIDTH_LOG2;
        let (fitted, messages) = fit(&packed, capacity.min(u64::from(u32::MAX)));
        let mut words = Vec::new();
        let mut place = |texture: &Arc<Texture>| {
            let first = words.len() as u32;
            append(&mut words, texture);
            Place { first, size: texture.size, float: matches!(texture.texels, Texels::F32(_)) }
        };
        let places = fitted.iter().map(|t| t.as_ref().map(&mut place)).collect::<Vec<_>>();
        (Self { view: upload(gpu, words), places, packed }, messages)
    }

    /// Whether `appearance` uses the textures that were packed.
    pub fn serves(&self, appearance: &Appearance) -> bool {
        let wanted = in_use(appearance);
        let same = |(a, b): (&Option<Arc<Texture>>, &Option<Arc<Texture>>)| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (_, None) => true,
            (None, Some(_)) => false,
        };
        wanted.len() <= self.packed.len() && self.packed.iter().zip(&wanted).all(same)
    }
}

/// The textures that some slot refers to, by index.
fn in_use(appearance: &Appearance) -> Vec<Option<Arc<Texture>>> {
    let mut used = vec![None; appearance.textures.len()];
    for slot in appearance.materials.iter().flat_map(|m| m.maps.slots()) {
        used[slot.texture as usize] = Some(appearance.textures[slot.texture as usize].clone());
    }
    used
}

fn words_of(texture: &Texture) -> u64 {
    let texels = u64::from(texture.size[0]) * u64::from(texture.size[1]);
    if matches!(texture.texels, Texels::F32(_)) { 4 * texels } else { texels }
}

/// Halves the largest texture until all fit into `capacity` words.
fn fit(textures: &[Option<Arc<Texture>>], capacity: u64) -> (Vec<Option<Arc<Texture>>>, Vec<String>) {
    let mut fitted = textures.to_vec();
    while fitted.iter().flatten().map(|t| words_of(t)).sum::<u64>() > capacity {
        let largest = fitted.iter_mut().flatten().max_by_key(|t| words_of(t));
        let Some(largest) = largest.filter(|t| t.size != [1, 1]) else { break };
        *largest = Arc::new(halved(largest));
    }
    let scaled = textures.iter().flatten().zip(fitted.iter().flatten()).filter(|(a, b)| a.size != b.size);
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

/// Half the size, rounded up; each texel is the mean of the four that it covers. sRGB codes are averaged as they are,
/// which darkens hard edges a little.
fn halved(texture: &Texture) -> Texture {
    let [width, height] = texture.size;
    let size = [width.div_ceil(2), height.div_ceil(2)];
    let sources = |x: u32, y: u32| {
        let (x1, y1) = ((2 * x + 1).min(width - 1), (2 * y + 1).min(height - 1));
        [(2 * x, 2 * y), (x1, 2 * y), (2 * x, y1), (x1, y1)].map(|(x, y)| (y * width + x) as usize)
    };
    let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let texels = match &texture.texels {
        Texels::U8(t) => {
            let mean = |i: [usize; 4], c: usize| ((i.iter().map(|&i| u32::from(t[i][c])).sum::<u32>() + 2) / 4) as u8;
            Texels::U8(positions.map(|(x, y)| std::array::from_fn(|c| mean(sources(x, y), c))).collect())
        }
        Texels::F32(t) => {
            let mean = |i: [usize; 4], c: usize| i.iter().map(|&i| t[i][c]).sum::<f32>() * 0.25;
            Texels::F32(positions.map(|(x, y)| std::array::from_fn(|c| mean(sources(x, y), c))).collect())
        }
    };
    Texture { name: texture.name.clone(), size, texels, encoded: Arc::from([]) }
}

fn append(words: &mut Vec<u32>, texture: &Texture) {
    match &texture.texels {
        Texels::U8(t) => words.extend(t.iter().map(|&c| u32::from_le_bytes(c))),
        Texels::F32(t) => words.extend(t.iter().flatten().map(|c| c.to_bits())),
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
    super::scene::write_rows(gpu, &texture, 4 * width, bytemuck::cast_slice(&words));
    texture.create_view(&Default::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(size: [u32; 2], value: u8) -> Arc<Texture> {
        let texels = vec![[value; 4]; (size[0] * size[1]) as usize];
        Arc::new(Texture { name: "grey".into(), size, texels: Texels::U8(texels), encoded: Arc::from([]) })
    }

    #[test]
    fn textures_that_fit_stay_and_the_largest_is_halved_first() {
        let textures = [Some(grey([64, 64], 7)), None, Some(grey([8, 8], 9))];
        let (fitted, messages) = fit(&textures, 64 * 64 + 64);
        assert!(messages.is_empty() && fitted[0].as_ref().unwrap().size == [64, 64]);
        let (fitted, messages) = fit(&textures, 64 * 64 + 63);
        assert_eq!(fitted[0].as_ref().unwrap().size, [32, 32]);
        assert_eq!(fitted[2].as_ref().unwrap().size, [8, 8]);
        assert!(messages.len() == 1 && messages[0].contains("64 x 64 to 32 x 32"), "{messages:?}");
    }

    #[test]
    fn halving_averages_and_keeps_odd_edges() {
        let texels = [0, 4, 8, 12, 16, 20].map(|v: u8| [v; 4]).to_vec();
        let odd = Texture { name: "odd".into(), size: [3, 2], texels: Texels::U8(texels), encoded: Arc::from([]) };
        let half = halved(&odd);
        assert_eq!(half.size, [2, 1]);
        assert_eq!(half.texels, Texels::U8(vec![[8; 4], [14; 4]]));
    }
}
