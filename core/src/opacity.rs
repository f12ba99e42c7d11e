//! How much of the light that meets a surface is stopped by it, point by point.
//!
//! A surface that stops less is thin: light passes straight on, neither refracted nor coloured. It is looked up at points, never
//! within footprints, so that rays, cameras and bakes meet the same holes.

use crate::{
    material::Material,
    scene::{Mesh, Scene},
    texture::{Texture, TextureSlot},
};
use glam::Vec2;
use std::sync::Arc;

/// Names of the parameters, and of their maps.
const OPACITY: &str = "geometry_opacity";
const CUTOFF: &str = "opacity_cutoff";

/// The opacity of a material's points.
#[derive(Clone, Debug, PartialEq)]
pub struct Opacity {
    stopped: Mapped,
    /// Above zero: points stop all light from this opacity on, and none below it.
    cutoff: Mapped,
}

/// A number from 0 to 1 that a map may scale.
#[derive(Clone, Debug)]
struct Mapped {
    number: f32,
    /// Without a texture: of a pattern, or where it is missing.
    map: Option<(TextureSlot, Option<Arc<Texture>>)>,
}

impl PartialEq for Mapped {
    /// Whether both are the same everywhere: by equal numbers and slots, and by the same texture, or one of an equal file.
    fn eq(&self, other: &Self) -> bool {
        let is_same =
            |a: &Texture, b: &Texture| std::ptr::eq(a, b) || (!a.encoded.is_empty() && a.encoded == b.encoded);
        let maps_agree = match (&self.map, &other.map) {
            (None, None) => true,
            (Some((slot, texture)), Some((other_slot, other))) => {
                let textures_agree = match (texture, other) {
                    (Some(texture), Some(other)) => is_same(texture, other),
                    (texture, other) => texture.is_none() && other.is_none(),
                };
                without_index(slot) == without_index(other_slot) && textures_agree
            }
            _ => false,
        };
        self.number == other.number && maps_agree
    }
}

/// A slot without the index of its texture, which says nothing of that.
fn without_index(slot: &TextureSlot) -> TextureSlot {
    TextureSlot { texture: 0, ..slot.clone() }
}

impl Mapped {
    fn of(material: &Material, name: &str, textures: &[Arc<Texture>]) -> Self {
        let texture = |slot: &TextureSlot| slot.image().and_then(|image| textures.get(image).cloned());
        let map = material.maps.get(name).map(|slot| (slot.clone(), texture(slot)));
        Self { number: material.parameters.number(name), map }
    }

    /// The least that it is anywhere. Looks at each texel of its map, if it has one.
    fn least(&self) -> f32 {
        let factor = match &self.map {
            Some((TextureSlot { procedural: Some(_), .. }, _)) => 0.0,
            Some((slot, Some(texture))) => texture.least(slot.channel as usize, slot.color_space),
            None | Some((_, None)) => 1.0,
        };
        self.number * factor
    }

    fn hash_into(&self, hasher: &mut blake3::Hasher) {
        hasher.update(&self.number.to_le_bytes());
        if let Some((slot, texture)) = &self.map {
            hasher.update(serde_json::to_string(&without_index(slot)).expect("a slot is written to memory").as_bytes());
            hasher.update(texture.as_ref().map_or(&[][..], |texture| &texture.encoded));
        }
    }

    fn at(&self, uv: Vec2) -> f32 {
        let sample = |slot: &TextureSlot, texture: &Option<Arc<Texture>>| {
            let uv = slot.transform(uv);
            let pattern = slot.procedural.as_ref().map(|pattern| pattern.value(&uv.into()));
            pattern.or_else(|| texture.as_ref().map(|texture| texture.sample(uv, slot.color_space)))
        };
        let texel = self.map.as_ref().and_then(|(slot, texture)| Some((sample(slot, texture)?, slot.channel)));
        (self.number * texel.map_or(1.0, |(texel, channel)| texel[channel as usize])).clamp(0.0, 1.0)
    }
}

impl Opacity {
    /// All light is stopped.
    const FULL: Self = Self { stopped: Mapped { number: 1.0, map: None }, cutoff: Mapped { number: 0.0, map: None } };

    /// Of a material whose maps are among `textures`.
    pub fn of(material: &Material, textures: &[Arc<Texture>]) -> Self {
        Self { stopped: Mapped::of(material, OPACITY, textures), cutoff: Mapped::of(material, CUTOFF, textures) }
    }

