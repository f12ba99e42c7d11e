//! Share of incident light that a surface stops, point by point.
//!
//! A surface that stops less than all is thin: light passes straight through, neither refracted nor colored. Opacity is
//! looked up at points, never within footprints, so rays, cameras and bakes meet the same holes.

use crate::{
    material::Material,
    mesh::Mesh,
    parts::Part,
    texture::{Texture, TextureSlot},
};
use glam::Vec2;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Names of the parameters, and of their maps.
const OPACITY: &str = "geometry_opacity";
const CUTOFF: &str = "opacity_cutoff";

/// The opacity of a material's points.
#[derive(Clone, Debug, PartialEq)]
pub struct Opacity {
    stopped: Mapped,
    /// Above zero: points of at least this opacity stop all light, all other points none.
    cutoff: Mapped,
}

/// A number from 0 to 1, optionally scaled by a map.
#[derive(Clone, Debug)]
struct Mapped {
    number: f32,
    /// The slot of the map; its texture is `None` for a pattern or if missing.
    map: Option<(TextureSlot, Option<Arc<Texture>>)>,
}

impl PartialEq for Mapped {
    /// Whether both are the same everywhere: by equal numbers and slots, and by the same texture or an equal file.
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

/// A slot without the index of its texture, which does not identify the texture.
fn without_index(slot: &TextureSlot) -> TextureSlot {
    TextureSlot { texture: 0, ..slot.clone() }
}

impl Mapped {
    fn of(material: &Material, name: &str, textures: &[Arc<Texture>]) -> Self {
        let texture = |slot: &TextureSlot| slot.image().and_then(|image| textures.get(image).cloned());
        let map = material.maps.get(name).map(|slot| (slot.clone(), texture(slot)));
        Self { number: material.parameters.number(name), map }
    }

    /// The minimum over all texels of its map, if it has one.
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

    fn at(&self, uvs: [Vec2; 2]) -> f32 {
        let sample = |slot: &TextureSlot, texture: &Option<Arc<Texture>>| {
            let uv = slot.transform(uvs[slot.uv_set as usize]);
            let pattern = slot.procedural.as_ref().map(|pattern| pattern.value(&uv.into()));
            pattern.or_else(|| texture.as_ref().map(|texture| texture.sample(uv, slot.color_space, slot.wrap)))
        };
        let texel = self.map.as_ref().and_then(|(slot, texture)| Some((sample(slot, texture)?, slot.channel)));
        (self.number * texel.map_or(1.0, |(texel, channel)| texel[channel as usize])).clamp(0.0, 1.0)
    }
}

impl Opacity {
    /// Opaque.
    pub(crate) const FULL: Self =
        Self { stopped: Mapped { number: 1.0, map: None }, cutoff: Mapped { number: 0.0, map: None } };

    /// The opacity of a material whose maps are among `textures`.
    pub fn of(material: &Material, textures: &[Arc<Texture>]) -> Self {
        Self { stopped: Mapped::of(material, OPACITY, textures), cutoff: Mapped::of(material, CUTOFF, textures) }
    }

    pub(crate) fn hash_into(&self, hasher: &mut blake3::Hasher) {
        [&self.stopped, &self.cutoff].into_iter().for_each(|mapped| mapped.hash_into(hasher));
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

    /// Share of the light that a point stops, 0 to 1, from its texture coordinates of both sets.
    pub fn at(&self, uvs: [Vec2; 2]) -> f32 {
        let (stopped, cutoff) = (self.stopped.at(uvs), self.cutoff.at(uvs));
        if cutoff > 0.0 { f32::from(u8::from(stopped >= cutoff)) } else { stopped }
    }
}

/// The opacities of all materials of a scene.
#[derive(Clone, Debug, Default)]
pub struct Opacities {
    materials: Vec<Opacity>,
    /// The material of each triangle, where it differs from the mesh's.
    assigned: Option<Arc<[u32]>>,
}

impl PartialEq for Opacities {
    /// Whether both let through the same light. Missing materials, such as a ground's, are opaque.
    fn eq(&self, other: &Self) -> bool {
        let at = |of: &Self, i: usize| of.materials.get(i).cloned().unwrap_or(Opacity::FULL);
        let is_any_thin = self.materials.iter().any(|opacity| *opacity != Opacity::FULL);
        let materials = self.materials.len().max(other.materials.len());
        (0..materials).all(|i| at(self, i) == at(other, i)) && (!is_any_thin || self.assigned == other.assigned)
    }
}

impl Opacities {
    /// The opacities of materials whose maps are among `textures`.
    pub fn of(materials: &[Material], textures: &[Arc<Texture>]) -> Self {
        let materials = materials.iter().map(|material| Opacity::of(material, textures)).collect();
        Self { materials, assigned: None }
    }

