//! A dataset ready for rendering: appearance, ray hierarchy, and the rig that lights its tree.

use crate::{
    appearance::{Appearance, ResolvedAppearance},
    baked::Baked,
    light::environment::{Illumination, LightRig, SceneLighting},
    shade::mirror::rays,
    stale::Marks,
};
use lapidary_core::{dataset::Dataset, offset, opacity::Opacities, ray::Intersector};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// A dataset ready for rendering.
pub struct Renderer {
    pub(crate) dataset: Arc<Dataset>,
    pub(crate) appearance: ResolvedAppearance,
    baked: Baked,
    opacities: Opacities,
    /// Materials that mirror, see [`rays::marks`].
    pub(crate) mirrors: Marks,
    /// Casts rays if opacities differ from the bake.
    own_rays: Option<Intersector>,
    /// Largest offset in meters of shadow ray origins from a surface.
    largest_offset: f32,
    /// Created at first use: path references do not need it.
    rig: OnceLock<Mutex<LightRig>>,
}

impl Renderer {
    /// Builds a ray hierarchy unless one exists, see [`Baked::intersector`]. The scene has the dataset's materials.
    pub fn new(baked: impl Into<Baked>) -> Self {
        let baked = baked.into();
        baked.intersector();
        let dataset = baked.dataset.clone();
        let appearance = Appearance::of(&dataset.scene);
        let mirrors = rays::marks(&appearance, dataset.tree.leaf_solid_angle());
        let largest_offset = offset::LARGEST * dataset.scene.mesh.bounds().diagonal();
        let opacities = baked.opacities();
        let (appearance, rig) = (appearance.into(), OnceLock::new());
        Self { dataset, appearance, baked, opacities, mirrors, own_rays: None, largest_offset, rig }
    }

    /// The same surfaces in a posed scene.
    pub fn posed(self, posed: Baked) -> Self {
        let mut renderer = Self { rig: self.rig, ..Self::new(posed) };
        renderer.take_appearance(self.appearance);
        renderer
    }

    /// Replaces the materials; there must be as many, or more with assigned ones.
    pub fn set_appearance(&mut self, appearance: Appearance) {
        self.take_appearance(appearance.into());
    }

    fn take_appearance(&mut self, appearance: ResolvedAppearance) {
        let (given, needed) = (appearance.materials.len(), self.dataset.scene.materials.len());
        assert!(
            given == needed || given > needed && appearance.assigned.is_some(),
            "one material for each index of the mesh"
        );
        let opacities = appearance.opacities();
        if opacities != self.opacities {
            self.take_opacities(opacities);
        }
        self.mirrors = rays::marks(&appearance, self.dataset.tree.leaf_solid_angle());
        self.appearance = appearance;
    }

    /// Makes rays use the current opacities. A new hierarchy is built only if other surfaces are thin.
    fn take_opacities(&mut self, opacities: Opacities) {
        let has_same_triangles = opacities.has_same_assignment(&self.opacities);
        if opacities.agree(&self.baked.opacities(), &self.dataset.scene.mesh) {
            self.own_rays = None;
        } else if !self.own_rays.as_mut().is_some_and(|rays| has_same_triangles && rays.take_opacities(&opacities)) {
            self.own_rays = Some(Intersector::quick(&self.dataset.scene.mesh, &opacities));
        }
        self.opacities = opacities;
    }

    /// The dataset.
    pub fn dataset(&self) -> &Arc<Dataset> {
        &self.dataset
    }

    /// Casts rays on the mesh, with the current opacities.
    pub fn intersector(&self) -> &Intersector {
        self.own_rays.as_ref().unwrap_or_else(|| self.baked.intersector())
    }

    /// Builds the thorough hierarchy, see [`Baked::refine`].
    pub(crate) fn refine(&self) {
        self.baked.refine();
    }

    /// The patch of each vertex, see [`Baked::patches`].
    pub(crate) fn patches(&self) -> Arc<[u8]> {
        self.baked.patches()
    }

    /// Largest offset in meters of shadow ray origins from a surface.
    pub(crate) fn largest_offset(&self) -> f32 {
        self.largest_offset
    }

    /// The tree under `light`, with an illumination cut of at most `illum_cut` nodes. Rotating or scaling an environment takes
    /// milliseconds, another environment somewhat more.
    pub fn lighting(&self, light: &Illumination, illum_cut: u32) -> SceneLighting {
        self.rig().lighting(light, illum_cut)
    }

    /// The rig that lights the tree, created at the first call.
    pub(crate) fn rig(&self) -> MutexGuard<'_, LightRig> {
        let rig = self.rig.get_or_init(|| Mutex::new(LightRig::new(&self.dataset.tree)));
        rig.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests;