    /// Whether it stops all light everywhere.
    pub fn is_full(&self) -> bool {
        if self.stopped.number < 1.0 && self.cutoff.number == 0.0 {
            return false;
        }
        let least = self.stopped.least();
        // A map may lower a cutoff anywhere.
        let cuts_nothing = self.cutoff.map.is_none() && self.cutoff.number > 0.0 && least >= self.cutoff.number;
        least >= 1.0 || cuts_nothing
    }

    /// Share of the light that a point stops, 0 to 1.
    pub fn at(&self, uv: Vec2) -> f32 {
        let (stopped, cutoff) = (self.stopped.at(uv), self.cutoff.at(uv));
        if cutoff > 0.0 { f32::from(u8::from(stopped >= cutoff)) } else { stopped }
    }
}

/// The opacities of all materials of a scene.
#[derive(Clone, Debug, Default)]
pub struct Opacities {
    materials: Vec<Opacity>,
    /// The material of each triangle, where that is not the mesh's.
    assigned: Option<Arc<[u32]>>,
}

impl PartialEq for Opacities {
    /// Whether both let through the same light. Materials that one lacks, as that of a ground, let none through.
    fn eq(&self, other: &Self) -> bool {
        let at = |of: &Self, i: usize| of.materials.get(i).cloned().unwrap_or(Opacity::FULL);
        let is_any_thin = self.materials.iter().any(|opacity| *opacity != Opacity::FULL);
        let materials = self.materials.len().max(other.materials.len());
        (0..materials).all(|i| at(self, i) == at(other, i)) && (!is_any_thin || self.assigned == other.assigned)
    }
}

impl Opacities {
    /// Of materials whose maps are among `textures`.
    pub fn of(materials: &[Material], textures: &[Arc<Texture>]) -> Self {
        let materials = materials.iter().map(|material| Opacity::of(material, textures)).collect();
        Self { materials, assigned: None }
    }

    /// Of the materials of a scene.
    pub fn of_scene(scene: &Scene) -> Self {
        Self::of(&scene.materials, &scene.textures)
    }

    /// The same where triangles have other materials than those of the mesh.
    pub fn assigned(self, assigned: Option<Arc<[u32]>>) -> Self {
        Self { assigned, ..self }
    }

    /// Whether triangles have the same materials in both.
    pub fn has_same_assignment(&self, other: &Self) -> bool {
        self.assigned == other.assigned
    }

    /// The material of a triangle.
    pub fn material(&self, mesh: &Mesh, triangle: u32) -> u32 {
        let materials = self.assigned.as_deref().unwrap_or(&mesh.triangle_material);
        materials[triangle as usize]
    }

    /// A hash of what lets light through, as hexadecimal; `None` if no number and no map says that anything does.
    pub fn hash(&self) -> Option<String> {
        let mut hasher = blake3::Hasher::new();
        for (material, opacity) in self.materials.iter().enumerate().filter(|(_, opacity)| **opacity != Opacity::FULL) {
            hasher.update(&material.to_le_bytes());
            [&opacity.stopped, &opacity.cutoff].into_iter().for_each(|mapped| mapped.hash_into(&mut hasher));
        }
        (hasher.count() > 0).then(|| hasher.finalize().to_hex().to_string())
    }

    /// Per material its opacity, if it lets light through anywhere.
    pub fn thin(&self) -> Vec<Option<Opacity>> {
        self.materials.iter().map(|opacity| (!opacity.is_full()).then(|| opacity.clone())).collect()
    }
}

impl Material {
    /// Lets through what another material does; `placed` tells where a map of it is found.
    pub fn take_opacity(&mut self, from: &Self, mut placed: impl FnMut(&TextureSlot) -> Option<TextureSlot>) {
        for name in [OPACITY, CUTOFF] {
            let number = from.parameters.number(name);
            if number != self.parameters.number(name) {
                self.parameters.set(name, number);
            }
            self.maps.set(name, from.maps.get(name).and_then(&mut placed));
        }
    }
}

impl Scene {
    /// Its materials let through what others do, one for each, whose maps are among `textures`.
    pub fn take_opacities(&mut self, materials: &[Material], textures: &[Arc<Texture>]) {
        let Self { materials: own, textures: known, .. } = self;
        let mut placed = |slot: &TextureSlot| {
            let Some(image) = slot.image() else { return Some(slot.clone()) };
            let texture = textures.get(image)?;
            let place = known.iter().position(|known| Arc::ptr_eq(known, texture));
            let place = place.unwrap_or_else(|| {
                known.push(texture.clone());
                known.len() - 1
            });
            Some(TextureSlot { texture: place as u32, ..slot.clone() })
        };
        own.iter_mut().zip(materials).for_each(|(own, from)| own.take_opacity(from, &mut placed));
    }
}