    /// The same opacities with other materials for triangles than the mesh's.
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

    /// Whether both give all triangles of a mesh the same opacity, whatever the indices of their materials.
    pub fn agree(&self, other: &Self, mesh: &Mesh) -> bool {
        if self == other {
            return true;
        }
        let numbers = |triangle| (self.material(mesh, triangle), other.material(mesh, triangle));
        let mut pairs: Vec<_> = (0..mesh.triangles.len() as u32).map(numbers).collect();
        // Triangles of a part are mostly consecutive.
        pairs.dedup();
        pairs.sort_unstable();
        pairs.dedup();
        let of = |of: &Self, material: u32| of.materials.get(material as usize).cloned().unwrap_or(Opacity::FULL);
        pairs.into_iter().all(|(own, others)| of(self, own) == of(other, others))
    }

    /// Whether both give a triangle of a mesh the same opacity.
    pub fn agree_at(&self, other: &Self, mesh: &Mesh, triangle: u32) -> bool {
        let of = |of: &Self| of.materials.get(of.material(mesh, triangle) as usize).cloned().unwrap_or(Opacity::FULL);
        of(self) == of(other)
    }

    /// The opacity of each material that lets light through anywhere.
    pub fn thin(&self) -> Vec<Option<Opacity>> {
        self.materials.iter().map(|opacity| (!opacity.is_full()).then(|| opacity.clone())).collect()
    }
}

impl Material {
    /// Takes the opacity of another material; `placed` finds the slot for each of its maps.
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

/// Parts of one material with another opacity than the material's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartOpacity {
    /// The parts.
    pub parts: Vec<Part>,
    /// A material of which only the opacity counts.
    pub material: Material,
}

impl PartOpacity {
    /// Whether it is valid in a scene with these numbers of objects and materials.
    pub fn fits(&self, objects: usize, materials: usize) -> bool {
        let is_there = |part: &Part| (part.object as usize) < objects && (part.material as usize) < materials;
        let is_of_one = self.parts.windows(2).all(|pair| pair[0].material == pair[1].material);
        !self.parts.is_empty() && is_of_one && self.parts.iter().all(is_there)
    }

    /// The material of the parts: the mesh's, from `own`, with this opacity.
    pub fn shown(&self, own: &[Material]) -> Material {
        let mut shown = own[self.parts[0].material as usize].clone();
        shown.take_opacity(&self.material, |slot| Some(slot.clone()));
        shown
    }
}

/// A pseudo-random number in [0, 1), seeded by words. Twin of `chance` in `shaders/opacity.wgsl`.
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
    use crate::{
        scene::{Object, Scene},
        texture::{Channel, Texels},
    };

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
            assert_eq!([left, right].map(|uv| opacity.at([uv; 2])), expected, "{opacity:?}");
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
        assert_eq!(scene.opacity_hash(), None);
        let edited = [material(0.5, 0.0, true), material(1.0, 0.0, false)];
        scene.take_opacities(&edited, 2, [], &other);
        assert_eq!(Opacities::of_scene(&scene), Opacities::of(&edited, &other));
        let less = Scene { materials: vec![material(0.4, 0.0, true)], textures: other.clone(), ..Scene::default() };
        assert!(scene.opacity_hash().is_some() && scene.opacity_hash() != less.opacity_hash());
        assert_eq!((scene.textures.len(), scene.materials[0].name.as_str()), (2, "kept"));
        scene.take_opacities(&edited, 2, [], &other);
        assert_eq!(scene.textures.len(), 2, "it has them already");
    }

