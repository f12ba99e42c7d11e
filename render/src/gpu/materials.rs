//! Materials on the GPU. What a material edit changes.

use super::{
    measured::GpuMeasured,
    pool::{Place, TexturePool},
};
use crate::{
    appearance::{Appearance, narrowest_lobe},
    device::{
        GpuDevice, ModelSet,
        layout::{
            Material, MaterialParameter, TextureSlot,
            constants::{KIND_PROCEDURAL, MOST_PARAMETERS, NO_TABLE, READS_SECOND_UVS, READS_VERTEX_COLORS},
        },
        storage, tables,
    },
};
use lapidary_core::{
    brdf::MISSING,
    material::{self, BUMP, NORMAL},
    texture::{self, Procedural},
};

/// The materials of a scene and their textures.
pub struct GpuMaterials {
    pub buffer: wgpu::Buffer,
    pub pool: TexturePool,
    pub tables: wgpu::Buffer,
    pub measured: GpuMeasured,
    /// No lobe is narrower.
    pub narrowest: f32,
    /// Whether any has a bump or a normal map.
    pub are_bent: bool,
}

impl GpuMaterials {
    /// Uploads; textures of `before` that still fit are reused. Also returns which were scaled, in sentences.
    pub fn new(gpu: &GpuDevice, appearance: &Appearance, before: Option<Self>) -> (Self, Vec<String>) {
        let (pool, measured) = before.map(|b| (b.pool, b.measured)).unzip();
        let kept = pool.filter(|pool| pool.serves(appearance));
        let (pool, mut messages) = match kept {
            Some(pool) => (pool, Vec::new()),
            None => TexturePool::new(gpu, appearance),
        };
        let (measured, unplaced) = GpuMeasured::new(gpu, appearance, measured);
        messages.extend(unplaced);
        let models = ModelSet::of(appearance);
        let material = |m| Material {
            model: models.number(m),
            table: measured.first_word(m),
            estimate: estimate(m),
            ..material(m, &pool)
        };
        let materials: Vec<Material> = appearance.materials.iter().map(material).collect();
        let buffer = storage(gpu, "materials", bytemuck::cast_slice(&materials));
        let narrowest = appearance.materials.iter().map(narrowest_lobe).fold(f32::INFINITY, f32::min);
        let is_bent = |m: &material::Material| [NORMAL, BUMP].into_iter().any(|name| m.maps.get(name).is_some());
        let are_bent = appearance.materials.iter().any(is_bent);
        let materials = Self { buffer, pool, tables: tables(gpu), measured, narrowest, are_bent };
        (materials, messages)
    }
}

/// Albedo for light from the normal, and width of the lobe, if its BRDF is that of a file.
fn estimate(m: &material::Material) -> [f32; 4] {
    if !m.model.has_file() {
        return [0.0; 4];
    }
    match m.file.as_ref().and_then(|file| file.content.as_ref()) {
        Some(content) => {
            let lobe = content.estimate(&m.plain_values());
            lobe.albedo_at(1.0).extend(lobe.width()).to_array()
        }
        None => MISSING.extend(0.0).to_array(),
    }
}

fn material(m: &material::Material, pool: &TexturePool) -> Material {
    let slot = |name| {
        let placed = |s: &texture::TextureSlot| match &s.procedural {
            Some(pattern) => Some(pattern_slot(s, pattern)),
            None => pool.place(name, s).map(|place| texture_slot(s, place)),
        };
        m.maps.get(name).and_then(placed).unwrap_or_default()
    };
    let colored = m.vertex_colored().map(|parameter| parameter.name);
    let mut parameters = [MaterialParameter::default(); MOST_PARAMETERS];
    for (packed, declared) in parameters.iter_mut().zip(m.declared()) {
        let value = m.parameters.value(declared).color();
        let has_vertex_color = u32::from(colored == Some(declared.name));
        *packed = MaterialParameter { value: value.to_array(), has_vertex_color, map: slot(declared.name) };
    }
    Material {
        model: m.model as u32,
        reads: reads_of(m),
        surface: m.own_parameters().len() as u32,
        table: NO_TABLE,
        estimate: [0.0; 4],
        normal_map: slot(NORMAL),
        bump_map: slot(BUMP),
        parameters,
    }
}

fn texture_slot(slot: &texture::TextureSlot, place: Place) -> TextureSlot {
    let (sin, cos) = slot.rotation.sin_cos();
    TextureSlot {
        first: place.first,
        width: place.size[0],
        height: place.size[1],
        kind: place.kind,
        scale: slot.scale.to_array(),
        offset: slot.offset.to_array(),
        turn: [sin, cos],
        strength: slot.strength,
        lookup: lookup_of(slot),
        ..Default::default()
    }
}

/// What a material needs of the vertices: a second set of coordinates, and colors.
fn reads_of(m: &material::Material) -> u32 {
    let second = if m.reads_second_uvs() { READS_SECOND_UVS } else { 0 };
    let colors = if m.vertex_colored().is_some() { READS_VERTEX_COLORS } else { 0 };
    second | colors
}

/// Bits 0 and 1: component; 2 and 3: wrap along u; 4 and 5: wrap along v; 6: set of coordinates; 7: green down.
fn lookup_of(slot: &texture::TextureSlot) -> u32 {
    let [u, v] = slot.wrap.map(|wrap| wrap as u32);
    slot.channel as u32 | u << 2 | v << 4 | (slot.uv_set as u32) << 6 | u32::from(slot.flip_y) << 7
}

fn pattern_slot(slot: &texture::TextureSlot, pattern: &Procedural) -> TextureSlot {
    let Procedural { pattern, low, high, octaves } = pattern.sanitized();
    let place = Place { first: 0, size: [1, 1], kind: KIND_PROCEDURAL };
    let (low, high) = (low.to_array(), high.to_array());
    TextureSlot { low, pattern: pattern as u32, high, octaves, ..texture_slot(slot, place) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::mirror::Mirror;

    #[test]
    fn maps_of_roughness_may_make_mirrors_and_other_maps_do_not() {
        let rough = |map: Option<&'static str>| {
            let mut material = material::Material::default();
            material.parameters.set("roughness", 0.6);
            map.into_iter().for_each(|name| material.maps.set(name, Some(Default::default())));
            narrowest_lobe(&material)
        };
        let may_be = |narrowest| Mirror::may_be(narrowest, 4.0 * std::f32::consts::PI / 4096.0);
        assert!(!may_be(rough(None)) && !may_be(rough(Some("base_color"))));
        assert!(may_be(rough(Some("roughness"))));
        let lambert = material::Material { model: lapidary_core::brdf::BrdfModel::Lambert, ..Default::default() };
        assert!(!may_be(narrowest_lobe(&lambert)), "no lobe");
    }
}
