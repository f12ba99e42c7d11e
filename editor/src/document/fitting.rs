//! Materials and textures of a document for another dataset of its scene.

use super::{Document, TextureEntry, objects::ObjectNumbers};
use lapidary_core::{dataset::Dataset, texture::Texture};
use std::sync::Arc;

/// Adds materials that the document lacks, since a scene changed in another program may have others, so that there are as many as
/// the mesh refers to. Returns the numbers of its objects.
pub fn fit_materials(document: &mut Document, dataset: &Dataset) -> ObjectNumbers {
    let materials = &dataset.scene.materials;
    let added = document.materials.split_off(document.own_materials());
    document.materials.truncate(materials.len());
    let known = document.materials.len();
    let places = take_textures(document, &dataset.scene.textures);
    document.materials.extend_from_slice(&materials[known..]);
    for slot in document.materials[known..].iter_mut().flat_map(|material| material.maps.slots_mut()) {
        if let Some(&place) = places.get(slot.texture as usize) {
            slot.texture = place;
        }
    }
    document.materials.extend(added);
    document.take_objects(&dataset.scene)
}

/// Takes over the textures of a scene, by name, first at the same index. They replace their stand-ins; new ones are
/// appended. Returns the index of each.
pub fn take_textures(document: &mut Document, textures: &[Arc<Texture>]) -> Vec<u32> {
    let mut places = Vec::with_capacity(textures.len());
    for (i, texture) in textures.iter().enumerate() {
        let is_it = |entry: &TextureEntry| entry.file.is_none() && entry.texture.name == texture.name;
        let same = document.textures.get(i).is_some_and(is_it).then_some(i);
        let place = same.or_else(|| document.textures.iter().position(is_it)).unwrap_or(document.textures.len());
        let entry = TextureEntry { texture: texture.clone(), file: None };
        match document.textures.get_mut(place) {
            Some(old) => *old = entry,
            None => document.textures.push(entry),
        }
        places.push(place as u32);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::material::Material;

    #[test]
    fn another_bake_keeps_edited_materials_and_adds_new_ones() {
        let named = |name: &str| Material { name: name.into(), ..Default::default() };
        let mut dataset = crate::test_support::baked_triangle();
        dataset.scene.materials = vec![named("a"), named("b")];
        let mut document = Document { materials: vec![named("edited")], ..Document::empty() };
        fit_materials(&mut document, &dataset);
        let names: Vec<_> = document.materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["edited", "b"]);
        document.materials.push(named("gone"));
        fit_materials(&mut document, &dataset);
        assert_eq!(document.materials.len(), 2);
    }
}