/// A number in [0, 1) that looks random, from words that seed it. Twin of `chance` in `shaders/opacity.wgsl`.
pub fn chance(words: &[u32]) -> f32 {
    let mixed = words.iter().fold(0, |hash, &word| mix(hash ^ word));
    (mixed >> 8) as f32 / (1 << 24) as f32
}

/// A permutation of the 32-bit numbers, PCG (Jarzynski and Olano, *Hash Functions for GPU Rendering*, 2020).
fn mix(number: u32) -> u32 {
    let state = number.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Channel, Texels};

    /// A map whose alpha is 0 on the left and 255 on the right.
    fn half(left: u8) -> Vec<Arc<Texture>> {
        let texels = Texels::U8(vec![[255, 255, 255, left], [255; 4]]);
        vec![Arc::new(Texture::new("t", [2, 1], texels))]
    }

    fn material(opacity: f32, cutoff: f32, has_map: bool) -> Material {
        let mut material = Material::default();
        material.parameters.set(OPACITY, opacity);
        material.parameters.set("opacity_cutoff", cutoff);
        let slot = TextureSlot { channel: Channel::A, ..Default::default() };
        material.maps.set(OPACITY, has_map.then_some(slot));
        material
    }

    #[test]
    fn numbers_maps_and_cutoffs_tell_what_is_stopped() {
        let (left, right) = (Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.5));
        for (opacity, cutoff, has_map, expected) in [
            (1.0, 0.0, false, [1.0, 1.0]),
            (0.25, 0.0, false, [0.25, 0.25]),
            (0.25, 0.5, false, [0.0, 0.0]),
            (0.25, 0.2, false, [1.0, 1.0]),
            (0.5, 0.0, true, [0.0, 0.5]),
            (1.0, 0.5, true, [0.0, 1.0]),
        ] {
            let opacity = Opacity::of(&material(opacity, cutoff, has_map), &half(0));
            assert_eq!([left, right].map(|uv| opacity.at(uv)), expected, "{opacity:?}");
            assert_eq!(opacity.is_full(), expected == [1.0; 2]);
        }
    }

    #[test]
    fn a_map_that_stops_all_light_makes_no_thin_surface() {
        let materials = [material(1.0, 0.0, true), material(0.9, 0.0, true), material(1.0, 0.5, true)];
        let thin = |left| Opacities::of(&materials, &half(left)).thin().iter().map(Option::is_some).collect::<Vec<_>>();
        assert_eq!(thin(255), [false, true, false]);
        assert_eq!(thin(200), [true, true, false], "negative control: above the cutoff nothing is cut out");
        assert_eq!(thin(100), [true; 3]);
    }

    #[test]
    fn a_scene_takes_opacities_with_their_textures_and_no_more() {
        let (own, other) = (half(255), half(0));
        let mut scene = Scene { materials: vec![material(1.0, 0.0, false); 2], textures: own, ..Scene::default() };
        scene.materials[0].name = "kept".into();
        let before = Opacities::of(&scene.materials, &scene.textures);
        assert_eq!(before.hash(), None);
        let edited = [material(0.5, 0.0, true), material(1.0, 0.0, false)];
        scene.take_opacities(&edited, &other);
        let after = Opacities::of(&scene.materials, &scene.textures);
        assert_eq!(after, Opacities::of(&edited, &other));
        assert!(after.hash().is_some() && after.hash() != Opacities::of(&[material(0.4, 0.0, true)], &other).hash());
        assert_eq!((scene.textures.len(), scene.materials[0].name.as_str()), (2, "kept"));
        scene.take_opacities(&edited, &other);
        assert_eq!(scene.textures.len(), 2, "it has them already");
    }

    #[test]
    fn equal_textures_that_are_not_the_same_are_told_apart() {
        let (materials, textures) = ([material(1.0, 0.5, true)], half(0));
        assert_eq!(Opacities::of(&materials, &textures), Opacities::of(&materials, &textures));
        assert_ne!(Opacities::of(&materials, &textures), Opacities::of(&materials, &half(0)));
    }
}
