//! Parts of a scene, which can have their own materials without a bake, and a file's variants for them.

use crate::mesh::Mesh;
use serde::{Deserialize, Serialize};

/// The triangles of one object with one material: a primitive of glTF, or one material's part of an OBJ group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Part {
    /// Index of the object.
    pub object: u32,
    /// Index of the mesh's material.
    pub material: u32,
}

impl Part {
    /// The part of a triangle; `None` if there is no such triangle.
    pub fn of_triangle(mesh: &Mesh, triangle: usize) -> Option<Self> {
        let (object, material) = (mesh.triangle_object.get(triangle)?, mesh.triangle_material.get(triangle)?);
        Some(Self { object: *object, material: *material })
    }
}

/// All parts of a mesh, in the order of their objects and materials.
pub fn parts_of(mesh: &Mesh) -> Vec<Part> {
    let mut parts: Vec<Part> = (0..mesh.triangles.len()).filter_map(|t| Part::of_triangle(mesh, t)).collect();
    // Triangles of a part are mostly consecutive.
    parts.dedup();
    parts.sort_unstable();
    parts.dedup();
    parts
}

/// Variants of materials (`KHR_materials_variants`). Each variant determines the materials of all parts listed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Variants {
    /// Their names.
    pub names: Vec<String>,
    /// Parts that differ between variants.
    pub parts: Vec<PartVariants>,
}

/// The materials of a part, by index.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartVariants {
    /// The part.
    pub part: Part,
    /// Material without a variant.
    pub plain: u32,
    /// Material in each variant.
    pub in_variants: Vec<u32>,
}

impl Variants {
    /// Whether there are no variants.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The parts, each with its material in a variant, or its material without one.
    pub fn shown(&self, variant: Option<usize>) -> impl Iterator<Item = (Part, u32)> {
        let material = move |part: &PartVariants| variant.map_or(part.plain, |variant| part.in_variants[variant]);
        self.parts.iter().map(move |part| (part.part, material(part)))
    }

    /// Whether they are valid in a scene with these numbers of objects and materials.
    pub fn fit(&self, objects: usize, materials: usize) -> bool {
        let is_material = |&index: &u32| (index as usize) < materials;
        self.parts.iter().all(|PartVariants { part, plain, in_variants }| {
            (part.object as usize) < objects
                && [part.material, *plain].iter().chain(in_variants).all(is_material)
                && in_variants.len() == self.names.len()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_that_name_what_is_not_there_do_not_fit() {
        let of = |object, material, plain, in_variants: &[u32]| Variants {
            names: vec!["red".into(), "blue".into()],
            parts: vec![PartVariants { part: Part { object, material }, plain, in_variants: in_variants.to_vec() }],
        };
        assert!(of(1, 2, 2, &[0, 2]).fit(2, 3));
        for damaged in [of(2, 2, 2, &[0, 2]), of(1, 3, 2, &[0, 2]), of(1, 2, 3, &[0, 2]), of(1, 2, 2, &[0, 3])] {
            assert!(!damaged.fit(2, 3), "{damaged:?}");
        }
        assert!(!of(1, 2, 2, &[0]).fit(2, 3), "one for each variant");
        assert!(Variants::default().fit(0, 0));
    }
}
