//! Parts of a scene that may change without a bake: materials, textures, and the assignment of materials to triangles.

use glam::{Vec3, Vec4};
use lapidary_core::{
    brdf::{Values, narrow_widths},
    material::{Material, MaterialMaps, MaterialPoint, ResolvedMaterial, SurfaceAttributes},
    opacity::Opacities,
    scene::{Mesh, Scene},
    surfel::MeshPlace,
    texture::{Texture, TextureSlot, UvFootprint},
};
use std::{collections::BTreeSet, ops::Deref, sync::Arc};

/// The material of each triangle, by index; `None` for the mesh's own.
pub type Assigned = Option<Arc<[u32]>>;

/// Materials and the textures that they refer to by index.
#[derive(Clone, Debug, Default)]
pub struct Appearance {
    /// One for each material index of the mesh, followed by assigned ones.
    pub materials: Vec<Material>,
    /// Shared: copying an appearance copies no texels.
    pub textures: Vec<Arc<Texture>>,
    /// Materials of triangles that differ from the mesh.
    pub assigned: Assigned,
}

impl Appearance {
    /// The scene's own appearance.
    pub fn of(scene: &Scene) -> Self {
        let (materials, assigned) = scene.materials_with_parts();
        Self { materials, textures: scene.textures.clone(), assigned }
    }

    /// Index of a triangle's material in `mesh`.
    pub(crate) fn material_of(&self, mesh: &Mesh, triangle: usize) -> u32 {
        self.assigned.as_ref().map_or_else(|| mesh.triangle_material[triangle], |assigned| assigned[triangle])
    }

    /// Whether both look the same: equal materials on equal triangles, and identical (not only equal) textures.
    pub fn is_same(&self, other: &Self) -> bool {
        let same_texture = |(a, b): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(a, b);
        self.materials == other.materials
            && same_assignment(&self.assigned, &other.assigned)
            && self.textures.len() == other.textures.len()
            && self.textures.iter().zip(&other.textures).all(same_texture)
    }

    /// Opacities of its surfaces.
    pub fn opacities(&self) -> Opacities {
        Opacities::of(&self.materials, &self.textures).assigned(self.assigned.clone())
    }

    /// Materials, before or after, of triangles that look different in `other`, by index. `None` if all may differ.
    pub(crate) fn changed_materials(&self, other: &Self) -> Option<Vec<usize>> {
        let mut changed = match (&self.assigned, &other.assigned) {
            (Some(a), Some(b)) => reassigned(a, b),
            (None, None) if self.materials.len() == other.materials.len() => BTreeSet::new(),
            _ => return None,
        };
        let same_texture = |index: u32| match [self, other].map(|looks| looks.textures.get(index as usize)) {
            [Some(a), Some(b)] => Arc::ptr_eq(a, b),
            [a, b] => a.is_none() && b.is_none(),
        };
        let same = |a: &Material, b: &Material| a == b && a.maps.slots().all(|slot| same_texture(slot.texture));
        let pairs = self.materials.iter().zip(&other.materials).enumerate();
        changed.extend(pairs.filter(|(_, (a, b))| !same(a, b)).map(|(index, _)| index));
        Some(changed.into_iter().collect())
    }

    /// The mean of a map within a footprint.
    pub(crate) fn sample(&self, slot: &TextureSlot, uv: &UvFootprint) -> Vec4 {
        match &slot.procedural {
            Some(pattern) => pattern.value(&uv.through(slot)),
            None => self.textures[slot.texture as usize].sample_footprint(uv, slot),
        }
    }

