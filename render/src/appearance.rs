//! The parts of a scene that may change without a bake: its materials and their textures.

use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{
    brdf::{SurfaceParameters, Values},
    material::{Material, MaterialMaps},
    opacity::Opacities,
    scene::{Mesh, Scene},
    surfel::MeshPlace,
    texture::{Texture, TextureSlot, UvFootprint},
};
use std::sync::Arc;

/// Materials and the textures that they refer to by index.
#[derive(Clone, Debug, Default)]
pub struct Appearance {
    /// One for each material index of the mesh.
    pub materials: Vec<Material>,
    /// Shared: copying an appearance copies no texels.
    pub textures: Vec<Arc<Texture>>,
}

impl Appearance {
    /// As the scene has them.
    pub fn of(scene: &Scene) -> Self {
        Self { materials: scene.materials.clone(), textures: scene.textures.clone() }
    }

    /// Whether both look the same: equal materials, and the identical textures, not only equal ones.
    pub fn is_same(&self, other: &Self) -> bool {
        let same_texture = |(a, b): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(a, b);
        self.materials == other.materials
            && self.textures.len() == other.textures.len()
            && self.textures.iter().zip(&other.textures).all(same_texture)
    }

    /// What its surfaces let through.
    pub fn opacities(&self) -> Opacities {
        Opacities::of(&self.materials, &self.textures)
    }

    /// Materials that do not look the same in `other`, which has as many, by index.
    pub(crate) fn changed_materials(&self, other: &Self) -> Vec<usize> {
        let same_texture = |index: u32| match [self, other].map(|looks| looks.textures.get(index as usize)) {
            [Some(a), Some(b)] => Arc::ptr_eq(a, b),
            [a, b] => a.is_none() && b.is_none(),
        };
        let same = |a: &Material, b: &Material| a == b && a.maps.slots().all(|slot| same_texture(slot.texture));
        let pairs = self.materials.iter().zip(&other.materials).enumerate();
        pairs.filter(|(_, (a, b))| !same(a, b)).map(|(index, _)| index).collect()
    }

    /// A material's values after its maps within a footprint, clamped to their ranges here and nowhere later. Twin of
    /// `material_number` and `material_color` in `shaders/materials.wgsl`.
    pub(crate) fn values(&self, material: &Material, uv: &UvFootprint) -> Values {
        material.values(|slot| self.sample(slot, uv))
    }

    /// The mean of a map within a footprint.
    pub(crate) fn sample(&self, slot: &TextureSlot, uv: &UvFootprint) -> Vec4 {
        match &slot.procedural {
            Some(pattern) => pattern.value(&uv.through(slot)),
            None => self.textures[slot.texture as usize].sample_footprint(uv, slot),
        }
    }

    /// Albedo of a point of `mesh`, the share of light that it reflects in all directions, as bounces use it.
    pub fn albedo(&self, mesh: &Mesh, place: MeshPlace) -> Vec3 {
        let (material, uv) = self.at(mesh, place);
        material.brdf(&self.values(material, &uv.into())).as_brdf().albedo()
    }

    /// Radiance in W/(m² sr) that a point of `mesh` sends by itself.
    pub fn emission(&self, mesh: &Mesh, place: MeshPlace) -> Vec3 {
        let (material, uv) = self.at(mesh, place);
        if material.shines() {
            SurfaceParameters::of(&self.values(material, &uv.into())).emission()
        } else {
            Vec3::ZERO
        }
    }

    /// Material and texture coordinates of a point.
    fn at(&self, mesh: &Mesh, place: MeshPlace) -> (&Material, Vec2) {
        let triangle = place.triangle as usize;
        let weights = [1.0 - place.barycentric.element_sum(), place.barycentric.x, place.barycentric.y];
        let uv: Vec2 = mesh.triangles[triangle].iter().zip(weights).map(|(&v, w)| mesh.uvs[v as usize] * w).sum();
        (&self.materials[mesh.triangle_material[triangle] as usize], uv)
    }

    /// With a material for each of the scene's `own`, and without references to missing maps. Also returns the changes,
    /// in sentences.
    pub fn fitted(&self, own: &[Material]) -> (Self, Vec<String>) {
        let mut remarks = Vec::new();
        let (given, needed) = (self.materials.len(), own.len());
        if given != needed {
            remarks.push(format!(
                "there are {given} materials for the {needed} of the scene; those that lack are the scene's own"
            ));
        }
        let mut materials: Vec<Material> = self.materials.iter().take(needed).cloned().collect();
        materials.extend(own.iter().skip(given).cloned());
        for material in &mut materials {
            if material.maps.slots().any(|slot| slot.image().is_some_and(|image| image >= self.textures.len())) {
                let name = &material.name;
                remarks.push(format!("material \"{name}\" has maps without a picture and is shown without maps"));
                material.maps = MaterialMaps::default();
            }
        }
        (Self { materials, textures: self.textures.clone() }, remarks)
    }
}