    /// Three objects of one triangle each; the last has another material.
    fn three_objects() -> Scene {
        let mesh = Mesh {
            triangles: vec![[0, 1, 2]; 3],
            triangle_material: vec![0, 0, 1],
            triangle_object: vec![0, 1, 2],
            ..Mesh::default()
        };
        let objects = vec![Object { name: "o".into() }; 3];
        Scene { mesh, objects, materials: vec![material(1.0, 0.0, false); 2], ..Scene::default() }
    }

    #[test]
    fn a_part_lets_through_what_its_own_material_does() {
        let mut scene = three_objects();
        let edited = [material(1.0, 0.0, false), material(1.0, 0.0, false), material(0.5, 0.0, true)];
        let glass = Part { object: 1, material: 0 };
        let opaque = Part { object: 2, material: 1 };
        let gone = Part { object: 3, material: 0 };
        scene.take_opacities(&edited, 2, [(glass, 2), (opaque, 0), (gone, 2)], &half(0));
        assert_eq!(scene.part_opacities.len(), 1, "an assignment that stops all light as before is none");
        let opacities = Opacities::of_scene(&scene);
        assert_eq!([0, 1, 2].map(|triangle| opacities.material(&scene.mesh, triangle)), [0, 2, 1]);
        let numbered = |numbers: [u32; 3]| Opacities::of(&edited, &scene.textures).assigned(Some(Arc::new(numbers)));
        assert!(opacities.agree(&numbered([1, 2, 0]), &scene.mesh), "by other numbers");
        assert!(!opacities.agree(&numbered([0, 0, 1]), &scene.mesh), "negative control: without the assignment");
        assert!(!opacities.agree(&numbered([0, 2, 2]), &scene.mesh), "negative control: another part too");
        let opacity = |part| scene.opacity_of(part).at([Vec2::new(0.75, 0.5); 2]);
        assert_eq!([opacity(glass), opacity(opaque), opacity(Part { object: 0, material: 0 })], [0.5, 1.0, 1.0]);
    }

    #[test]
    fn the_hash_of_opacities_tells_parts_apart() {
        let edited = [material(1.0, 0.0, false), material(1.0, 0.0, false), material(0.5, 0.0, false)];
        let hash = |object| {
            let mut scene = three_objects();
            scene.take_opacities(&edited, 2, [(Part { object, material: 0 }, 2)], &[]);
            scene.opacity_hash()
        };
        assert!(hash(0).is_some() && hash(0) == hash(0) && hash(0) != hash(1));
        let mut scene = three_objects();
        scene.take_opacities(&edited, 2, [], &[]);
        assert_eq!(scene.opacity_hash(), None, "negative control: no part has the material that is thin");
    }

    #[test]
    fn opacities_of_parts_that_are_not_there_do_not_fit() {
        let of = |parts: &[[u32; 2]]| {
            let part = |&[object, material]: &[u32; 2]| Part { object, material };
            PartOpacity { parts: parts.iter().map(part).collect(), material: Material::default() }
        };
        assert!(of(&[[0, 1], [1, 1]]).fits(2, 2));
        for damaged in [of(&[]), of(&[[2, 0]]), of(&[[0, 2]]), of(&[[0, 0], [0, 1]])] {
            assert!(!damaged.fits(2, 2), "{damaged:?}");
        }
    }

    #[test]
    fn equal_textures_that_are_not_the_same_are_told_apart() {
        let (materials, textures) = ([material(1.0, 0.5, true)], half(0));
        assert_eq!(Opacities::of(&materials, &textures), Opacities::of(&materials, &textures));
        assert_ne!(Opacities::of(&materials, &textures), Opacities::of(&materials, &half(0)));
    }
}
