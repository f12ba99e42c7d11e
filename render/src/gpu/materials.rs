//! Materials on the GPU. What a material edit changes.

use super::{
    device::GpuDevice,
    layout::{Material, TextureSlot},
    pool::{Place, TexturePool},
    scene::storage,
};
use crate::appearance::Appearance;
use lapidary_core::{
    color::linear_from_srgb,
    material::{self, MapKind},
    texture,
};
use wgpu::util::DeviceExt;

/// The materials of a scene and their textures.
pub struct GpuMaterials {
    pub buffer: wgpu::Buffer,
    pub pool: TexturePool,
    pub linear_from_srgb: wgpu::Buffer,
    /// Whether some material is of the model, so that its code is needed.
    pub has_ggx: bool,
    pub has_ward: bool,
}

impl GpuMaterials {
    /// Uploads; textures of `before` that still fit are reused. Also returns which were scaled, in sentences.
    pub fn new(gpu: &GpuDevice, appearance: &Appearance, before: Option<Self>) -> (Self, Vec<String>) {
        let kept = before.map(|b| b.pool).filter(|pool| pool.serves(appearance));
        let (pool, messages) = match kept {
            Some(pool) => (pool, Vec::new()),
            None => TexturePool::new(gpu, appearance),
        };
        let materials: Vec<Material> = appearance.materials.iter().map(|m| material(m, &pool.places)).collect();
        let uses = |model| appearance.materials.iter().any(|m| m.model == model);
        let materials = Self {
            buffer: storage(gpu, "materials", bytemuck::cast_slice(&materials)),
            pool,
            linear_from_srgb: srgb_table(gpu),
            has_ggx: uses(material::BrdfModel::Ggx),
            has_ward: uses(material::BrdfModel::Ward),
        };
        (materials, messages)
    }
}

fn material(m: &material::Material, places: &[Option<Place>]) -> Material {
    let p = &m.parameters;
    let slot = |kind| {
        let placed = m.maps[kind].as_ref().and_then(|s| places[s.texture as usize].map(|place| texture_slot(s, place)));
        placed.unwrap_or_default()
    };
    Material {
        base_color: p.base_color.to_array(),
        roughness: p.roughness,
        metalness: p.metalness,
        anisotropy: p.anisotropy,
        ior: p.ior,
        specular: p.specular,
        model: m.model as u32,
        normal_y: if m.maps[MapKind::Normal].as_ref().is_some_and(|s| s.flip_y) { -1.0 } else { 1.0 },
        padding: [0; 2],
        base_color_map: slot(MapKind::BaseColor),
        roughness_map: slot(MapKind::Roughness),
        metalness_map: slot(MapKind::Metalness),
        specular_map: slot(MapKind::Specular),
        anisotropy_map: slot(MapKind::Anisotropy),
        ior_map: slot(MapKind::Ior),
        normal_map: slot(MapKind::Normal),
        bump_map: slot(MapKind::Bump),
    }
}

fn texture_slot(slot: &texture::TextureSlot, place: Place) -> TextureSlot {
    let (sin, cos) = slot.rotation.sin_cos();
    TextureSlot {
        first: place.first,
        width: place.size[0],
        height: place.size[1],
        kind: place.kind(slot.color_space),
        scale: slot.scale.to_array(),
        offset: slot.offset.to_array(),
        turn: [sin, cos],
        strength: slot.strength,
        channel: slot.channel as u32,
    }
}

/// Linear values of the 256 sRGB codes: a shader's own power function is too coarse.
fn srgb_table(gpu: &GpuDevice) -> wgpu::Buffer {
    let table: [f32; 256] = std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0));
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("linear from sRGB"),
        contents: bytemuck::cast_slice(&table),
        usage: wgpu::BufferUsages::UNIFORM,
    })
}