    /// Fits the appearance to the scene: a material for each of its `own` and for the assigned ones, without references to missing
    /// maps. Also returns the changes, in sentences.
    pub fn fitted(&self, own: &[Material]) -> (Self, Vec<String>) {
        let mut remarks = Vec::new();
        let given = self.materials.len();
        let needed = if self.assigned.is_some() { own.len().max(given) } else { own.len() };
        if given != needed {
            remarks.push(format!(
                "there are {given} materials for the {needed} of the scene; the missing ones are the scene's own"
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
        (Self { materials, textures: self.textures.clone(), assigned: self.assigned.clone() }, remarks)
    }
}

/// The width of a material's narrowest lobe, with any of its mapped parameters as low as it goes; infinite without a lobe.
pub(crate) fn narrowest_lobe(material: &Material) -> f32 {
    let mapped = material.own_parameters().iter().filter(|p| material.maps.get(p.name).is_some());
    let lowered = mapped.filter(|p| !p.is_color()).map(|p| {
        let mut lowered = material.clone();
        lowered.parameters.set(p.name, p.range[0]);
        lowered
    });
    let narrowest = |material: Material| {
        let widths = narrow_widths(material.plain_brdf().as_brdf().lobes());
        widths.into_iter().filter(|&width| width > 0.0).fold(f32::INFINITY, f32::min)
    };
    lowered.chain([material.clone()]).map(narrowest).fold(f32::INFINITY, f32::min)
}

/// An appearance with all values that are constant over a material precomputed.
#[derive(Clone, Debug, Default)]
pub struct ResolvedAppearance {
    appearance: Appearance,
    materials: Vec<ResolvedMaterial>,
}

impl From<Appearance> for ResolvedAppearance {
    fn from(appearance: Appearance) -> Self {
        Self { materials: ResolvedMaterial::all(&appearance.materials), appearance }
    }
}

impl Deref for ResolvedAppearance {
    type Target = Appearance;

    fn deref(&self) -> &Appearance {
        &self.appearance
    }
}

impl ResolvedAppearance {
    /// A material by its index.
    #[inline]
    pub(crate) fn material(&self, index: u32) -> &ResolvedMaterial {
        &self.materials[index as usize]
    }

    /// A material at the attributes of a point. Twin of `material_number` and `material_color` in `shaders/materials.wgsl`.
    #[inline]
    pub(crate) fn material_at(&self, material: &ResolvedMaterial, at: &SurfaceAttributes) -> MaterialPoint {
        material.at(at.color, |slot| self.sample(slot, at.uv_of(slot)))
    }

    /// The material at a point of `mesh`.
    pub(crate) fn at_place(&self, mesh: &Mesh, place: MeshPlace) -> MaterialPoint {
        self.material_at(self.material_there(mesh, place), &attributes_there(mesh, place))
    }

    /// The material of a point of `mesh`.
    pub(crate) fn material_there(&self, mesh: &Mesh, place: MeshPlace) -> &ResolvedMaterial {
        self.material(self.material_of(mesh, place.triangle as usize))
    }

    /// The values of the parameters at a point of `mesh`, after their maps.
    pub(crate) fn values_there(&self, mesh: &Mesh, place: MeshPlace) -> Values {
        let at = attributes_there(mesh, place);
        self.material_there(mesh, place).values(at.color, |slot| self.sample(slot, at.uv_of(slot)))
    }

    /// Albedo and emission of a point of `mesh`, for bounces: the albedo is the share of light reflected in all directions, the
    /// emission is radiance in W/(m² sr).
    pub fn albedo_and_emission(&self, mesh: &Mesh, place: MeshPlace) -> (Vec3, Vec3) {
        let point = self.at_place(mesh, place);
        (point.brdf.as_brdf().albedo(), point.emission)
    }

    /// The albedo of [`Self::albedo_and_emission`].
    #[cfg(test)]
    pub fn albedo(&self, mesh: &Mesh, place: MeshPlace) -> Vec3 {
        self.albedo_and_emission(mesh, place).0
    }
}

fn attributes_there(mesh: &Mesh, MeshPlace { triangle, barycentric: b }: MeshPlace) -> SurfaceAttributes {
    mesh.attributes(triangle as usize, [1.0 - b.element_sum(), b.x, b.y])
}

/// Whether both assign the same materials to the triangles of a mesh.
pub(crate) fn same_assignment(a: &Assigned, b: &Assigned) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b) || a == b,
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// Materials before and after, on triangles where they differ.
fn reassigned(before: &[u32], after: &[u32]) -> BTreeSet<usize> {
    let differing = before.iter().zip(after).filter(|(a, b)| a != b);
    differing.flat_map(|(&a, &b)| [a as usize, b as usize]).collect()
}
