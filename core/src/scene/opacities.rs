//! Opacities of a scene's materials and parts.

use super::Scene;
use crate::{
    material::Material,
    opacity::{Opacities, Opacity, PartOpacity},
    parts::Part,
    texture::{Texture, TextureSlot},
};
use std::{collections::BTreeMap, sync::Arc};

impl Opacities {
    /// The opacities of a scene's materials and of parts that override them.
    pub fn of_scene(scene: &Scene) -> Self {
        let (materials, assigned) = scene.materials_with_parts();
        Self::of(&materials, &scene.textures).assigned(assigned)
    }
}

impl Scene {
    /// Its materials, followed by materials for parts with their own opacity. If there are such parts, also the
    /// material of each triangle.
    pub fn materials_with_parts(&self) -> (Vec<Material>, Option<Arc<[u32]>>) {
        let own = self.materials.len();
        let mut materials = self.materials.clone();
        materials.extend(self.part_opacities.iter().map(|other| other.shown(&self.materials)));
        if self.part_opacities.is_empty() {
            return (materials, None);
        }
        let others = (own as u32..).zip(&self.part_opacities);
        let of_part: BTreeMap<Part, u32> =
            others.flat_map(|(material, other)| other.parts.iter().map(move |&part| (part, material))).collect();
        let of_triangle = |(triangle, &material): (usize, &u32)| {
            Part::of_triangle(&self.mesh, triangle).and_then(|part| of_part.get(&part).copied()).unwrap_or(material)
        };
        (materials, Some(self.mesh.triangle_material.iter().enumerate().map(of_triangle).collect()))
    }

    /// Assigns mesh materials to parts with an opacity of their own, for formats without parts.
    pub fn settle_parts(&mut self) {
        if let (materials, Some(assigned)) = self.materials_with_parts() {
            let own = self.materials.len();
            self.materials = materials;
            for (material, PartOpacity { parts, .. }) in self.materials[own..].iter_mut().zip(&self.part_opacities) {
                // Formats identify materials by name.
                material.name += &format!(" of {}", self.objects[parts[0].object as usize].name);
            }
            self.mesh.triangle_material = assigned.to_vec();
            self.part_opacities.clear();
        }
    }

    /// The opacity of a part; none if the scene lacks its material.
    pub fn opacity_of(&self, part: Part) -> Opacity {
        let other = self.part_opacities.iter().find(|other| other.parts.contains(&part));
        let material = other.map(|other| &other.material).or_else(|| self.materials.get(part.material as usize));
        material.map_or(Opacity::FULL, |material| Opacity::of(material, &self.textures))
    }

    /// Takes opacities from `materials`. The first `count` replace the scene's own; each part in `assigned` takes the
    /// opacity of its assigned material. Their maps are among `textures`. Unknown parts are skipped.
    pub fn take_opacities(
        &mut self,
        materials: &[Material],
        count: usize,
        assigned: impl IntoIterator<Item = (Part, usize)>,
        textures: &[Arc<Texture>],
    ) {
        let Self { materials: own, textures: known, part_opacities, objects, .. } = self;
        let mut placed = |slot: &TextureSlot| placed_among(known, textures, slot);
        own.iter_mut().zip(&materials[..count]).for_each(|(own, from)| own.take_opacity(from, &mut placed));
        let is_there = |part: &Part| (part.object as usize) < objects.len() && (part.material as usize) < own.len();
        let opacity = |material: usize| materials.get(material).map(|material| Opacity::of(material, textures));
        let mut others: BTreeMap<(u32, usize), Vec<Part>> = BTreeMap::new();
        for (part, material) in assigned.into_iter().filter(|(part, _)| is_there(part)) {
            if opacity(material).is_some() && opacity(material) != opacity(part.material as usize) {
                others.entry((part.material, material)).or_default().push(part);
            }
        }
        let of_parts = |((_, from), parts): ((u32, usize), Vec<Part>)| {
            let mut material = Material::default();
            material.take_opacity(&materials[from], &mut placed);
            PartOpacity { parts, material }
        };
        *part_opacities = others.into_iter().map(of_parts).collect();
    }

    /// A hash of all opacities, in hexadecimal; `None` if everything is opaque.
    pub fn opacity_hash(&self) -> Option<String> {
        let mut hasher = blake3::Hasher::new();
        let mut add = |of: &[u8], material: &Material| {
            hasher.update(of);
            Opacity::of(material, &self.textures).hash_into(&mut hasher);
        };
        for (index, material) in self.materials.iter().enumerate() {
            if Opacity::of(material, &self.textures) != Opacity::FULL {
                add(&index.to_le_bytes(), material);
            }
        }
        for PartOpacity { parts, material } in &self.part_opacities {
            let parts = parts.iter().flat_map(|part| [part.object, part.material]).flat_map(u32::to_le_bytes);
            add(&parts.collect::<Vec<u8>>(), material);
        }
        (hasher.count() > 0).then(|| hasher.finalize().to_hex().to_string())
    }
}

/// A slot of `textures` as a slot of `known`; adds its texture if missing. `None` if there is no such texture.
fn placed_among(known: &mut Vec<Arc<Texture>>, textures: &[Arc<Texture>], slot: &TextureSlot) -> Option<TextureSlot> {
    let Some(image) = slot.image() else { return Some(slot.clone()) };
    let texture = textures.get(image)?;
    let place = known.iter().position(|known| Arc::ptr_eq(known, texture));
    let place = place.unwrap_or_else(|| {
        known.push(texture.clone());
        known.len() - 1
    });
    Some(TextureSlot { texture: place as u32, ..slot.clone() })
}
